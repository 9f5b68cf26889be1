"""How does a composed configuration become typed values, with an error that names the setting?"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from lrsr.errors import InputError
from lrsr.files import fresh_folder, locked, make_folder
from lrsr.paths import user_path

if TYPE_CHECKING:
    from omegaconf import DictConfig

Schema = TypeVar("Schema")

LIMITS: dict[str, tuple[type, float, float]] = {
    "seed": (int, 0, 2**32 - 1),
    "ipd_px": (float, 4, 1024),
    "identities.start": (int, 0, 10**10),
    "identities.count": (int, 1, 10**6),
    "rendering.samples_per_pixel": (int, 1, 2**20),
    "rendering.texture_size": (int, 64, 8192),
    "rendering.max_depth": (int, 1, 1000),
    "gallery.ipd_px": (float, 4, 1024),
    "gallery.samples_per_pixel": (int, 1, 2**20),
    "data.ipd_px": (float, 4, 1024),
}
"""Smallest and largest value of what more than one command is given; the same in all of them."""


def check_limits(config: "DictConfig") -> None:
    """Refuse a configuration with a number out of its range, before anything is done.

    Raises:
        InputError: A value is out of :data:`LIMITS`, or of another type.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    for key, (kind, low, high) in LIMITS.items():
        given = OmegaConf.select(config, key, throw_on_missing=False)
        require(given != [], key, given, "a number")
        for value in () if given is None else _listed(given):
            found = _whole(value, key) if kind is int else _number(value, key)
            require(low <= found <= high, key, value, f"at least {low} and at most {high}")


@contextmanager
def run_folder(config: "DictConfig") -> Iterator[Path]:
    """Make the folder of this run and keep it to this process until the block ends.

    It is ``paths.run``, usable again to go on, with the job's number below it in a multirun; where
    that is null, a fresh one: ``RUNS/COMMAND/DATE_TIME``, with -2, -3 ... if that is taken.

    Raises:
        InputError: It cannot be made or written, or another process works in it.
    """
    from hydra.core.hydra_config import HydraConfig  # loaded by then
    from hydra.types import RunMode

    hydra = HydraConfig.get()
    if config.paths.run is None:
        name = f"{datetime.now():%Y-%m-%d_%H-%M-%S}"
        folder = fresh_folder(user_path(config.paths.runs) / str(hydra.job.config_name) / name)
    else:
        sweep = hydra.mode == RunMode.MULTIRUN
        folder = make_folder(user_path(config.paths.run) / (str(hydra.job.num) if sweep else ""))
    with locked(folder, wait=False):
        yield folder


def section(schema: type[Schema], config: "DictConfig", key: str) -> Schema:
    """Read one section of a configuration into a dataclass, checking the types of its fields.

    Raises:
        InputError: A value has the wrong type or is out of range; the message names the setting.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway
    from omegaconf.errors import OmegaConfBaseException

    try:
        given = OmegaConf.to_container(config[key], resolve=True)  # while it has its parents
        merged = OmegaConf.merge(OmegaConf.structured(schema), given)
        values = OmegaConf.to_container(merged, resolve=True)
    except OmegaConfBaseException as error:
        place = getattr(error, "full_key", None)
        name = f"{key}.{place}" if place else key
        reason = str(error).splitlines()[0]
        if "is not a ListConfig" in reason:
            reason = f"wanted a list, e.g. {name}=[...]"
        raise InputError(f"{name}: {reason}") from error
    fields: dict[str, Any] = values  # type: ignore[assignment]  # those of the schema
    for field, value in fields.items():
        if isinstance(value, float):
            _number(value, f"{key}.{field}")
    return schema(**fields)


def number(config: "DictConfig", key: str) -> float:
    """Read a number.

    Raises:
        InputError: It is none.
    """
    return _number(config[key], key)


def whole_number(config: "DictConfig", key: str) -> int:
    """Read a whole number.

    Raises:
        InputError: It is none.
    """
    return _whole(config[key], key)


def numbers(config: "DictConfig", key: str) -> list[float]:
    """Read a list of numbers; one number is a list of one.

    Raises:
        InputError: Something in it is no number.
    """
    return [_number(value, key) for value in _listed(config[key])]


def whole_numbers(config: "DictConfig", key: str) -> list[int]:
    """Read a list of whole numbers; one number is a list of one.

    Raises:
        InputError: Something in it is no whole number.
    """
    return [_whole(value, key) for value in _listed(config[key])]


def flag(config: "DictConfig", key: str) -> bool:
    """Read true or false.

    Raises:
        InputError: It is neither.
    """
    value = config[key]
    require(isinstance(value, bool), key, value, "true or false")
    return bool(value)


def numbered(config: "DictConfig", key: str) -> dict[int, dict[str, Any]]:
    """Read a section whose parts have numbers, changed one by one on the command line.

    A file's ``1:`` is a number and the line's ``conditions.1.pose=left`` a word: they are one part.

    Raises:
        InputError: A part has no number, or is no section.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    parts: dict[int, dict[str, Any]] = {}
    table: Any = OmegaConf.to_container(config[key], resolve=True)
    for name, part in table.items():
        require(str(name).isdigit(), f"{key}.{name}", "...", f"a number, such as {key}.7")
        require(isinstance(part, dict), f"{key}.{name}", part, f"{key}.{name}.SETTING=...")
        parts.setdefault(int(name), {}).update(part)
    return parts


def words(config: "DictConfig", key: str) -> list[str]:
    """Read a list of words; one word is a list of one."""
    return [str(value) for value in _listed(config[key])]


def require(holds: bool, key: str, value: object, wanted: str) -> None:
    """Refuse a value out of range.

    Raises:
        InputError: It does not hold.
    """
    if not holds:
        raise InputError(f"{key}={_typed(value)}: wanted {wanted}")


def _typed(value: object) -> object:
    """Return a value as it is typed on the command line."""
    return "null" if value is None else str(value).lower() if isinstance(value, bool) else value


def _listed(value: object) -> list[object]:
    from omegaconf import ListConfig  # loaded by Hydra anyway

    return list(value) if isinstance(value, ListConfig | list | tuple) else [value]


def _number(value: object, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key}={_typed(value)}: wanted a number")
    require(abs(value) <= sys.float_info.max, key, value, "a finite number")
    return float(value)


def _whole(value: object, key: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError(f"{key}={_typed(value)}: wanted a whole number")
    return value
