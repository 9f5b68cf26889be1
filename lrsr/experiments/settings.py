"""What can be asked of a verification experiment, checked before any work begins."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from lrsr.errors import InputError

if TYPE_CHECKING:
    from omegaconf import DictConfig

COMPRESSIONS = ("none", "small", "heavy")
SPLITS = ("train", "validation", "test")
Schema = TypeVar("Schema")


@dataclass(frozen=True)
class IdentityRange:
    """Who takes part: ``count`` people of a split, from number ``start`` on."""

    split: str = "test"
    start: int = 0
    count: int = 100

    def __post_init__(self) -> None:
        _require(self.split in SPLITS, "identities.split", self.split, f"one of {SPLITS}")
        _require(self.start >= 0, "identities.start", self.start, "at least 0")
        _require(self.count >= 2, "identities.count", self.count, "at least 2")


@dataclass(frozen=True)
class RenderingSettings:
    """How light becomes a film; see ``conf/rendering``."""

    skin: str = "reflective"
    samples_per_pixel: int = 2048
    max_depth: int = 5
    texture_size: int = 512

    def __post_init__(self) -> None:
        for key in ("samples_per_pixel", "max_depth", "texture_size"):
            _require(getattr(self, key) >= 1, f"rendering.{key}", getattr(self, key), "at least 1")


@dataclass(frozen=True)
class GallerySettings:
    """The enrolled picture of everyone; see ``conf/gallery``."""

    pose: str = "frontal"
    lighting: str = "frontal"
    ipd_px: float = 64.0
    samples_per_pixel: int = 64

    def __post_init__(self) -> None:
        _require(self.ipd_px >= 4, "gallery.ipd_px", self.ipd_px, "at least 4")
        _require(
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
        _require(self.ipd_px >= 4, "ipd_px", self.ipd_px, "at least 4")
        _require(
            self.compression in COMPRESSIONS,
            "compression",
            self.compression,
            f"one of {COMPRESSIONS}",
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

    def __post_init__(self) -> None:
        _require(len(self.conditions) > 0, "options", [], "at least one")
        _require(len(self.methods) > 0, "methods", [], "at least one")
        _require(0 < self.level < 1, "level", self.level, "between 0 and 1")


def verification_settings(config: "DictConfig") -> VerificationSettings:
    """Read the settings of ``lrsr eval`` from its composed configuration.

    Raises:
        InputError: A value is out of range; the message names the setting and the remedy.
        omegaconf.errors.ValidationError: A value has the wrong type.
    """
    return VerificationSettings(
        name=str(config.name),
        question=str(config.question),
        conditions=_conditions(config),
        methods=tuple(str(method) for method in config.methods),
        identities=section(IdentityRange, config, "identities"),
        gallery=section(GallerySettings, config, "gallery"),
        rendering=section(RenderingSettings, config, "rendering"),
        seed=_number(config.seed, "seed", int),
        level=_number(config.level, "level", float),
    )


def section(schema: type[Schema], config: "DictConfig", key: str) -> Schema:
    """Read one section of a configuration into its dataclass, with its types.

    Raises:
        InputError: A value is out of range or has the wrong type; the message names the setting.
    """
    from omegaconf import OmegaConf  # loaded by Hydra anyway
    from omegaconf.errors import OmegaConfBaseException

    try:
        merged = OmegaConf.merge(OmegaConf.structured(schema), config[key])
        values = OmegaConf.to_container(merged, resolve=True)
    except OmegaConfBaseException as error:
        place = getattr(error, "full_key", None)
        name = f"{key}.{place}" if place else key
        raise InputError(f"{name}: {str(error).splitlines()[0]}") from error
    return schema(**values)  # type: ignore[arg-type]  # str keys: the fields of the schema


def _conditions(config: "DictConfig") -> tuple[Condition, ...]:
    from omegaconf import ListConfig  # loaded by Hydra anyway

    table = config.conditions
    sizes = list(config.ipd_px) if isinstance(config.ipd_px, ListConfig) else [config.ipd_px]
    options = list(config.options) if isinstance(config.options, ListConfig) else [config.options]
    conditions = []
    for ipd_px in sizes:
        for option in options:
            _require(option in table, "options", option, f"one of {sorted(table)}")
            conditions.append(
                Condition(option=option, ipd_px=_number(ipd_px, "ipd_px", float), **table[option])
            )
    return tuple(conditions)


_Number = TypeVar("_Number", int, float)


def _number(value: object, key: str, kind: type[_Number]) -> _Number:
    if isinstance(value, bool) or not isinstance(value, int | float) or kind(value) != value:
        raise InputError(f"{key}={value}: wanted {'a whole' if kind is int else 'a'} number")
    return kind(value)


def _require(holds: bool, key: str, value: object, wanted: str) -> None:
    if not holds:
        raise InputError(f"{key}={value}: wanted {wanted}")
