"""Does a file describe a camera, and nothing else? It may come from anybody.

Hydra would call whatever a ``_target_`` names, import what a ``defaults:`` list asks for and obey a
``# @package`` comment. So the file is read here, only the parts of a camera are built from it, and
what is handed on is plain values without comments, aliases and interpolations.
"""

import inspect
import io
from collections.abc import Mapping
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import yaml  # type: ignore[import-untyped]  # what OmegaConf reads with
from omegaconf import OmegaConf
from torch import nn

from lrsr.camera.camera import STAGES, Camera
from lrsr.errors import InputError
from lrsr.files import read_bytes, why_no_file

_LARGEST_BYTES = 2**16
"""A camera with every setting and its comments has a few thousand."""
_DEEPEST = 20
"""A camera has half a dozen levels; parsers take seconds over thousands."""

_CLASSES: list[type[nn.Module]] = [Camera, *(kind for kinds in STAGES.values() for kind in kinds)]
_PARTS = {
    f"{home}.{part.__name__}": part
    for part in _CLASSES
    for home in ("lrsr.camera", part.__module__)
}
_REMEDY = "begin with a copy of a preset, or with what lrsr fit-camera wrote"


def read_preset_file(path: Path) -> dict[str, Any]:
    """Return what a camera's file says, in plain values, after the camera was built from it once.

    Args:
        path: A YAML file as in ``conf/camera``; UTF-8 or UTF-16, with or without a byte-order mark.

    Returns:
        Mappings, lists, numbers, words and None; ``_target_`` only of parts of a camera.

    Raises:
        InputError: There is no such file, it is no YAML, or it describes something else; the
            message names the file, the setting and the remedy.
    """
    if why := why_no_file(path):
        raise InputError(f"camera={path} {why}: give a preset's name or its .yaml file")
    try:
        plain = _parsed(path)
        build_camera(plain)
    except InputError as error:
        raise InputError(f"camera={path}: {error}") from None
    return plain


def build_camera(plain: Mapping[str, Any]) -> Camera:
    """Return the camera that plain values as in ``conf/camera`` describe.

    Raises:
        InputError: They describe something else; the message names the setting and the remedy.
    """
    if not isinstance(plain, dict) or "_target_" not in plain:
        what = "nothing" if not plain else "no `_target_: lrsr.camera.Camera` at its top"
        raise InputError(f"it holds {what}; {_REMEDY}")
    camera = _build(plain, "")
    if not isinstance(camera, Camera):
        raise InputError(f"it is a part of a camera only; {_REMEDY}")
    return camera


def _parsed(path: Path) -> dict[str, Any]:
    """Return the plain content of a file.

    Raises:
        InputError: It cannot be read, is too large or too deep, or no YAML, or uses aliases.
    """
    try:
        content = read_bytes(path)
        if len(content) > _LARGEST_BYTES:
            raise InputError(f"{len(content)} bytes are too many for a camera; {_REMEDY}")
        depth = 0
        for event in yaml.parse(content, Loader=yaml.SafeLoader):
            if isinstance(event, yaml.AliasEvent):
                raise InputError(f"*{event.anchor} repeats something; write the value itself")
            depth += isinstance(event, yaml.CollectionStartEvent)
            depth -= isinstance(event, yaml.CollectionEndEvent)
            if depth > _DEEPEST:
                raise InputError(f"it goes more than {_DEEPEST} levels deep; {_REMEDY}")
        loaded: Any = OmegaConf.to_container(OmegaConf.load(io.BytesIO(content)), resolve=False)
        return loaded  # type: ignore[no-any-return]  # `build_camera` looks what it is
    except OSError as error:
        raise InputError(f"{error.strerror or error}; {_REMEDY}") from None
    except InputError:
        raise
    except Exception as error:  # whatever YAML's and OmegaConf's parsers raise
        raise InputError(f"no configuration: {str(error).splitlines()[0]}; {_REMEDY}") from None


def _build(value: object, where: str) -> object:
    """Build a part of a camera; return lists and plain values as they are.

    Raises:
        InputError: It is something else; the message begins with where it stands.
    """
    if isinstance(value, list):
        return [_build(one, f"{where}[{k}]") for k, one in enumerate(value)]
    if isinstance(value, str) and ("${" in value or value == "???"):
        raise InputError(f"{where}={value} is computed; write the value itself")
    if not isinstance(value, dict):
        return value
    part = _PARTS.get(str(value.get("_target_")))
    if part is None:
        name, target = where or "it", value.get("_target_")
        raise InputError(f"{name}: _target_={target} builds no part of lrsr.camera; remove it")
    settings = {key: each for key, each in value.items() if key != "_target_"}
    _check_names(part, settings, where)
    built = {key: _build(each, f"{where}.{key}".strip(".")) for key, each in settings.items()}
    try:
        return part(**built)
    except InputError as error:
        raise InputError(f"{where}.{error}".strip(".")) from None
    except (TypeError, ValueError, ArithmeticError) as error:
        raise InputError(f"{where or 'it'} is no {part.__name__}: {error}") from None


def _check_names(part: type[nn.Module], settings: Mapping[Any, object], where: str) -> None:
    """Refuse settings that a part does not have, Hydra's own (``_args_``, ``defaults``) too.

    Raises:
        InputError: There is one.
    """
    known = list(inspect.signature(part).parameters)
    for name in settings:
        if name not in known:
            near = get_close_matches(str(name), known, n=1)
            remedy = f"did you mean {near[0]}?" if near else f"choose of {', '.join(known)}"
            place = f"{where}.{name}".strip(".")
            raise InputError(
                f"{place}={settings[name]}: {part.__name__} has no such setting; {remedy}"
            )
