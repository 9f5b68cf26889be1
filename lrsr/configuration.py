"""How does a composed configuration become typed values, with an error that names the setting?"""

import math
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields
from datetime import datetime
from decimal import Decimal
from functools import cache, lru_cache
from numbers import Integral, Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from lrsr.errors import InputError
from lrsr.files import fresh_folder, locked, make_folder
from lrsr.paths import user_path

if TYPE_CHECKING:
    from omegaconf import DictConfig

_Schema = TypeVar("_Schema")
_Value = TypeVar("_Value", str, int, float)

LARGEST_SEED = 2**32 - 1
_COUNTS = {2: "two", 3: "three"}


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
        folder = fresh_folder(
            user_path(config.paths.runs, "paths.runs") / str(hydra.job.config_name) / name
        )
    else:
        sweep = hydra.mode == RunMode.MULTIRUN
        folder = make_folder(
            user_path(config.paths.run, "paths.run") / (str(hydra.job.num) if sweep else "")
        )
    with locked(folder, wait=False):
        yield folder


def section(schema: type[_Schema], config: "DictConfig", key: str) -> _Schema:
    """Read one section of a configuration into a dataclass, checking the types of its fields.

    Raises:
        InputError: A value has the wrong type or is out of range; the message names the setting.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway
    from omegaconf.errors import OmegaConfBaseException

    wanted: Any = schema
    try:
        given: Any = OmegaConf.to_container(config[key], resolve=True)  # while it has its parents
        merged = OmegaConf.merge(_structured(wanted), given)
        values = OmegaConf.to_container(merged, resolve=True)
    except OmegaConfBaseException as error:
        place = getattr(error, "full_key", None)
        name = f"{key}.{place}" if place else key
        reason = str(error).splitlines()[0]
        if "with ListConfig" in reason:  # a mapping, which OmegaConf does not name
            name = next(f"{key}.{one}" for one, node in given.items() if isinstance(node, dict))
        if "ListConfig" in reason:
            reason = f"wanted a list, e.g. {name}=[...]"
        raise InputError(f"{name}: {reason}") from error
    found: dict[str, Any] = values  # type: ignore[assignment]  # those of the schema
    for field, value in found.items():
        if isinstance(value, float):
            as_number(value, f"{key}.{field}")
    return schema(**found)


@cache
def _structured(schema: Any) -> Any:
    """Return what a dataclass asks for, as OmegaConf says it: merged, never changed."""
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    return OmegaConf.structured(schema)


def number(config: "DictConfig", key: str) -> float:
    """Read a number.

    Raises:
        InputError: It is none.
    """
    return as_number(config[key], key)


def whole_number(config: "DictConfig", key: str) -> int:
    """Read a whole number.

    Raises:
        InputError: It is none.
    """
    return as_whole(config[key], key)


def seed_of(config: "DictConfig") -> int:
    """Read the seed of a run: the same range in every command.

    Raises:
        InputError: It is none.
    """
    seed = as_whole(config.seed, "seed")
    require(0 <= seed <= LARGEST_SEED, "seed", seed, f"0 to {LARGEST_SEED}")
    return seed


def numbers(config: "DictConfig", key: str) -> list[float]:
    """Read a list of numbers; one number is a list of one.

    Raises:
        InputError: Something in it is no number.
    """
    return [as_number(value, key) for value in _listed(config[key])]


def whole_numbers(config: "DictConfig", key: str) -> list[int]:
    """Read a list of whole numbers; one number is a list of one.

    Raises:
        InputError: Something in it is no whole number.
    """
    return [as_whole(value, key) for value in _listed(config[key])]


def flag(config: "DictConfig", key: str) -> bool:
    """Read true or false.

    Raises:
        InputError: It is neither.
    """
    return as_flag(config[key], key)


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
    return [as_word(value, key) for value in _listed(config[key])]


def once(values: list[_Value], key: str) -> list[_Value]:
    """Return values of which none is there twice, such as the rows of a table.

    Raises:
        InputError: One is.

    Example:
        >>> once([8.0, 11.0], "ipd_px")
        [8.0, 11.0]
    """
    require(len({*values}) == len(values), key, values, "each of them once")
    return values


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


def as_number(value: object, name: str) -> float:
    """Return any finite real number as a float; ``name`` is what the message calls it.

    Arrays and tensors without axes are numbers, too.

    Raises:
        InputError: It is none.

    Example:
        >>> as_number(8, "ipd_px")
        8.0
    """
    number = _unboxed(value)
    with suppress(OverflowError):  # of a whole number of 310 digits
        real = isinstance(number, Real | Decimal) and not isinstance(number, bool)
        if real and math.isfinite(number):
            return float(number)
    raise InputError(f"{name}={_typed(value)}: wanted a number")


def as_whole(value: object, name: str) -> int:
    """Return any whole number as an int; ``name`` is what the message calls it.

    Raises:
        InputError: It is none.
    """
    number = _unboxed(value)
    if isinstance(number, bool) or not isinstance(number, Integral):
        raise InputError(f"{name}={_typed(value)}: wanted a whole number")
    return int(number)


def _unboxed(value: Any) -> Any:
    """Return the number that a NumPy scalar, or an array or a tensor without axes, holds."""
    if getattr(value, "ndim", None) != 0 or getattr(value, "mask", False):
        return value
    with suppress(RuntimeError):  # of a tensor without data
        return value.item()
    return value


def as_flag(value: object, name: str) -> bool:
    """Return true or false; ``name`` is what the message calls it.

    Raises:
        InputError: It is neither.
    """
    require(isinstance(value, bool), name, value, "true or false")
    return bool(value)


def as_word(value: object, name: str) -> str:
    """Return a word; a number is one, too: somebody may call a camera 2.

    Raises:
        InputError: It is none.
    """
    known = isinstance(value, str | Real) and not isinstance(value, bool)
    require(known, name, value, "a word")
    return str(value)


def as_mapping(value: object, name: str) -> Mapping[Any, Any]:
    """Return names and values.

    Raises:
        InputError: It is none.
    """
    if not isinstance(value, Mapping):
        raise InputError(f"{name}={_typed(value)}: wanted {name}.SETTING=... for each of its parts")
    return value


def as_list(value: object, name: str) -> list[Any]:
    """Return the values of a list, whoever made it.

    Raises:
        InputError: It is none.
    """
    require(_is_list(value), name, value, f"a list, e.g. {name}=[...]")
    return [*value]  # type: ignore[misc]  # it is one


def _is_list(value: object) -> bool:
    return isinstance(value, Iterable) and not isinstance(value, str | Mapping)


def as_parts(kind: type[_Schema], value: object, name: str) -> tuple[_Schema, ...]:
    """Return dataclasses of a list; Hydra hands over mappings of their fields.

    Raises:
        InputError: It is no list, or something in it is no such dataclass.
    """
    built = []
    for number, each in enumerate(as_list(value, name)):
        place = f"{name}.{number}"
        if isinstance(each, kind):
            built.append(each)
            continue
        try:
            built.append(kind(**as_mapping(each, place)))
        except TypeError as error:  # a field too many, or too few
            reason = str(error).split("() ", 1)[-1]
            raise InputError(f"{place}: {reason}; --cfg job prints what there is") from error
    return tuple(built)


def settle(instance: object, group: str) -> None:
    """Give the fields of a frozen dataclass the types that they are declared with.

    So that 8 and 8.0, a list and a tuple, NumPy's numbers and Python's make equal values, equal
    hashes and equal records. Fields of other types than numbers, words and tuples of a stated
    number of numbers are left alone.

    Args:
        instance: Just made, maybe from a configuration.
        group: What messages call it; "" where the fields' names say enough.

    Raises:
        InputError: A field holds something else, or a NaN or an infinity.
    """
    schema: Any = type(instance)
    for field, kind in _kinds(schema).items():
        name = f"{group}.{field}" if group else field
        object.__setattr__(instance, field, _settled(getattr(instance, field), kind, name))


@lru_cache(maxsize=64)
def _kinds(schema: Any) -> dict[str, Any]:
    hints = get_type_hints(schema)
    return {field.name: hints[field.name] for field in fields(schema)}


def _settled(value: object, kind: Any, name: str) -> object:
    plain = {float: as_number, int: as_whole, bool: as_flag, str: as_word}
    inner = get_args(kind)
    if type(None) in inner:
        return None if value is None else _settled(value, inner[0], name)
    if get_origin(kind) is Literal:
        require(value in inner, name, value, f"one of {', '.join(inner)}")
    elif get_origin(kind) is tuple and Ellipsis not in inner:
        given = [*value] if _is_list(value) else []  # type: ignore[misc]  # it is one
        wish = f"{_COUNTS[len(inner)]} numbers, e.g. {name}=[{','.join('1' * len(inner))}]"
        require(len(given) == len(inner), name, value, wish)
        return tuple(_settled(one, each, name) for one, each in zip(given, inner, strict=True))
    return plain[kind](value, name) if kind in plain else value
