"""How does a composed configuration become typed values, with an error that names the setting?"""

import math
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from numbers import Integral, Real
from typing import TYPE_CHECKING, Any, TypeVar

from lrsr.errors import InputError
from lrsr.paths import config_folder

if TYPE_CHECKING:
    from omegaconf import DictConfig

Schema = TypeVar("Schema")


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
    return schema(**values)  # type: ignore[arg-type]  # str keys: the fields of the schema


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


def words(config: "DictConfig", key: str) -> list[str]:
    """Read a list of words; one word is a list of one."""
    return [str(value) for value in _listed(config[key])]


def require(holds: bool, key: str, value: object, wanted: str) -> None:
    """Refuse a value out of range.

    Raises:
        InputError: It does not hold.
    """
    if not holds:
        raise InputError(f"{key}={value}: wanted {wanted}")


def _listed(value: object) -> list[object]:
    from omegaconf import ListConfig  # loaded by Hydra anyway

    return list(value) if isinstance(value, ListConfig | list | tuple) else [value]


def as_number(value: object, name: str) -> float:
    """Return any finite real number as a float; ``name`` is what the message calls it.

    Raises:
        InputError: It is none.

    Example:
        >>> as_number(8, "ipd_px")
        8.0
    """
    if isinstance(value, bool) or not isinstance(value, Real) or not math.isfinite(value):
        raise InputError(f"{name}={value}: wanted a number")
    return float(value)


def as_whole(value: object, name: str) -> int:
    """Return any whole number as an int; ``name`` is what the message calls it.

    Raises:
        InputError: It is none.
    """
    if isinstance(value, bool) or not isinstance(value, Integral):
        raise InputError(f"{name}={value}: wanted a whole number")
    return int(value)


def settle_numbers(instance: object, group: str, *fields: str) -> None:
    """Turn numeric fields of a frozen dataclass into floats, lists of them into tuples.

    So that 8 and 8.0, a list and a tuple, NumPy's numbers and Python's make equal values, equal
    hashes and equal records. None stays None.

    Raises:
        InputError: A field holds anything else, or a NaN or an infinity.
    """
    for field in fields:
        value, name = getattr(instance, field), f"{group}.{field}"
        if value is None:
            continue
        if isinstance(value, Iterable) and not isinstance(value, str):
            settled: object = tuple(as_number(each, name) for each in value)
        else:
            settled = as_number(value, name)
        object.__setattr__(instance, field, settled)


_PLAIN = {"pose": "frontal", "lighting": "frontal", "lens": "pinhole", "standpoint": "level"}
"""What a mapping without ``_target_`` changes."""


def preset(group: str, name: str, **changes: Any) -> Any:
    """Build what ``conf/GROUP/NAME.yaml`` describes: where a name becomes a value.

    Args:
        group: Folder below ``conf``, e.g. ``pose`` or ``rendering/skin``.
        name: Of the file, without ``.yaml``.
        changes: Fields to replace.

    Raises:
        InputError: There is no such preset, or a field that it does not know.

    Example:
        >>> preset("pose", "left", pitch_deg=5)
        Pose(name='left', yaw_deg=30.0, pitch_deg=5.0, roll_deg=0.0)
    """
    from omegaconf import OmegaConf  # and Hydra below: a quarter of a second where it is used

    known = presets(group)
    if name not in known:
        near = get_close_matches(str(name), known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(known)}"
        raise InputError(f"{group}={name}: there is none; {hint}")
    return build(OmegaConf.merge(_read_preset(group, name), changes), group)


def presets(group: str) -> list[str]:
    """Name what there is in a folder below ``conf``."""
    return sorted(path.stem for path in (config_folder() / group).glob("*.yaml"))


def _read_preset(group: str, name: str) -> Any:
    """Read a file of a group over those of its own folder that its defaults list names."""
    from omegaconf import OmegaConf

    node: Any = OmegaConf.load(config_folder() / group / f"{name}.yaml")
    bases = [base for base in node.pop("defaults", []) if base != "_self_"]
    return OmegaConf.merge(*(_read_preset(group, base) for base in bases), node)


def value_of(group: str, node: Any) -> Any:
    """Build a value from its preset's name, from a mapping with ``_target_``, or from changes.

    Raises:
        InputError: See :func:`preset`.
    """
    if isinstance(node, str):
        return preset(group, node)
    if isinstance(node, Mapping) and "_target_" not in node and group in _PLAIN:
        return preset(group, _PLAIN[group], **{"name": "own", **node})
    return build(node, group)


def build(node: Any, name: str, **more: Any) -> Any:
    """Call what a node's ``_target_`` names; ``name`` is what messages call the node.

    Raises:
        InputError: The node has a field that its target does not take, or a value is wrong.
    """
    from hydra.errors import InstantiationException
    from hydra.utils import instantiate

    try:
        if not more:
            return instantiate(node)
        return instantiate(node, _partial_=True)(**more)  # Hydra itself would turn them into nodes
    except (InstantiationException, TypeError) as error:
        cause = error.__cause__ if isinstance(error, InstantiationException) else error
        if isinstance(cause, InputError):
            raise cause from None
        if isinstance(cause, TypeError) and "argument" in str(cause):
            reason = str(cause).split(") ", 1)[-1].split("() ", 1)[-1]
            raise InputError(f"{name}: {reason}; --cfg job prints what there is") from error
        raise
