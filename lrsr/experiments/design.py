"""What is asked of a verification experiment? Who, how pictured, how enlarged, how sure."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from lrsr.camera import Camera
from lrsr.camera.codec import COMPRESSIONS
from lrsr.configuration import (
    as_mapping,
    as_word,
    flag,
    number,
    numbered,
    numbers,
    require,
    seed_of,
    whole_number,
    whole_numbers,
    words,
)
from lrsr.evaluation.calibrators import CALIBRATORS
from lrsr.experiments.asked import Asked
from lrsr.experiments.several import Several, read_several
from lrsr.identities.roster import IdentityRange
from lrsr.paths import path_if_any
from lrsr.pictures.burst import STILL, Burst
from lrsr.pictures.sitting import Sitting, read_burst, read_gallery, read_people, read_quality
from lrsr.pictures.source import Photographs, read_photographs
from lrsr.presets import build, preset, presets, value_of
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.sr.upscaler import Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig


_OF_EVERY_PROBE = ("lens", "standpoint", "expression", "another_day")
"""What all conditions share, but for those that say otherwise."""


@dataclass(frozen=True)
class Condition:
    """One way to photograph everyone: an option of the experiment at one size.

    Attributes:
        option: Number of the option, e.g. 1 to 6 of the paper's Table 2.
        scene: What stands before the camera; None for photographs.
        compression: ``none``, ``small`` or ``heavy``; what the manifest says of photographs.
        ipd_px: Interpupillary distance on the probe, px; None: not known.
        pose: Its name; empty: not known.
        lighting: Its name; empty: not known.
    """

    option: int
    scene: Scene | None
    compression: str
    ipd_px: float | None
    pose: str = ""
    lighting: str = ""

    def __post_init__(self) -> None:
        if self.scene is None:
            return
        object.__setattr__(self, "pose", self.scene.pose.name)
        object.__setattr__(self, "lighting", self.scene.lighting.name)
        ipd_px = Film(self.ipd_px or 0).ipd_px
        require(ipd_px >= 4, "ipd_px", f"{ipd_px:g}", "at least 4")
        known = f"one of {', '.join(COMPRESSIONS)}"
        require(self.compression in COMPRESSIONS, "compression", self.compression, known)

    @property
    def title(self) -> str:
        """What a report calls it."""
        size = "" if self.ipd_px is None else f", IPD {self.ipd_px:g} px"
        known = {"pose": self.pose, "light": self.lighting, "compression": self.compression}
        told = [f"{word} {name}" for word, name in known.items() if name]
        if self.scene is not None:
            worn = (self.scene.expression.name, self.scene.another_day.name)
            told += [name for name in worn if name not in ("neutral", "none")]
        return f"Option {self.option}{size}" + (f": {', '.join(told)}" if told else "")


@dataclass(frozen=True)
class Design:
    """Everything that a verification experiment depends on.

    Attributes:
        name: Of the experiment.
        question: What its table answers.
        conditions: The rows of the table, in order.
        upscalers: The methods of every row, by name; some may take several frames.
        people: Who takes part.
        quality: How well a probe of 8 px is rendered.
        seed: Every sampler's seed follows from it.
        gallery: What they are compared with.
        camera: Takes the probes, with the condition's compression; all other pictures are taken by
            the reference camera, with the same exposure and without compression.
        level: Of every interval, between 0 and 1.
        recognition: How faces are found, aligned and embedded.
        probes_folder: Photographs in place of rendered probes, under the one condition given.
        gallery_folder: Photographs in place of rendered enrolled pictures.
        bootstrap: Draws of people for the intervals over people; 0: none.
        save_scores: Write every score down.
        calibration: Of the likelihood ratios, one of
            :data:`lrsr.evaluation.calibrators.CALIBRATORS`.
        lpips: ONNX file that says how far pictures look from their references; None: nobody asks.
        burst: How the frames of a probe differ, where a method takes several.

    Raises:
        InputError: A number is out of its range, or the camera has a lens of its own besides a
            scene's.
    """

    name: str
    question: str
    conditions: tuple[Condition, ...]
    upscalers: Mapping[str, Upscaler | Several]
    people: IdentityRange
    quality: Quality
    seed: int
    gallery: Sitting
    camera: Camera
    level: float = 0.95
    recognition: RecognitionSettings = field(default_factory=RecognitionSettings)
    probes_folder: Path | None = None
    gallery_folder: Path | None = None
    bootstrap: int = 0
    save_scores: bool = True
    calibration: str = "logistic"
    lpips: Path | None = None
    burst: Burst = STILL

    def __post_init__(self) -> None:
        count = self.people.count
        if self.probes_folder is None:
            wish = "at least 2: nobody is an impostor alone"
            require(count >= 2, "identities.count", count, wish)
        require(len(self.conditions) > 0, "options", [], "at least one")
        for lens in (condition.scene.lens for condition in self.conditions if condition.scene):
            self.camera.check_lens(lens.name, pinhole=lens.is_pinhole)
        require(len(self.upscalers) > 0, "methods", [], "at least one")
        if "own" not in self.recognition.landmarks:
            for name, one in self.upscalers.items():
                chosen = isinstance(one, Several) and one.needs_detector
                wish = f"both or own: {name} chooses by the detector's score"
                require(not chosen, "recognition.landmarks", "shared", wish)
        require(0 < self.level < 1, "level", self.level, "between 0 and 1")
        require(self.bootstrap >= 0, "bootstrap", self.bootstrap, "0 or more draws")
        known = f"one of {', '.join(CALIBRATORS)}"
        require(self.calibration in CALIBRATORS, "calibration", self.calibration, known)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        conditions, probes = _conditions(config), path_if_any(config.probes.folder, "probes.folder")
        if probes is not None:
            conditions = (_condition_of(read_photographs(probes, "probe")),)
        return cls(
            name=as_word(config.name, "name"),
            question=as_word(config.question, "question"),
            conditions=conditions,
            upscalers=read_upscalers(config) | read_several(config),
            people=read_people(config),
            quality=read_quality(config),
            seed=seed_of(config),
            gallery=read_gallery(config),
            camera=build(config.camera, "camera"),
            level=number(config, "level"),
            recognition=RecognitionSettings.from_config(config),
            probes_folder=probes,
            gallery_folder=path_if_any(config.gallery.folder, "gallery.folder"),
            bootstrap=whole_number(config, "bootstrap"),
            save_scores=flag(config, "save_scores"),
            calibration=as_word(config.calibration, "calibration"),
            lpips=path_if_any(config.lpips, "lpips"),
            burst=read_burst(config),
        )

    @property
    def frames(self) -> int:
        """How many frames of a probe the methods take at most."""
        return max(getattr(one, "frames", 1) for one in self.upscalers.values())

    @property
    def asked(self) -> Asked:
        """How further results are found."""
        return Asked(self.level, self.bootstrap, self.seed, self.calibration)

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        return {
            "name": self.name,
            "question": self.question,
            "conditions": [
                {**vars(one), "scene": None if one.scene is None else one.scene.describe()}
                for one in self.conditions
            ],
            "methods": {name: upscaler.describe() for name, upscaler in self.upscalers.items()},
            "identities": asdict(self.people),
            "rendering": asdict(self.quality),
            "gallery": self.gallery.describe(),
            "camera": self.camera.name,
            "level": self.level,
            "bootstrap": self.bootstrap,
            "calibration": self.calibration,
            "seed": self.seed,
            **({"burst": asdict(self.burst)} if self.frames > 1 else {}),
            "probes_folder": None if self.probes_folder is None else str(self.probes_folder),
            "gallery_folder": None if self.gallery_folder is None else str(self.gallery_folder),
        }


def _conditions(config: "DictConfig") -> tuple[Condition, ...]:
    table = numbered(config, "conditions")
    usual: dict[str, Any] = {"pose": "frontal", "lighting": "frontal", "compression": "none"}
    usual |= {group: config[group] for group in _OF_EVERY_PROBE}
    chosen, sizes = whole_numbers(config, "options"), numbers(config, "ipd_px")
    for option in chosen:
        require(option in table, "options", option, f"one of {sorted(table)}")
    scenes = {}
    for option, settings in table.items():  # those that are not chosen are to be right, too
        node = usual | settings
        compression = as_word(node.pop("compression"), f"conditions.{option}.compression")
        for group in node:
            wish = f"no such setting; there are {', '.join(usual)}"
            require(group in usual, f"conditions.{option}", group, wish)
        scene = Scene(**{group: value_of(group, node[group]) for group in node})
        scenes[option] = Condition(option, scene, compression, sizes[0] if sizes else 8.0)
    return tuple(replace(scenes[option], ipd_px=ipd) for ipd in sizes for option in chosen)


def _condition_of(photographs: Photographs) -> Condition:
    """Say of photographs what their manifest says of all of them."""

    def common(name: str, otherwise: Any) -> Any:
        told = {getattr(entry, name) for entry in photographs.entries}
        return told.pop() if len(told) == 1 else otherwise

    names = {name: common(name, "") for name in ("compression", "pose", "lighting")}
    return Condition(1, None, ipd_px=common("ipd_px", None), **names)


def read_upscalers(config: "DictConfig") -> dict[str, Upscaler]:
    """Read the methods of single pictures: presets, changed or not, and networks of one's own.

    Raises:
        InputError: A value is wrong, or a setting would not be read.
    """
    from omegaconf import OmegaConf

    as_mapping(config.sr, "sr")
    own: Any = OmegaConf.to_container(config.sr, resolve=True)
    methods = words(config, "methods")
    for name, settings in own.items():
        as_mapping(settings, f"sr.{name}")
        require(name in methods, "methods", methods, f"{name} among them, as sr.{name} is given")
    return {
        name: preset("sr", name, **own.get(name, {}))
        if name not in own or name in presets("sr")
        else build({"_target_": "lrsr.sr.load_upscaler", "label": name, **own[name]}, f"sr.{name}")
        for name in methods
    }
