"""What can be asked of a verification experiment, checked before any work begins."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from lrsr.camera.codec import COMPRESSIONS
from lrsr.configuration import (
    number,
    numbered,
    numbers,
    require,
    section,
    whole_number,
    whole_numbers,
    words,
)
from lrsr.identities.roster import Casting
from lrsr.identities.splits import SPLITS
from lrsr.rendering.skin import named

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from lrsr.rendering.lens import Lens
    from lrsr.rendering.standpoint import Standpoint

LEAST_SAMPLES = 64
"""Samples per pixel of a large face, unless it is told to take fewer."""


@dataclass(frozen=True)
class IdentityRange(Casting):
    """Who takes part: ``count`` people of a split, from number ``start`` on; see the base, too."""

    split: str = "test"
    start: int = 0
    count: int = 100

    def __post_init__(self) -> None:
        super().__post_init__()
        require(self.split in SPLITS, "identities.split", self.split, f"one of {SPLITS}")
        require(self.start >= 0, "identities.start", self.start, "at least 0")
        require(self.count >= 1, "identities.count", self.count, "at least 1")
        roster = self.cast.roster
        if roster is not None:
            wanted = f"{roster.split}, as the roster's"
            require(roster.split == self.split, "identities.split", self.split, wanted)
        for index in (self.start, self.start + self.count - 1):
            self.cast.draw(self.split, index)  # refuses who is not on the roster


@dataclass(frozen=True)
class RenderingSettings:
    """How light becomes a film; see ``conf/rendering``."""

    skin: Any = "reflective"
    samples_per_pixel: int = 512
    max_depth: int = 5
    texture_size: int = 1024

    def __post_init__(self) -> None:
        object.__setattr__(self, "skin", named(self.skin))
        for key in ("samples_per_pixel", "max_depth", "texture_size"):
            require(getattr(self, key) >= 1, f"rendering.{key}", getattr(self, key), "at least 1")

    def samples_at(self, ipd_px: float) -> int:
        """Return the samples per pixel of a probe of that size.

        ``samples_per_pixel`` is that of 8 px; a larger face gets the same number of rays, so that
        it is as free of noise after alignment, but at least :data:`LEAST_SAMPLES`.

        Example:
            >>> RenderingSettings(samples_per_pixel=512).samples_at(16)
            128
        """
        fair = round(self.samples_per_pixel * min(1.0, 8 / ipd_px) ** 2)
        return min(self.samples_per_pixel, max(fair, LEAST_SAMPLES))


@dataclass(frozen=True)
class GallerySettings:
    """The enrolled picture of everyone; see ``conf/gallery``."""

    pose: str = "frontal"
    lighting: str = "frontal"
    ipd_px: float = 64.0
    samples_per_pixel: int = 64

    def __post_init__(self) -> None:
        require(self.ipd_px >= 4, "gallery.ipd_px", self.ipd_px, "at least 4")
        require(
            self.samples_per_pixel >= 1,
            "gallery.samples_per_pixel",
            self.samples_per_pixel,
            "at least 1",
        )


@dataclass(frozen=True)
class Condition:
    """One way to photograph everyone: an option of the experiment at one size.

    Attributes:
        option: Number of the option, e.g. 1 to 6 of the paper's Table 2.
        ipd_px: Interpupillary distance on the probe, px.
        pose: Name.
        lighting: Name.
        compression: ``none``, ``small`` or ``heavy``.
    """

    option: int
    ipd_px: float
    pose: str
    lighting: str
    compression: str

    def __post_init__(self) -> None:
        require(self.ipd_px >= 4, "ipd_px", self.ipd_px, "at least 4")
        require(
            self.compression in COMPRESSIONS,
            "compression",
            self.compression,
            f"one of {tuple(COMPRESSIONS)}",
        )


@dataclass(frozen=True)
class VerificationSettings:
    """Everything a verification experiment depends on.

    Attributes:
        name: Of the experiment.
        question: What its table answers.
        conditions: The rows of the table, in order.
        methods: The methods of every row; see :mod:`lrsr.sr.upscaling`.
        identities: Who takes part.
        gallery: What they are compared with.
        rendering: How light becomes a film.
        seed: Every sampler's seed follows from it.
        level: Of every interval, between 0 and 1.
        lens: Of the probes, name or any surfaces; the gallery's is a pinhole.
        standpoint: Of the probes' camera, name or any place; the gallery's is level.
    """

    name: str
    question: str
    conditions: tuple[Condition, ...]
    methods: tuple[str, ...]
    identities: IdentityRange
    gallery: GallerySettings
    rendering: RenderingSettings
    seed: int
    level: float
    lens: "str | Lens" = "pinhole"
    standpoint: "str | Standpoint" = "level"

    def __post_init__(self) -> None:
        count = self.identities.count
        require(count >= 2, "identities.count", count, "at least 2: nobody is an impostor alone")
        require(len(self.conditions) > 0, "options", [], "at least one")
        require(len(self.methods) > 0, "methods", [], "at least one")
        require(0 < self.level < 1, "level", self.level, "between 0 and 1")


def verification_settings(config: "DictConfig") -> VerificationSettings:
    """Read the settings of ``lrsr eval`` from its composed configuration.

    Raises:
        InputError: A value is out of range; the message names the setting and the remedy.
        omegaconf.errors.ValidationError: A value has the wrong type.
    """
    from hydra.utils import instantiate  # loaded by then

    return VerificationSettings(
        name=str(config.name),
        question=str(config.question),
        conditions=_conditions(config),
        methods=tuple(words(config, "methods")),
        identities=section(IdentityRange, config, "identities"),
        gallery=section(GallerySettings, config, "gallery"),
        rendering=section(RenderingSettings, config, "rendering"),
        seed=whole_number(config, "seed"),
        level=number(config, "level"),
        lens=instantiate(config.lens),
        standpoint=instantiate(config.standpoint),
    )


def _conditions(config: "DictConfig") -> tuple[Condition, ...]:
    table = numbered(config, "conditions")
    conditions = []
    for ipd_px in numbers(config, "ipd_px"):
        for option in whole_numbers(config, "options"):
            require(option in table, "options", option, f"one of {sorted(table)}")
            conditions.append(Condition(option=option, ipd_px=ipd_px, **table[option]))
    return tuple(conditions)
