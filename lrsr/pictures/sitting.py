"""How is a group of people pictured, everyone alike? One recipe a person.

Probes, true references and enrolled pictures of every command are sittings, so that a picture has
one identity everywhere: what ``lrsr render`` has made, ``lrsr eval`` does not make again.
"""

from dataclasses import asdict, dataclass, replace
from typing import TYPE_CHECKING, Any

from lrsr.configuration import LARGEST_SEED, as_whole, require, section, seed_of
from lrsr.identities.photographs.person import Somebody
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.burst import STILL, Burst
from lrsr.pictures.recipe import KINDS, Kind, Recipe
from lrsr.presets import value_of
from lrsr.rendering.scene import Film, Quality, Scene

if TYPE_CHECKING:
    from omegaconf import DictConfig


@dataclass(frozen=True)
class Sitting:
    """People before one camera.

    Attributes:
        people: Who.
        scene: What stands before the camera besides.
        film: Size and fineness.
        quality: How well it is rendered, at this very size.
        kind: What the pictures are for: "probe" or "gallery".
        seed: The run's; every sampler's seed follows from it.
        burst: How the frames of a person differ, where there are several.

    Raises:
        InputError: The kind or the seed does not exist.
    """

    people: IdentityRange
    scene: Scene
    film: Film
    quality: Quality
    kind: Kind = "probe"
    seed: int = 0
    burst: Burst = STILL

    def __post_init__(self) -> None:
        require(self.kind in KINDS, "kind", self.kind, f"one of {', '.join(KINDS)}")
        object.__setattr__(self, "seed", as_whole(self.seed, "seed"))
        require(0 <= self.seed <= LARGEST_SEED, "seed", self.seed, f"0 to {LARGEST_SEED}")

    def recipes(self, scale: int = 1, frame: int = 0) -> list[Recipe]:
        """Return what everyone is rendered as, on a film ``scale`` times finer.

        Args:
            scale: Of the film.
            frame: Of everyone's burst; 0 is the first, which has nothing of the burst.
        """
        return [self.recipe(person, scale, frame) for person in self.people.people()]

    def recipe(self, person: Somebody, scale: int = 1, frame: int = 0) -> Recipe:
        """Return what somebody is rendered as; see :meth:`recipes`."""
        film = replace(self.film, scale=self.film.scale * scale)
        first = Recipe(person, self.scene, film, self.quality)
        return self.burst.frame(first, frame, self.seed).seeded(self.seed, self.kind, frame)

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for records."""
        return {**asdict(self), "scene": self.scene.describe()}


def read_people(config: "DictConfig") -> IdentityRange:
    """Read who takes part; see ``conf/identities``.

    Raises:
        InputError: A value is wrong.
    """
    return section(IdentityRange, config, "identities")


def _read_scene(config: "DictConfig") -> Scene:
    """Read what stands before the camera from the groups of a command.

    Args:
        config: Of a command, or of its gallery; what it has no group for is as usual.

    Raises:
        InputError: A value is wrong.
    """
    groups = ("lighting", "pose", "lens", "standpoint", "expression", "another_day")
    return Scene(**{name: value_of(name, config[name]) for name in groups if name in config})


def read_quality(config: "DictConfig") -> Quality:
    """Read how well 8 px are rendered; see ``conf/rendering``.

    Raises:
        InputError: A value is wrong.
    """
    given = dict(config.rendering)
    skin = value_of("rendering/skin", given.pop("skin"))
    for name in given:
        known = ("samples_per_pixel", "max_depth", "texture_size", "skin")
        require(name in known, "rendering", name, f"one of {', '.join(known)}")
    return Quality(**given, skin=skin)


def read_burst(config: "DictConfig") -> Burst:
    """Read how the frames of a person differ; see ``conf/burst``.

    Raises:
        InputError: A value is wrong.
    """
    burst: Burst = value_of("burst", config.burst)
    return burst


def read_probes(config: "DictConfig", film: Film, kind: Kind = "probe") -> Sitting:
    """Read how everyone is pictured by the groups of a command.

    Args:
        config: Of the command.
        film: As large as that; the quality follows from it.
        kind: What the pictures are for.

    Raises:
        InputError: A value is wrong.
    """
    return Sitting(
        people=read_people(config),
        scene=_read_scene(config),
        film=film,
        quality=read_quality(config).at(film.ipd_px),
        kind=kind,
        seed=seed_of(config),
        burst=read_burst(config) if "burst" in config else STILL,
    )


def read_gallery(config: "DictConfig") -> Sitting:
    """Read how everyone is enrolled; see ``conf/gallery``.

    Raises:
        InputError: A value is wrong.
    """
    enrolled = config.gallery
    samples = as_whole(enrolled.samples_per_pixel, "gallery.samples_per_pixel")
    require(samples >= 1, "gallery.samples_per_pixel", samples, "at least 1")
    film = Film(enrolled.ipd_px)
    require(film.ipd_px >= 4, "gallery.ipd_px", film.ipd_px, "at least 4")
    return Sitting(
        people=read_people(config),
        scene=_read_scene(enrolled),
        film=film,
        quality=replace(read_quality(config), samples_per_pixel=samples),
        kind="gallery",
        seed=seed_of(config),
    )
