"""What did the user mean by ``key=value``? The same in Hydra's words, or an error naming the key.

What the configuration has can be changed. What it has not can be added, with or without Hydra's
``+``, where something reads it: below :data:`OPEN`, and as a field of whatever has a ``_target_``.
No value need be quoted for Hydra. A comma in a path is part of its name, but in a multirun it
stands between two values, unless they are quoted: ``out='"a,b"'``.
"""

import inspect
import logging
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from lrsr.errors import InputError

OPEN = frozenset({"sr", "conditions", "trainer", "callbacks", "logger", "optimizer", "scheduler"})
"""Sections that take parts under any name."""

EXTRA = frozenset({"debug"})
"""Groups that no command has from the start: ``+debug=smoke``."""

_PATHS = frozenset(
    {"out", "images", "run", "runs", "cache", "model", "roster", "map", "weights", "root"}
)
_QUOTED = r'"(?:[^"\\]|\\.)*"|' + r"'(?:[^'\\]|\\.)*'"
_WORD = re.compile(r"(\+{0,2}|~)([^=@]*)(@[^=]*)?(?:=(.*))?", re.DOTALL)
_ABSENT = object()

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class _Word:
    """One word: ``sign`` is +, ++, ~ or nothing; ``package`` begins with @; ``value`` may be ""."""

    sign: str
    key: str
    package: str
    value: str

    def __str__(self) -> str:
        return f"{self.key}{self.package}={self.value}"

    @property
    def for_hydra(self) -> bool:
        return self.key.startswith(("hydra.", "hydra/"))


@dataclass(frozen=True)
class Overrides:
    """How to read the words after ``lrsr COMMAND``.

    Attributes:
        command: The configuration's name.
        folders: Where configurations lie, the shipped one first.
        sweep: A multirun.
    """

    command: str
    folders: Sequence[Path]
    sweep: bool = False

    def mended(self, words: Sequence[str]) -> list[str]:
        """Return the words as Hydra reads what was meant, groups first.

        Raises:
            InputError: A key or an option does not exist, or a value is missing or unreadable.
        """
        read = self._trained([_read(word) for word in words])
        latest = {f"{word.key}{word.package}": word for word in read}
        if len(latest) < len(read):
            repeated = sorted({word.key for word in read if word not in latest.values()})
            logger.warning("given twice, the last counts: %s", ", ".join(repeated))
        kept = list(latest.values())
        settings = [word for word in kept if not (word.for_hydra or self._is_group(word))]
        choices = [self._choice(word) for word in kept if self._is_group(word)]
        hydra = [f"{word.sign}{word}" for word in kept if word.for_hydra]
        if not settings and not choices:
            return hydra
        # Of a sweep's choices the first: their options have the same settings.
        firsts = [re.sub(r"=([^,\[]+),.*", r"=\1", word) for word in choices if "(" not in word]
        base = self._composed(firsts)
        return [*hydra, *choices, *(self._setting(word, base) for word in settings)]

    def _trained(self, words: list[_Word]) -> list[_Word]:
        """Let ``lrsr train`` be told ``sr=NAME`` or ``recognition=NAME`` for ``train=NAME``.

        Raises:
            InputError: It is told several.
        """
        if self.command != "train" or not self._options("train"):
            return words
        what = [word for word in words if word.key in {"sr", "recognition", "train"}]
        if len(what) > 1:
            given = " and ".join(str(word) for word in what)
            raise InputError(f"{given}: give one of them to train")
        return [replace(word, key="train") if word in what else word for word in words]

    def _options(self, group: str) -> list[str]:
        found = [path for folder in self.folders for path in (folder / group).glob("*.yaml")]
        return sorted({path.stem for path in found})

    def _is_group(self, word: _Word) -> bool:
        return re.fullmatch(r"[\w/-]+", word.key) is not None and bool(self._options(word.key))

    def _choice(self, word: _Word) -> str:
        """Return ``group=option``; Hydra's + only where Hydra wants one.

        Raises:
            InputError: There is no such option.
        """
        options = self._options(word.key)
        names = re.findall(r"[^\[\],\s]+", word.value)
        if word.sign == "~" or not names:
            raise InputError(f"{word}: choose one of {', '.join(options)}")
        for name in names if "(" not in word.value else ():
            if not any((folder / word.key / f"{name}.yaml").is_file() for folder in self.folders):
                raise InputError(f"{word}: no {name!r} in {word.key}{_meant(name, options)}")
        shipped = (self.folders[0] / word.key).is_dir() and word.key not in EXTRA
        plus = "" if shipped and not word.package else "+" if word.sign or word.key in EXTRA else ""
        return f"{plus}{word}"

    def _composed(self, words: list[str]) -> dict[str, Any]:
        from hydra import compose, initialize_config_dir  # a quarter of a second
        from hydra.errors import HydraException
        from omegaconf import OmegaConf

        search = ",".join(_quoted(f"file://{folder}") for folder in self.folders[1:])
        words = [*words, f"hydra.searchpath=[{search}]"]
        try:
            with initialize_config_dir(str(self.folders[0]), version_base="1.3"):
                composed = compose(self.command, words)
        except HydraException as error:
            group = re.search(r"Could not override '([^']+)'", str(error))
            if group is None:
                raise
            raise InputError(
                f"no {group[1]} to choose here: lrsr {self.command} --help lists what there is"
            ) from error
        plain: dict[str, Any] = OmegaConf.to_container(composed, resolve=False)  # type: ignore[assignment]
        return plain

    def _setting(self, word: _Word, base: dict[str, Any]) -> str:
        """Return ``++key=value`` (Hydra changes or adds it), or ``~key``.

        Raises:
            InputError: There is no such setting, or it cannot be taken away or read.
        """
        missing = self._check_key(word.key + word.package, base)
        if word.sign == "~":
            if missing or word.key.partition(".")[0] not in OPEN or "." not in word.key:
                raise InputError(f"~{word.key}: cannot be taken away; give it another value")
            return f"~{word.key}"
        return f"++{word.key}={_readable(word, self.sweep)}"

    def _check_key(self, key: str, base: dict[str, Any]) -> bool:
        """Return whether the key is an addition.

        Raises:
            InputError: It is none that anything reads.
        """
        node: Any = base
        parts = key.split(".")
        above: list[Any] = []
        while parts[len(above) :] and (inner := _inner(node, parts[len(above)])) is not _ABSENT:
            above.append(node)
            node = inner
        if len(above) == len(parts):
            return False
        place, part = ".".join(parts[: len(above)]), parts[len(above)]
        if isinstance(node, dict) and "_target_" in node:
            fields = fields_of(node["_target_"])
            if fields is not None and part not in fields and not part.startswith("_"):
                raise InputError(f"no setting {key!r}: {place} has {', '.join(sorted(fields))}")
            return True
        built = any("_target_" in outer for outer in above if isinstance(outer, dict))
        opened = built or OPEN & set(parts[: len(above)])
        if not (opened and (node is None or isinstance(node, dict))):
            known = [*_keys(base), *(folder.name for folder in self.folders[0].glob("*/"))]
            hint = _meant(key, known) or f": lrsr {self.command} --help lists them"
            raise InputError(f"no setting {key!r}{hint}")
        return True


