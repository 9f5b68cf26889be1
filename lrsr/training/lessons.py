"""What is to be learned, by the configuration? Names become values and people here."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lrsr.configuration import as_number, require
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.sitting import read_people, read_quality
from lrsr.presets import build, value_of
from lrsr.training.rendered import Rendered

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
    *("compressions", "enlargements"),
}


def read_lessons(config: "DictConfig", cache: RenderCache) -> Rendered:
    """Read what is rendered to train and to validate; see ``conf/data``.

    Validation people are drawn from the same population as those to learn, at least two.

    Args:
        config: Of ``lrsr train``.
        cache: Of renderings.

    Raises:
        InputError: A value is wrong, or the people are not of the split "train".
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    people = read_people(config)
    require(people.split == "train", "identities.split", people.split, "train, to learn from")
    given: Any = OmegaConf.to_container(config.data, resolve=True)
    share = as_number(given.pop("validation_fraction"), "data.validation_fraction")
    require(0 < share <= 10, "data.validation_fraction", share, "a number > 0 and <= 10")
    others = range(max(2, round(share * people.count)))
    lens, camera = value_of("lens", config.lens), build(config.camera, "camera")
    camera.check_lens(lens.name, pinhole=lens.is_pinhole)
    lessons: Rendered = _built(
        given,
        "data",
        people=people.people(),
        validation_people=[people.cast.person("validation", index) for index in others],
        lens=lens,
        standpoint=value_of("standpoint", config.standpoint),
        expression=value_of("expression", config.expression),
        another_day=value_of("another_day", config.another_day),
        quality=read_quality(config),
        camera=camera,
        cache=cache,
    )
    return lessons


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
