"""What is to be learned, by the configuration? Names become values and people here."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from lrsr.configuration import as_number, build, require, value_of
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.sitting import read_people, read_quality
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


def read_lessons(config: "DictConfig", cache: Path) -> Rendered:
    """Read what is rendered to train and to validate; see ``conf/data``.

    Validation people are drawn from the same population as those to learn, at least two.

    Args:
        config: Of ``lrsr train``.
        cache: Folder of the render cache.

    Raises:
        InputError: A value is wrong, or the people are not of the split "train".
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway

    people = read_people(config)
    require(people.split == "train", "identities.split", people.split, "train, to learn from")
    given: Any = OmegaConf.to_container(config.data, resolve=True)
    share = as_number(given.pop("validation_fraction"), "data.validation_fraction")
    require(0 < share <= 10, "data.validation_fraction", share, "a number > 0 and <= 10")
    named: dict[str, Any] = {}
    for name in _GROUPS.keys() & given.keys():
        value, group = given.pop(name), _GROUPS[name]
        many = isinstance(value, list)
        named[name] = [value_of(group, one) for one in value] if many else value_of(group, value)
    lessons: Rendered = build({**given, "_convert_": "all"}, "data")(
        people.people(),
        _validating(people, round(share * people.count)),
        **named,
        lens=value_of("lens", config.lens),
        standpoint=value_of("standpoint", config.standpoint),
        quality=read_quality(config),
        camera=build(config.camera, "camera"),
        cache=cache,
    )
    return lessons


def _validating(people: IdentityRange, count: int) -> list[Any]:
    return [people.cast.person("validation", index) for index in range(max(2, count))]
