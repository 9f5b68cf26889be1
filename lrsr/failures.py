"""How is what went wrong told in one line, and is it the user's to mend or ours?"""

import errno
import re
from collections.abc import Iterator, Sequence

from lrsr.errors import InputError
from lrsr.overrides import fields_of

_FULL = {errno.ENOSPC, errno.EDQUOT}


def explain(error: Exception, words: Sequence[str]) -> tuple[int, list[str]]:
    """Return the exit status, 2 for the user's input and 1 for ours, and a line for each failure.

    Args:
        error: What reached the command line; a group holds those of a multirun.
        words: The user's: what cannot be built of a setting among them is the user's to mend.
    """
    if isinstance(error, ExceptionGroup):
        told = [explain(each, words) for each in error.exceptions]
        return min(status for status, _ in told), list(
            dict.fromkeys(line for _, lines in told for line in lines)
        )
    if (line := _mendable(error, words)) is not None:
        return 2, [line]
    kind = type(error).__name__
    hint = "the same command with --debug shows where"
    return 1, [f"a fault of ours: {kind}: {_one_line(error)} ({hint})"]


def _mendable(error: Exception, words: Sequence[str]) -> str | None:
    """Return what the user can mend; None: nothing."""
    from hydra.errors import HydraException, InstantiationException  # only on the way out
    from omegaconf.errors import (
        InterpolationToMissingValueError,
        MissingMandatoryValue,
        OmegaConfBaseException,
    )

    for cause in _causes(error):
        if isinstance(cause, InputError):
            return _one_line(cause)
        if isinstance(cause, OSError) and (line := _of_the_machine(cause)):
            return line
    if any(isinstance(cause, OSError) and cause.errno in _FULL for cause in _behind(error)):
        return "no space left on the disk: free some, or choose another folder"
    if isinstance(error, MissingMandatoryValue | InterpolationToMissingValueError):
        key = _one_line(error).rsplit(": ", maxsplit=1)[-1]
        return f"{key} must be given: add {key}=..."
    if isinstance(error, InstantiationException):
        return _not_built(error, words)
    if isinstance(error, HydraException | OmegaConfBaseException):
        return f"{_one_line(error)} (--cfg job prints every setting)"
    return None


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    while error is not None:
        yield error
        error = error.__cause__


def _behind(error: BaseException | None) -> Iterator[BaseException]:
    """Yield an error and what went wrong before it; libraries replace a full disk by their own."""
    while error is not None:
        yield error
        error = error.__cause__ or error.__context__


def _of_the_machine(error: OSError) -> str | None:
    if error.errno in _FULL:
        where = f"cannot write {error.filename}" if error.filename else "cannot write"
        return f"{where}: {error.strerror}; free space or choose another folder"
    if error.errno in {errno.EMFILE, errno.ENFILE}:
        return f"{error.strerror}: close other programs, or raise ulimit -n"
    if error.filename is None and not isinstance(error, FileNotFoundError):
        return None  # no file's
    where = f"{error.filename}: " if error.filename is not None else ""
    return f"{where}{error.strerror}; mend it or choose another"


def _not_built(error: Exception, words: Sequence[str]) -> str | None:
    """Say which field of which setting cannot be; None where the user has not touched it."""
    text, cause = str(error), error.__cause__
    place = re.search(r"full_key: (\S+)", text)
    target = re.search(r"target '([^']+)'", text)
    if place is None:
        return None
    key, touched = place[1], None
    for word in words:
        given = word.partition("=")[0].lstrip("+")
        if f"{given}.".startswith(f"{key}.") or f"{key}.".startswith(f"{given}."):
            touched = word
    if touched is None:
        return None
    field = re.search(r"unexpected keyword argument '([^']+)'", text)
    if field is not None and target is not None:
        known = ", ".join(sorted(fields_of(target[1]) or ()))
        return f"no setting {f'{key}.{field[1]}'!r}: {key} has {known}"
    return f"{touched}: cannot build {key}: {_one_line(cause or error)}"


def _one_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    if "Config search path:" in lines:  # Hydra's own folders help nobody
        lines = lines[: lines.index("Config search path:")]
    return "; ".join(line for line in lines if not line.startswith(("full_key", "object_type")))
