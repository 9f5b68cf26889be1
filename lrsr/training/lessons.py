"""What is to be learned, by the configuration? Names become values and people here."""

import functools
from collections.abc import Mapping
from inspect import signature
from typing import TYPE_CHECKING, Any

from lrsr.configuration import as_number, as_whole, require
from lrsr.errors import InputError
from lrsr.paths import config_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import read_burst, read_people, read_quality
from lrsr.presets import build, presets, value_of
from lrsr.training.images import Images
from lrsr.training.mixed import Mixed
from lrsr.training.pairs import Pairs
from lrsr.training.rendered import Rendered
from lrsr.training.shrinking.shrinking import Shrinking

if TYPE_CHECKING:
    from omegaconf import DictConfig

_GROUPS = {
    "poses": "pose",
    "lightings": "lighting",
    "expressions": "expression",
    "gallery_lighting": "lighting",
    "probe_lighting": "lighting",
}
_LISTS = {
    *("poses", "lightings", "expressions", "ipd_px", "validation_ipd_px"),
    *("compressions", "enlargements", "distance_m"),
}
_COUNTS = ("validation_fraction", "validation_count")
"""Of the people to validate on."""

Lessons = Rendered | Images | Mixed


def read_lessons(config: "DictConfig", cache: RenderCache) -> Lessons:
    """Read what is shown to train and to validate; see ``conf/data``.

    Validation people are drawn from the same population as those to learn, at least two.

    Args:
        config: Of ``lrsr train``.
        cache: Of renderings.

    Raises:
        InputError: A value is wrong or missing, the network learns from something else, or the
            people are not of the split "train".
    """
    from hydra.utils import get_class  # loaded by Hydra anyway, as the next one
    from omegaconf import OmegaConf

    _refuse_others(config)
    for key in sorted(OmegaConf.missing_keys(config.data)):
        raise InputError(f"{key} must be given: add {key}=...")
    given: Any = OmegaConf.to_container(config.data, resolve=True)
    kind = get_class(given["_target_"])
    if kind is not Mixed:
        lessons: Lessons = _read(kind, given, config, cache)
        return lessons
    share = given.pop("rendered_share")
    parts = {part: _of(part, given) for part in (Pairs, Images)}
    for key in given.keys() - {"_target_"} - {key for part in parts.values() for key in part}:
        raise InputError(f"data.{key}: no setting of data=mixed; --cfg job prints them")
    rendered, images = (_read(part, parts[part], config, cache) for part in (Pairs, Images))
    return Mixed(rendered=rendered, images=images, rendered_share=share)


def _refuse_others(config: "DictConfig") -> None:
    """Refuse what something else learns from.

    Raises:
        InputError: It is.
    """
    from hydra.utils import get_class  # loaded by Hydra anyway

    names = _names()
    fits = getattr(get_class(config.module["_target_"]), "lessons", (*names.values(),))
    name = names.get(config.data["_target_"])  # somebody's own lessons have none
    wish = f"{' or '.join(fits)}, from which this network learns"
    require(name in (None, *fits), "data", name, wish)


@functools.cache
def _names() -> Mapping[str, str]:
    """Return what the options of ``conf/data`` are called, by their targets."""
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    files = {name: config_folder() / "data" / f"{name}.yaml" for name in presets("data")}
    return {OmegaConf.select(OmegaConf.load(p), "_target_"): name for name, p in files.items()}


def _of(kind: Any, given: Mapping[str, Any]) -> dict[str, Any]:
    """Return which settings are those of one part of mixed lessons."""
    names = {*signature(kind).parameters} | ({*_COUNTS} if kind is Pairs else set())
    return {key: value for key, value in given.items() if key in names}


def _read(kind: Any, given: dict[str, Any], config: "DictConfig", cache: RenderCache) -> Any:
    """Build lessons of one kind from their settings and the groups that they ask for."""
    asked = signature(kind).parameters
    camera = build(config.camera, "camera")
    more: dict[str, Any] = {"camera": camera}
    if "degradation" in asked:
        more["degradation"] = _read_degradation(config)
    if "burst" in asked:
        more["burst"] = read_burst(config)
    if "people" in asked:
        more |= _read_people(given, config, cache)
        more["lens"] = value_of("lens", config.lens)
        camera.check_lens(more["lens"].name, pinhole=more["lens"].is_pinhole)
    return _built({**given, "_target_": f"{kind.__module__}.{kind.__qualname__}"}, "data", **more)


def _read_degradation(config: "DictConfig") -> Shrinking:
    """Read how small pictures are made; see ``conf/degradation``.

    Raises:
        InputError: A value is wrong, or it is what an embedder learns from.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    given: Any = OmegaConf.to_container(config.degradation, resolve=True)
    degradation = build(given, "degradation")
    if not isinstance(degradation, Shrinking):
        wish = "none, camera, random_cameras or bsrgan; photographs is for recognition=arcface"
        wish += ", portraits for reconstructor=position_map"
        raise InputError(f"degradation._target_={given['_target_']}: wanted {wish}")
    return degradation


def _read_people(given: dict[str, Any], config: "DictConfig", cache: RenderCache) -> dict[str, Any]:
    """Read who is rendered, and how; takes the numbers of validation people out of ``given``."""
    people = read_people(config)
    require(people.split == "train", "identities.split", people.split, "train, to learn from")
    fraction, count = (given.pop(name, None) for name in _COUNTS)
    share = as_number(fraction, "data.validation_fraction")
    require(0 < share <= 10, "data.validation_fraction", share, "a number > 0 and <= 10")
    if count is not None:
        count = as_whole(count, "data.validation_count")
        require(count >= 1, "data.validation_count", count, "at least 1, or null")
    others = range(max(2, round(share * people.count)) if count is None else count)
    return {
        "people": people.people(),
        "validation_people": [people.cast.person("validation", index) for index in others],
        "standpoint": value_of("standpoint", config.standpoint),
        "expression": value_of("expression", config.expression),
        "another_day": value_of("another_day", config.another_day),
        "quality": read_quality(config),
        "cache": cache,
    }


def _built(node: Mapping[str, Any], name: str, **more: Any) -> Any:
    values = {key: _value(key, value) for key, value in node.items() if key != "_target_"}
    return build({"_target_": node["_target_"]}, name, **values, **more)


def _value(key: str, given: Any) -> Any:
    if key in _LISTS:
        listed = given if isinstance(given, list) else [given]
        return [value_of(_GROUPS[key], one) for one in listed] if key in _GROUPS else listed
    if key in _GROUPS:
        return value_of(_GROUPS[key], given)
    built = isinstance(given, Mapping) and "_target_" in given
    return _built(given, f"data.{key}") if built else given
