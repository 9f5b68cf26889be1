"""What is asked of a verification experiment? Who, how pictured, how enlarged, how sure."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from lrsr.camera import Camera
from lrsr.configuration import (
    as_mapping,
    as_word,
    flag,
    number,
    once,
    require,
    seed_of,
    whole_number,
    words,
)
from lrsr.experiments.asked import Asked
from lrsr.experiments.conditions import Condition, photographed, read_conditions
from lrsr.experiments.several import Several, read_several
from lrsr.identities.roster import IdentityRange
from lrsr.paths import path_if_any
from lrsr.pictures.burst import STILL, Burst
from lrsr.pictures.sitting import Sitting, read_burst, read_gallery, read_people, read_quality
from lrsr.pictures.source import read_photographs
from lrsr.presets import build, node_of, presets
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Quality
from lrsr.sr.upscaler import Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig


OF_AXES = ("axes", "against", "shard", "shards")
"""Settings that only an experiment with conditions of rendered people reads."""


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
        details: Show curves and faces of every condition in the report.
        references: Render the true references, too; without them nothing is said of PSNR, SSIM,
            identity and the like.
        share: Of the people, (k, n): nothing but every n-th of them is rendered, beginning with the
            k-th; None: all are, and evaluated.

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
    details: bool = True
    references: bool = True
    share: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        count = self.people.count
        if self.probes_folder is None:
            wish = "at least 2: nobody is an impostor alone"
            require(count >= 2, "identities.count", count, wish)
        require(len(self.conditions) > 0, "options", [], "at least one")
        wish = "true: lpips tells how far pictures are from them"
        require(self.references or self.lpips is None, "references", False, wish)
        for condition in self.conditions:
            if condition.scene is not None:
                lens = condition.scene.lens
                self.camera_of(condition).check_lens(lens.name, pinhole=lens.is_pinhole)
        require(len(self.upscalers) > 0, "methods", [], "at least one")
        if "own" not in self.recognition.landmarks:
            for name, one in self.upscalers.items():
                chosen = isinstance(one, Several) and one.needs_detector
                wish = f"both or own: {name} chooses by the detector's score"
                require(not chosen, "recognition.landmarks", "shared", wish)
        _ = self.asked  # refuses what is out of range

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        probes = path_if_any(config.probes.folder, "probes.folder")
        return cls(
            name=as_word(config.name, "name"),
            question=as_word(config.question, "question"),
            conditions=(
                read_conditions(config)
                if probes is None
                else photographed(config, read_photographs(probes, "probe"))
            ),
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
            details=flag(config, "details"),
            references=flag(config, "references"),
            share=_share(config),
        )

    def camera_of(self, condition: Condition) -> Camera:
        """Return what takes the probes, with the condition's compression."""
        return (condition.camera or self.camera).compressing(condition.compression)

    def means_of(self, condition: Condition) -> dict[str, str]:
        """Name what pictures everybody and finds them; empty for photographs' cameras and skins."""
        ours, rendered = self.recognition.detector, condition.scene is not None
        return {
            "camera": (condition.camera or self.camera).name if rendered else "",
            "skin": (condition.skin or self.quality.skin).name if rendered else "",
            "detector": condition.detector or ("shipped" if ours is None else ours.stem),
        }

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
            "conditions": [one.describe() for one in self.conditions],
            "methods": {name: upscaler.describe() for name, upscaler in self.upscalers.items()},
            "identities": asdict(self.people),
            "rendering": asdict(self.quality),
            "gallery": self.gallery.describe(),
            "camera": self.camera.name,
            "level": self.level,
            "bootstrap": self.bootstrap,
            "calibration": self.calibration,
            "seed": self.seed,
            "details": self.details,
            "references": self.references,
            **({"burst": asdict(self.burst)} if self.frames > 1 else {}),
            "probes_folder": None if self.probes_folder is None else str(self.probes_folder),
            "gallery_folder": None if self.gallery_folder is None else str(self.gallery_folder),
        }


def _share(config: "DictConfig") -> tuple[int, int] | None:
    shards = whole_number(config, "shards")
    require(shards >= 1, "shards", shards, "at least 1")
    if config.shard is None:
        require(shards == 1, "shards", shards, "1, or shard=0, shard=1, ... in as many jobs")
        return None
    shard = whole_number(config, "shard")
    require(0 <= shard < shards, "shard", shard, f"0 to shards - 1 = {shards - 1}")
    return shard, shards


def read_upscalers(config: "DictConfig") -> dict[str, Upscaler]:
    """Read the methods of single pictures: presets, changed or not, and networks of one's own.

    Raises:
        InputError: A value is wrong, or a setting would not be read.
    """
    from omegaconf import OmegaConf

    as_mapping(config.sr, "sr")
    own: Any = OmegaConf.to_container(config.sr, resolve=True)
    methods = once(words(config, "methods"), "methods")
    for name, settings in own.items():
        as_mapping(settings, f"sr.{name}")
        require(name in methods, "methods", methods, f"{name} among them, as sr.{name} is given")
    return {
        name: build(node_of("sr", name, own.get(name, {})), f"sr.{name}")
        if name not in own or name in presets("sr")
        else build({"_target_": "lrsr.sr.load_upscaler", "label": name, **own[name]}, f"sr.{name}")
        for name in methods
    }
