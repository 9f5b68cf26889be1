"""How does a composed configuration become typed values, with an error that names the setting?"""

from typing import TYPE_CHECKING, TypeVar

from lrsr.errors import InputError

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


def _number(value: object, key: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(f"{key}={value}: wanted a number")
    return float(value)


def _whole(value: object, key: str) -> int:
    if isinstance(value, bool) or not isinstance(value, int):
        raise InputError(f"{key}={value}: wanted a whole number")
    return value
