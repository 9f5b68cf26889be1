"""What did the user mean by ``key=value``? The same in Hydra's words, or an error naming the key.

What the configuration has can be changed. What it has not can be added, with or without Hydra's
``+``, where something reads it: below ``_OPEN``, and as a field of whatever has a ``_target_``.
No value need be quoted for Hydra. A comma in a path is part of its name, but in a multirun it
stands between two values, unless they are quoted: ``out='"a,b"'``.
"""

import inspect
import logging
import os
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from dataclasses import dataclass
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from lrsr.errors import InputError
from lrsr.paths import user_path

if TYPE_CHECKING:
    from omegaconf import DictConfig

_OPEN = {
    *("sr", "fusion", "conditions", "axes", "generic"),
    *("trainer", "callbacks", "logger", "optimizer", "scheduler"),
}
"""Sections that take parts under any name."""

_TRAINED = {"sr", "recognition", "reconstructor"}
"""Settings of other commands that name, in ``lrsr train``, what is trained."""
_HYDRAS = ("hydra.", "hydra/")
_EXTRA = "debug"  # the group that no command has from the start
_PATHS = {
    "out",
    "export",
    "images",
    "run",
    "runs",
    "cache",
    "model",
    "roster",
    "people",
    "map",
    "weights",
    "root",
    "validation_root",
    "contract",
    "mirror",
    "lpips",
    "folder",
    "scores",
    "generic_scores",
    "real_scores",
    "files",
    "ages",
    "generator",
    "boundaries",
    "annotations",
    "galleries",
    "probes",
    "probe",
    "enrolled",
    "reconstructor",
    "path",
}
_FOLDERS = ("gallery", "probes")
"""Sections whose ``folder`` may be given as if it were all of them."""
_WITH_FOLDERS = ("eval", "demo")
_LISTS = {"images", "files", "galleries"}
"""Paths that may be several: [a,b] is a list."""
_QUOTED = r'"(?:[^"\\]|\\.)*"|' + r"'(?:[^'\\]|\\.)*'"
_WORD = re.compile(r"(~|\+{0,2})([^=@]*)(@[^=]*)?(?:=(.*))?", re.DOTALL)

logger = logging.getLogger(__name__)


class _Word(NamedTuple):
    sign: str
    key: str
    package: str  # with its @
    value: str
    typed: str

    def __str__(self) -> str:
        return f"{self.key}{self.package}={self.value}"


