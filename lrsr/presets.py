"""How does the name of a preset become a value? Once, by its file in ``conf``."""

from collections.abc import Mapping
from difflib import get_close_matches
from functools import cache
from typing import Any

from lrsr.errors import InputError
from lrsr.paths import config_folder

_PLAIN = {
    "pose": "frontal",
    "lighting": "frontal",
    "lens": "pinhole",
    "standpoint": "level",
    "expression": "neutral",
    "another_day": "none",
    "rendering/skin": "reflective",
}
"""What a mapping without ``_target_`` changes."""


def preset(group: str, name: str, /, **changes: Any) -> Any:
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
    return build(node_of(group, name, {key: _plain(one) for key, one in changes.items()}), group)


def _plain(value: Any) -> Any:
    """Return what an array, a tensor or a NumPy scalar holds in Python's own numbers."""
    value = value.detach() if hasattr(value, "detach") else value
    return value.tolist() if hasattr(value, "tolist") else value


def node_of(group: str, name: str, changes: Mapping[str, Any]) -> Any:
    """Return what ``conf/GROUP/NAME.yaml`` says, with some fields replaced.

    Raises:
        InputError: There is no such preset.
    """
    from omegaconf import OmegaConf  # and Hydra below: a quarter of a second where it is used

    known = presets(group)
    if name not in known:
        near = get_close_matches(str(name), known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose one of {', '.join(known)}"
        raise InputError(f"{group}={name}: there is none; {hint}")
    return OmegaConf.merge(_read_preset(group, name), changes)


def presets(group: str) -> list[str]:
    """Name what there is in a folder below ``conf``."""
    return sorted(path.stem for path in (config_folder() / group).glob("*.yaml"))


@cache
def _read_preset(group: str, name: str) -> Any:
    """Read a file of a group over those of its own folder that its defaults list names.

    Once: parsing takes longer than building. What is returned is merged, never changed.
    """
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
    if not isinstance(node, Mapping):
        raise InputError(f"{group}={node}: wanted a name, or the fields of one's own")
    if "_target_" not in node and group in _PLAIN:
        return preset(group, _PLAIN[group], **{"name": "own", **node})
    return build(node, group)


def build(node: Any, name: str, **more: Any) -> Any:
    """Call what a node's ``_target_`` names; ``name`` is what messages call the node.

    Args:
        node: With ``_target_``, or with nodes that have one.
        name: What messages call it.
        more: Arguments that are values already.

    Raises:
        InputError: A field is missing or unknown to its target, or a value is wrong.
        TypeError: The target has a fault of its own, as in the next line.
        InstantiationException: It cannot be found, or has raised something else.
    """
    from hydra.errors import InstantiationException
    from hydra.utils import instantiate
    from omegaconf.errors import MissingMandatoryValue, OmegaConfBaseException

    try:
        if not more:
            return instantiate(node)
        return instantiate(node, _partial_=True)(**more)  # Hydra would make nodes of the values
    except MissingMandatoryValue as error:
        field = f"{name}.{str(error.full_key).removeprefix(f'{name}.')}"
        raise InputError(f"{field} must be given: add {field}=...") from error
    except (InstantiationException, TypeError) as error:
        cause = error.__cause__ if isinstance(error, InstantiationException) else error
        if isinstance(cause, InputError):
            raise cause from None
        if isinstance(cause, OmegaConfBaseException):
            reason = str(cause).splitlines()[0]
            raise InputError(f"{name}: {reason}; --cfg job prints what there is") from error
        if isinstance(cause, TypeError) and "argument" in str(cause):
            reason = str(cause).split(") ", 1)[-1].split("() ", 1)[-1]
            raise InputError(f"{name}: {reason}; --cfg job prints what there is") from error
        raise
