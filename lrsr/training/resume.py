"""May a run go on in this folder? Only if nothing that the weights depend on has changed.

Everything in the configuration counts but what ``_IRRELEVANT`` lists, so that a setting added
tomorrow counts too.
"""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import read_bytes
from lrsr.sr.weights import read_checkpoint
from lrsr.training.precision import choose_precision

#: What cannot change a weight: where things lie, how a run is told and when it goes on. A roster
#: counts by the people in it, a folder by its pictures and a start by its weights, wherever they
#: lie.
_IRRELEVANT = (
    "callbacks.progress",
    "data.root",
    "data.validation_root",
    "hydra",
    "identities.gallery",  # enrolled by lrsr eval alone
    "identities.roster",
    "logger",
    "module.start",
    "paths",
    "resume",
    "trainer.log_every_n_steps",
)
_AS_EVER = (("identities.photographs", None), ("identities.part", "all"))
"""As in runs of before there were such settings."""
_PRODUCTS = ("last.ckpt", "best.ckpt", "model.onnx", "model.toml", "model.safetensors")
_LENGTH = "trainer.max_epochs"
_LONGEST = 60


def what_matters(config: Mapping[str, Any]) -> dict[str, Any]:
    """Return what the weights depend on, by its dotted name.

    Args:
        config: The whole configuration in plain values, resolved.

    Example:
        >>> what_matters({"seed": 0, "identities": {"part": "all"}, "trainer": {"max_epochs": 4}})
        {'seed': 0, 'trainer.max_epochs': 4}
    """
    flat = dict(_flat(config))
    if flat.get("trainer.precision") == "auto":  # on another machine it may be another
        flat["trainer.precision"], _ = choose_precision(flat.get("trainer.accelerator", "auto"))
    return {
        name: value
        for name, value in flat.items()
        if (name, value) not in _AS_EVER
        and not any(name == other or name.startswith(f"{other}.") for other in _IRRELEVANT)
    }


def refuse_other_run(
    folder: Path, depends_on: Mapping[str, Any], *, follows_length: bool = True
) -> None:
    """Let only the same run go on in a folder, or a longer one; nothing is written here.

    Args:
        folder: Of the run.
        depends_on: What its weights depend on, in plain values.
        follows_length: Its weights do so from the first step on, by a schedule that is as long as
            the run; else it may have more epochs than before.

    Raises:
        InputError: The folder holds a run that depends on something else, or a broken checkpoint.
    """
    last = folder / "last.ckpt"
    source = last if last.is_file() else folder / "metrics.json"
    before = read_checkpoint(last).get("depends_on", {}) if last.is_file() else _begun(source)
    if before is None:
        return
    now = json.loads(json.dumps(dict(depends_on)))  # lists for tuples, as the record has them
    missing = "(none)"
    for name in [*now, *(name for name in before if name not in now)]:
        old, new = before.get(name, missing), now.get(name, missing)
        longer = name == _LENGTH and type(old) is type(new) is int and new > old
        if old != new and (follows_length or not longer):
            why = ", and its scheduler is as long as the run" if longer else ""
            raise InputError(
                f"{source} was trained with {name}={_short(old)}, this run has"
                f" {name}={_short(new)}{why}: choose another folder with"
                " paths.run=..., the same setting, or resume=false to begin again"
            )


def forget(folder: Path) -> None:
    """Remove what an earlier run left in its folder, so that nothing of it is taken for the new."""
    for name in (*_PRODUCTS, "metrics.json"):
        (folder / name).unlink(missing_ok=True)


def _begun(path: Path) -> dict[str, Any] | None:
    """Return what a run that has no checkpoint depends on; None if there is none, or no epoch."""
    try:
        record = json.loads(read_bytes(path))
        begun: dict[str, Any] | None = record.get("settings")
        return None if record.get("history") == [] else begun
    except (OSError, ValueError, AttributeError):
        return None


def _flat(values: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for name, value in values.items():
        if isinstance(value, Mapping) and value:
            yield from _flat(value, f"{prefix}{name}.")
        else:
            yield f"{prefix}{name}", value


def _short(value: object) -> str:
    text = str(value)
    return text if len(text) <= _LONGEST else f"{text[:_LONGEST]}..."
