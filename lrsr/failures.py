"""How is what went wrong told in one line, and is it the user's to mend or ours?"""

import errno
import re
from collections.abc import Iterator, Sequence

from lrsr.errors import InputError
from lrsr.overrides import fields_of

_FULL = {errno.ENOSPC, errno.EDQUOT}
_TORCH_FULL = re.compile(r"No space left|iostream error|PytorchStreamWriter failed")


def explain(error: Exception, words: Sequence[str]) -> tuple[int, str]:
    """Return the exit status, 2 for the user's input and 1 for ours, and a line.

    Args:
        error: What reached the command line.
        words: The user's: what cannot be built of a setting among them is the user's to mend.
    """
    if line := _mendable(error, words):
        return 2, line
    hint = "the same command with --debug shows where"
    return 1, f"a fault of ours: {type(error).__name__}: {_one_line(error)} ({hint})"


def _mendable(error: Exception, words: Sequence[str]) -> str | None:
    from hydra.errors import HydraException, InstantiationException  # only on the way out
    from omegaconf import errors

    for cause in _behind(error, contexts=False):
        if isinstance(cause, UnicodeEncodeError) and cause.reason.startswith("surrogates"):
            name = cause.object[max(0, cause.start - 40) : cause.end + 40]
            return f"a name holds bytes that are no letters, in {name!r}: rename the file"
        if isinstance(cause, InputError):
            return _one_line(cause)
        if isinstance(cause, OSError) and (cause.filename or cause.errno == errno.ENOENT):
            place = cause.filename or "the working folder, or the one for temporary files"
            return f"cannot use {place}: {cause.strerror}; mend that or choose another"
    if any(map(_is_full_disk, _behind(error, contexts=True))):
        return "cannot write: no space left on the disk; free some or choose another folder"
    if isinstance(error, errors.MissingMandatoryValue | errors.InterpolationToMissingValueError):
        key = _one_line(error).rsplit(": ", maxsplit=1)[-1]
        return f"{key} must be given: add {key}=..."
    if isinstance(error, InstantiationException):
        return _not_built(error, words)
    merged = re.match(r"Error merging override \+*([^=]+)=(.*)", _one_line(error))
    if merged and isinstance(error.__cause__, TypeError):  # a list where there are settings
        return f"{merged[1]}={merged[2]}: wanted settings, one by one: {merged[1]}.NAME=..."
    if isinstance(error, HydraException | errors.OmegaConfBaseException):
        return _of_hydra(error)
    return None


def _of_hydra(error: Exception) -> str:
    if gone := re.search(r"Could not find '(.+)/(\w+)'\n.*\n\s*(.*)", str(error)):  # its own group
        return f"{gone[1]}={gone[2]}: not installed; there is {gone[3]}"
    place = getattr(error, "full_key", None)
    where = f"{place}: " if place and place not in str(error).splitlines()[0] else ""
    return f"{where}{_one_line(error)} (--cfg job prints every setting)"


def _behind(error: BaseException | None, *, contexts: bool) -> Iterator[BaseException]:
    """Yield an error and its causes; ``contexts``: what libraries hid behind one of their own."""
    while error is not None:
        yield error
        error = error.__cause__ or (error.__context__ if contexts else None)


def _is_full_disk(error: BaseException) -> bool:
    full = isinstance(error, OSError) and error.errno in _FULL
    return full or (isinstance(error, RuntimeError) and bool(_TORCH_FULL.search(str(error))))


def _not_built(error: Exception, words: Sequence[str]) -> str | None:
    """Say which field of which setting cannot be; None where the user has not touched it."""
    text = str(error)
    key = (re.search(r"full_key: (\S+)", text) or ["", ""])[1]
    target, field = re.search(r"target '([^']+)'", text), re.search(r"unexpected.*'(\w+)'", text)
    given = {word: word.partition("=")[0].lstrip("+") + "." for word in words}
    touched = [w for w, g in given.items() if g.startswith(f"{key}.") or f"{key}.".startswith(g)]
    if not touched:
        return None
    if field and target and (known := fields_of(target[1])):
        return f"no setting '{key}.{field[1]}': {key} has {', '.join(sorted(known))}"
    return f"{touched[-1]}: cannot build {key}: {_one_line(error.__cause__ or error)}"


def _one_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    if "Config search path:" in lines:  # Hydra's own folders help nobody
        lines = lines[: lines.index("Config search path:")]
    return "; ".join(line for line in lines if not line.startswith(("full_key", "object_type")))