@dataclass(frozen=True)
class Overrides:
    """How to read the words after ``lrsr COMMAND``.

    Attributes:
        command: The configuration's name.
        folders: Where configurations lie, the main one first.
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
        groups, settings = self._parted(words)
        mended = groups + [self._setting(word) for word in settings]
        if any(not word.startswith(_HYDRAS) for word in mended):
            self._check(settings, self._composed(groups))
        return mended

    def unchecked(
        self, words: Sequence[str]
    ) -> tuple[list[str], "Callable[[DictConfig], None]", AbstractContextManager[None]]:
        """Return the same without a look at the keys, and what looks at them.

        To be called with what Hydra has composed of the groups, within the context that is
        returned last and says why it cannot compose, it saves composing twice.

        Raises:
            InputError: An option does not exist, or a value is missing or unreadable.
        """
        groups, settings = self._parted(words)
        mended = groups + [self._setting(word) for word in settings]
        return mended, partial(self._check, settings), self._explained(groups)

    @contextmanager
    def _explained(self, words: list[str]) -> Iterator[None]:
        """Explain why Hydra cannot compose.

        Raises:
            HydraException: The files cannot be composed.
            InputError: The command has no such group, or two choices do not go together.
        """
        from hydra.errors import HydraException

        try:
            yield
        except HydraException as error:
            if group := re.search(r"Could not override '([^'.]+)'", str(error)):
                said = " ".join([self.command, *(w for w in words if w.startswith("train="))])
                raise InputError(f"lrsr {said} has no {group[1]} to choose") from error
            for word in words:
                rest = [one for one in words if one is not word]
                with suppress(HydraException):
                    self._compose(rest)
                    raise InputError(
                        f"{word}: does not go with {', '.join(rest)}; leave it, or choose another"
                    ) from error
            raise

    def _parted(self, words: Sequence[str]) -> tuple[list[str], list[_Word]]:
        """Return what chooses, as Hydra reads it, and the settings.

        Raises:
            InputError: An option does not exist, or a value is missing.
        """
        read = [self._read(word) for word in words]
        networks = [text for text, word in zip(words, read, strict=True) if word.key == "train"]
        if len(networks) > 1:
            raise InputError(f"{' and '.join(networks)}: give one of them to train")
        latest = {word.key + word.package: word for word in read}
        if len(latest) < len(read):
            repeated = sorted({word.key for word in read if word not in latest.values()})
            logger.warning("given twice, the last counts: %s", ", ".join(repeated))
        hydras = [word for word in latest.values() if word.key.startswith(_HYDRAS)]
        groups = [word for word in latest.values() if self._options(word.key)]
        others = [word for word in latest.values() if word not in {*hydras, *groups}]
        chosen = [f"{word.sign}{word}" for word in hydras]
        return chosen + [self._choice(word) for word in groups], others

    def _read(self, text: str) -> _Word:
        found = _WORD.fullmatch(text)
        sign, key, package, value = found.groups() if found else ("", "", None, None)
        if not key or (value is None and sign != "~"):
            raise InputError(f"{text!r}: write key=value, without blanks around =")
        value = value or ""
        if sign != "~" and not value.strip():
            raise InputError(f"{key}=: give a value, or null for none")
        if key == "recognition" and sign != "~" and self._options(key):
            key, value = self._recognisers(value)
        if key in _FOLDERS and sign != "~" and not package and self._is_folder(key, value):
            key = f"{key}.folder"
        # lrsr train sr=NAME, recognition=NAME and reconstructor=NAME mean train=NAME.
        if self.command == "train" and key in _TRAINED and self._options("train"):
            key = "train"
        return _Word(sign, key, package or "", value, text)

    def _recognisers(self, value: str) -> tuple[str, str]:
        """Let ``recognition=`` name recognisers where it names no option of the group."""
        names = re.findall(rf"{_QUOTED}|[^\[\],]+", value)
        if self.command == "train" or {*names} <= self._options("recognition"):
            return "recognition", value
        quoted = ",".join(quoted_word(name.strip()) for name in names)
        return "recognition.recognisers", f"[{quoted}]" if value.startswith("[") else quoted

    def _is_folder(self, key: str, value: str) -> bool:
        """Tell whether ``gallery=`` or ``probes=`` names a folder of photographs: no option."""
        options = self._options(key)
        if not options:  # there is nothing else to choose
            return self.command in _WITH_FOLDERS
        plain = re.sub(r"""^(["'])(.*)\1$""", r"\2", value)
        return value not in options and (os.sep in plain or user_path(plain).is_dir())

    def _options(self, group: str) -> set[str]:
        if not re.fullmatch(r"[\w/-]+", group):
            return set()
        return {p.stem for folder in self.folders for p in (folder / group).glob("*.yaml")}

    def _choice(self, word: _Word) -> str:
        """Return ``group=option``; Hydra's + only where Hydra wants one.

        Raises:
            InputError: There is no such option.
        """
        options = sorted(self._options(word.key))
        names = re.findall(r"[^\[\],\s]+", word.value)
        function = self.sweep and "(" in word.value
        wrong = [name for name in names if name not in options and not function]
        if word.sign == "~" or not names or wrong:
            hint = (wrong and _meant(wrong[0], options)) or f": choose one of {', '.join(options)}"
            raise InputError(f"{word.typed}: no such option{hint}")
        if len(names) > 1 and not (self.sweep or word.value.startswith("[")):
            raise InputError(f"{word}: add -m to run one after the other")
        added = word.key == _EXTRA or not (self.folders[0] / word.key).is_dir() or word.package
        return f"{'+' if added and (word.sign or word.key == _EXTRA) else ''}{word}"

    def _composed(self, words: list[str]) -> "DictConfig":
        """Compose what can be changed, of a sweep's options the first.

        Raises:
            HydraException: The files cannot be composed.
            InputError: The command has no such group, or two choices do not go together.
        """
        with self._explained(words):
            return self._compose(words)

    def _compose(self, words: list[str]) -> "DictConfig":
        from hydra import compose, initialize_config_dir  # a quarter of a second

        search = ",".join(quoted_word(f"file://{folder}") for folder in self.folders[1:])
        firsts = [re.sub(r"=([^,\[]+),.*", r"=\1", word) for word in words if "(" not in word]
        with initialize_config_dir(str(self.folders[0]), version_base="1.3"):
            return compose(self.command, [f"hydra.searchpath=[{search}]", *firsts])

    def _setting(self, word: _Word) -> str:
        """Return ``++key=value`` (Hydra changes or adds it), or ``~key`` of an open section.

        Raises:
            InputError: It cannot be taken away, or its value is unreadable.
        """
        if word.sign != "~":
            return f"++{word.key}={_readable(word, self.sweep)}"
        if word.key.partition(".")[0] not in _OPEN:
            raise InputError(f"~{word.key}: cannot be taken away; give it another value")
        return f"~{word.key}"

    def _check(self, settings: Sequence[_Word], config: "DictConfig") -> None:
        """Refuse settings that nothing reads.

        Raises:
            InputError: There is no such setting.
        """
        from omegaconf import OmegaConf

        plain: Any = OmegaConf.to_container(config, resolve=False)
        base = {key: node for key, node in plain.items() if key != "hydra"}
        for word in settings:
            self._check_key(word.key + word.package, base)

    def _check_key(self, key: str, base: dict[str, Any]) -> None:
        node: Any = base
        above: list[Any] = []
        parts = key.split(".")
        for part in parts:
            inner = _inner(node, part)
            if inner is None:
                break
            above.append(node)
            node = inner[0]
        if len(above) == len(parts):
            return
        outer, part = parts[: len(above)], parts[len(above)]
        if above and isinstance(node, dict) and "_target_" in node:
            fields = sorted(fields_of(node["_target_"]) or [part])
            if part not in fields and not part.startswith("_"):
                hint = f"{_meant(part, fields)}; {'.'.join(outer)} has {', '.join(fields)}"
                raise InputError(f"no setting {key!r}{hint}")
        elif not isinstance(node, dict | None) or not (_OPEN & {*outer} or _is_built(above[1:])):
            section = ".".join(outer) if isinstance(node, dict) else ""
            known = [name for name in (*_keys(base), *self._groups()) if name != section]
            hint = _meant(key, known)
            if section and not hint:
                hint = f"; {section} has {', '.join(sorted(map(str, node)))}"
            if parts[0] not in base and parts[0] in self._options("experiment") and parts[1:]:
                hint = f": it is one of experiment={parts[0]}"
            hint = hint or f": lrsr {self.command} --help lists them"
            raise InputError(f"no setting {key!r}{hint}")

    def _groups(self) -> list[str]:
        """Name the groups that the command chooses from, but those of ``common.yaml``."""
        from omegaconf import OmegaConf

        main: Any = OmegaConf.load(self.folders[0] / f"{self.command}.yaml")
        return [
            _EXTRA,
            *(str(name) for one in main.defaults if not isinstance(one, str) for name in one),
        ]


def fields_of(target: str) -> set[str] | None:
    """Return what a ``_target_`` can be given by name; None: anything.

    Raises:
        InputError: There is no such target.
    """
    from hydra.utils import get_object

    try:
        parameters = inspect.signature(get_object(target)).parameters
    except Exception as error:  # whatever the import of the user's own module raises
        raise InputError(f"_target_={target}: {error}") from error
    return None if any(p.kind is p.VAR_KEYWORD for p in parameters.values()) else {*parameters}


def pieces_of(text: str, sweep: bool) -> list[str]:
    """Return the values of a sweep, or the only one; those that the user quoted stay quoted.

    Example:
        >>> pieces_of('x,"a,b"', sweep=True)
        ['x', '"a,b"']
    """
    return re.findall(rf"{_QUOTED}|[^,]+", text) if sweep else [text]


def _readable(word: _Word, sweep: bool) -> str:
    """Return the value as Hydra can parse it.

    Raises:
        InputError: It cannot be told what is meant.
    """
    from hydra.errors import HydraException

    kind, text = "", word.value
    is_path = word.key.rpartition(".")[2] in _PATHS
    if word.key.rpartition(".")[2] in _LISTS and re.fullmatch(r"\[.*\]", text, re.DOTALL):
        is_path = False
    try:
        kind = _kind(text)
    except (HydraException, ValueError) as error:  # ValueError: thousands of digits
        if not is_path and text.lstrip().startswith(("[", "{")):
            reason = str(error).splitlines()[0]
            raise InputError(f"{word}: {reason}; write {word.key}='\"...\"'") from error
        text = text if is_path else quoted_word(text)
    if is_path and kind not in {"CHOICE_SWEEP", "RANGE_SWEEP"}:
        pieces = pieces_of(text, sweep)
        return ",".join(piece if piece == "null" else quoted_word(piece) for piece in pieces)
    if "SWEEP" in kind and not sweep:
        raise InputError(f"{word}: write [...] for a list, or add -m to run one after the other")
    return text


def quoted_word(text: str) -> str:
    """Return a word as Hydra reads it, whatever is in it; one that is quoted stays as it is."""
    from hydra.core.override_parser.types import Quote, QuotedString

    if re.fullmatch(_QUOTED, text, re.DOTALL):
        return text
    return QuotedString(text, Quote.double).with_quotes()


def _kind(text: str) -> str:
    from hydra.core.override_parser.overrides_parser import OverridesParser

    return getattr(OverridesParser.create().parse_override(f"key={text}").value_type, "name", "")


def _inner(node: Any, part: str) -> tuple[Any] | None:
    number = int(part) if part.isdigit() else -1
    if isinstance(node, list):
        return (node[number],) if 0 <= number < len(node) else None
    names = [name for name in (part, number) if isinstance(node, dict) and name in node]
    return (node[names[0]],) if names else None


def _is_built(nodes: list[Any]) -> bool:
    return any("_target_" in node for node in nodes if isinstance(node, dict))


def _keys(node: dict[Any, Any], place: str = "") -> Iterator[str]:
    for key, inner in node.items():
        yield f"{place}{key}"
        yield from _keys(inner, f"{place}{key}.") if isinstance(inner, dict) else ()


def _meant(word: str, known: Sequence[str]) -> str:
    """Return ": did you mean ...?", or nothing where nothing is near."""
    inner = [key for key in known if key.rpartition(".")[2] == word]
    last = {key.rpartition(".")[2]: key for key in reversed(known)}
    near = inner or get_close_matches(word, known, 1, 0.7 if "." in word else 0.6)
    near = near or [last[name] for name in get_close_matches(word.rpartition(".")[2], last, 1, 0.8)]
    return f": did you mean {' or '.join(near)}?" if near else ""