def fields_of(target: str) -> "set[str] | None":
    """Return what a ``_target_`` can be given by name; None: anything.

    Raises:
        InputError: There is no such target.
    """
    from hydra.utils import get_object

    try:
        parameters = inspect.signature(get_object(target)).parameters
    except Exception as error:  # whatever the import of the user's own module raises
        raise InputError(f"_target_={target}: {error}") from error
    if any(p.kind is p.VAR_KEYWORD for p in parameters.values()):
        return None
    return set(parameters)


def _read(text: str) -> _Word:
    found = _WORD.fullmatch(text)
    sign, key, package, value = found.groups() if found else ("", "", None, None)
    if not key or (value is None and sign != "~"):
        raise InputError(f"{text!r}: write key=value, without blanks around =")
    if sign != "~" and not (value or "").strip():
        raise InputError(f"{key}=: give a value, or null for none")
    return _Word(sign, key, package or "", value or "")


def _readable(word: _Word, sweep: bool) -> str:
    """Return the value as Hydra can parse it.

    Raises:
        InputError: It cannot be told what is meant.
    """
    text = word.value
    if word.key.rpartition(".")[2] in _PATHS and not _is_function(word):
        pieces = pieces_of(text, sweep)
        return ",".join(piece if piece == "null" else _quoted(piece) for piece in pieces)
    reason = _refusal(word)
    if reason and not text.lstrip().startswith(("[", "{")):
        text = _quoted(text)
        reason = _refusal(replace(word, value=text))
    if reason:
        raise InputError(f"{word}: {reason}; quote what Hydra cannot read: {word.key}='\"...\"'")
    if not sweep and re.search(r"SWEEP", _kind(replace(word, value=text))):
        raise InputError(f"{word}: write [...] for a list, or add -m to run one after the other")
    return text


def pieces_of(text: str, sweep: bool) -> list[str]:
    """Return the values of a sweep, or the only one; those that the user quoted stay quoted.

    Example:
        >>> pieces_of('x,"a,b"', sweep=True)
        ['x', '"a,b"']
    """
    return re.findall(rf"{_QUOTED}|[^,]+", text) if sweep else [text]


def _quoted(text: str) -> str:
    from hydra.core.override_parser.types import Quote, QuotedString

    if re.fullmatch(_QUOTED, text, re.DOTALL):
        return text
    return QuotedString(text, Quote.double).with_quotes()


def _parsed(word: _Word) -> Any:
    from hydra.core.override_parser.overrides_parser import OverridesParser

    return OverridesParser.create().parse_override(f"key={word.value}")


def _refusal(word: _Word) -> str:
    from hydra.errors import HydraException

    try:
        _parsed(word)
    except (HydraException, ValueError) as error:  # ValueError: a number of thousands of digits
        return str(error).splitlines()[0]
    return ""


def _kind(word: _Word) -> str:
    return str(_parsed(word).value_type)


def _is_function(word: _Word) -> bool:
    """Tell whether the value is ``choice(a,b)`` or another of Hydra's sweeps."""
    return not _refusal(word) and re.search(r"\.(CHOICE|RANGE|GLOB)", _kind(word)) is not None


def _inner(node: Any, part: str) -> Any:
    if isinstance(node, dict):
        number = int(part) if part.isdigit() else part
        return node.get(part, node.get(number, _ABSENT))
    if isinstance(node, list) and part.isdigit() and int(part) < len(node):
        return node[int(part)]
    return _ABSENT


def _keys(node: Any, place: str = "") -> Iterator[str]:
    for key, inner in node.items():
        yield f"{place}{key}"
        if isinstance(inner, dict):
            yield from _keys(inner, f"{place}{key}.")


def _meant(word: str, known: Sequence[str]) -> str:
    """Return ": did you mean ...?", or nothing where nothing is near."""
    last = {key.rpartition(".")[2]: key for key in reversed(known)}
    near = get_close_matches(word, known, n=1)
    near += [last[name] for name in get_close_matches(word.rpartition(".")[2], last, n=1)]
    return f": did you mean {near[0]}?" if near else ""
