"""What is a score worth in this case? Other people are simulated in its place, and weighed."""

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import torch

from lrsr.calibration.from_pictures import FitSettings
from lrsr.camera.preset_file import build_camera
from lrsr.configuration import (
    as_word,
    flag,
    number,
    require,
)
from lrsr.errors import ScoreError
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.evaluation.score_files.system import Name, System
from lrsr.evaluation.score_files.writing import score_file
from lrsr.evaluation.scores import ScoreSource
from lrsr.evaluation.summary import summarise
from lrsr.experiments.asked import Asked
from lrsr.experiments.basis import choose_basis, said_by, scores_file
from lrsr.experiments.design import OF_AXES, read_upscalers
from lrsr.experiments.facts import Facts, read_facts
from lrsr.experiments.fitted import fit_once
from lrsr.experiments.further import evidence_record
from lrsr.experiments.pair import score_of
from lrsr.experiments.report.case import write_case
from lrsr.experiments.simulation import Simulation, read_generic
from lrsr.experiments.systems import Comparer
from lrsr.experiments.table import Record, area_record, counts_record, rates_record
from lrsr.experiments.weighing import Weighed, weigh_case
from lrsr.files import write_json
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import SUFFIXES, read_image
from lrsr.pictures.maker import Maker
from lrsr.pictures.sitting import Sitting, read_gallery, read_probes
from lrsr.provenance import versions
from lrsr.recognition.memory import Memory
from lrsr.recognition.settings import RecognitionSettings
from lrsr.rendering.scene import Film
from lrsr.sr.upscaler import Upscaler

if TYPE_CHECKING:
    from omegaconf import DictConfig

_SHOWN = 8
_FEWEST = 20
"""People, of whom half are calibrated on and half are judged."""
_OF_THE_SIMULATION = (
    *("identities", "rendering", "camera", "lens", "standpoint", "expression", "another_day"),
    *("pose", "lighting", "ipd_px", "compression", "gallery", "recognition", "methods", "sr"),
    "generic",
)
_PRESET = "case"


@dataclass(frozen=True)
class Case:
    """What a score is worth in a case.

    Attributes:
        name: Of the report.
        question: What it answers.
        facts: Of the case.
        probes: Everybody as in the case.
        gallery: As they are enrolled.
        generic: Other ways to picture them, by name.
        camera: Plain settings of the case's camera, or of the one that the search for it begins
            with.
        compression: Besides what the camera does.
        upscalers: The lab's methods.
        recognition: The lab's recognisers.
        asked: How sure numbers are told.
        save_scores: Write every score down.

    Raises:
        InputError: There are too few people, or one score is said to be of several systems.
    """

    name: str
    question: str
    facts: Facts
    probes: Sitting
    gallery: Sitting
    generic: Mapping[str, Sequence[Sitting]]
    camera: Mapping[str, Any]
    compression: str
    upscalers: Mapping[str, Upscaler]
    recognition: RecognitionSettings
    asked: Asked
    save_scores: bool = True

    def __post_init__(self) -> None:
        facts = self.facts
        if facts.scores is not None:
            return
        count = self.probes.people.count
        wish = f"at least {_FEWEST}: half are calibrated on, half are judged"
        require(count >= _FEWEST, "identities.count", count, wish)
        systems = len(self.upscalers) * len(self.recognition.recognisers)
        alone = systems * len(self.recognition.landmarks) == 1
        wish = "one recogniser, one method and one source of landmarks, whose score it is"
        require(facts.score is None or alone, "case.score", facts.score, wish)
        own = "own" in self.recognition.landmarks
        wish = "own: nobody knows any others in the case's pictures"
        require(facts.pair is None or own, "recognition.landmarks", "shared", wish)
        build_camera(self.camera).compressing(self.compression)  # refuses what is no camera

    @staticmethod
    def unread(config: "DictConfig") -> tuple[str, ...]:
        """Return which settings of ``lrsr eval`` change nothing here."""
        never = (
            *("probes", "conditions", "options", "fusions", "fusion", "frames", "burst", "lpips"),
            *("details", "references", *OF_AXES),
        )
        return (*never, *(_OF_THE_SIMULATION if config.case.scores is not None else ()))

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        from omegaconf import OmegaConf

        folder = config.gallery.folder
        wish = "null: people are rendered, who are not on your photographs"
        require(folder is None, "gallery.folder", folder, wish)
        ipd_px = number(config, "ipd_px")
        require(ipd_px >= 4, "ipd_px", ipd_px, "at least 4")
        probes = read_probes(config, Film(ipd_px))
        return cls(
            name=as_word(config.name, "name"),
            question=as_word(config.question, "question"),
            facts=read_facts(config),
            probes=probes,
            gallery=read_gallery(config),
            generic=read_generic(config, probes),
            camera=OmegaConf.to_container(config.camera, resolve=True),  # type: ignore[arg-type]  # a mapping
            compression=as_word(config.compression, "compression"),
            upscalers=read_upscalers(config),
            recognition=RecognitionSettings.from_config(config),
            asked=Asked.from_config(config),
            save_scores=flag(config, "save_scores"),
        )

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Write ``results.json``, ``report.html``, ``scores.csv`` and the fitted camera.

        Args:
            folder: Of the run.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show bars.

        Raises:
            InputError: A file or a folder is wrong, or no camera like the pictures' was found.
        """
        facts = self.facts
        real = (
            None
            if facts.real_scores is None
            else read_scores([scores_file(facts.real_scores, "case.real_scores")])
        )
        faces: Mapping[str, Any] = {}
        pair: list[Record] = []
        about: dict[str, Any] = {}
        scores: dict[Name, float] = {}
        if facts.scores is not None:
            case, generic = self._imported()
        else:
            simulation = self._simulation(folder, cache, maker, progress=progress)
            memory = Memory(cache.folder / "recognition")
            engines, finder = self.recognition.engines(memory), self.recognition.finder(memory)
            comparer = Comparer(
                self.upscalers, engines, self.recognition.landmarks, finder, progress
            )
            if facts.pair is not None:  # refused before anything is rendered
                seen, compared = facts.pair.compare(self.recognition, self.upscalers)
                pair = [one.describe() for one in seen]
                scores = {one.name: score_of(one) for one in compared}
            simulation.render()
            compared, generic = simulation.scores(comparer)
            case = {one.name: one.system for one in compared}
            faces = _faces(simulation, facts)
            about = {name: dict(engine.describe()) for name, engine in engines.items()}
        if facts.score is not None:
            require(len(case) == 1, "case.score", facts.score, "scores of one system")
            scores = dict.fromkeys(case, facts.score)
        found = {
            name: weigh_case(
                system.source,
                {key: some[name].source for key, some in generic.items()},
                self._real_of(name, real),
                _score_for(scores, name),
                self.asked,
            )
            for name, system in case.items()
        }
        results: dict[str, Any] = {
            "rows": [self._row(name, system) for name, system in case.items()],
            "evidence": [
                line for name, one in found.items() for line in _evidence(self._about(name), one)
            ],
            "ratios": [
                line for name, one in found.items() for line in _ratios(self._about(name), one)
            ],
            "missing": list(dict.fromkeys(why for one in found.values() for why in one.missing)),
            "pair": pair,
            "config": self.describe(),
            "recognition": {"recognisers": about},
            "versions": versions(),
        }
        write_json(folder / "results.json", results)
        if self.save_scores:
            with score_file(folder) as table:
                for name, system in case.items():
                    table.add(name, system)
        write_case(folder, results, found, faces)
        return folder

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        facts, asked = self.facts, asdict(self.asked)
        told: dict[str, Any] = {"name": self.name, "question": self.question, **asked}
        told["case"] = {
            name: str(value) if isinstance(value, Path) else value
            for name, value in vars(facts).items()
            if name != "pair"
        }
        if facts.pair is not None:
            told["case"] |= {"probe": str(facts.pair.probe), "enrolled": str(facts.pair.enrolled)}
        if facts.scores is not None:
            return told
        generic = {name: [one.describe() for one in some] for name, some in self.generic.items()}
        return told | {
            "methods": {name: one.describe() for name, one in self.upscalers.items()},
            "probes": self.probes.describe(),
            "gallery": self.gallery.describe(),
            "generic": generic,
            "camera": self.camera,
            "compression": self.compression,
        }

    def _simulation(
        self, folder: Path, cache: RenderCache, maker: Maker | None, *, progress: bool
    ) -> Simulation:
        camera = self.camera
        if self.facts.images is not None:
            settings = FitSettings(
                self.facts.images,
                camera,
                self.probes,  # those who are simulated are the strangers who are photographed
                _PRESET,
                self.probes.film.ipd_px,
                self.facts.part,
                self.facts.rounds,
            )
            camera = fit_once(settings, folder / "camera", cache, maker, progress=progress)
        taken = build_camera(camera).compressing(self.compression)
        shared = (self.generic, cache, maker, progress)
        return Simulation(self.probes, self.gallery, taken, *shared)

    def _imported(self) -> tuple[dict[Name, System], dict[str, dict[Name, System]]]:
        """Return the scores of somebody's engine, and those of other pictures for each system."""
        facts = self.facts
        path = scores_file(facts.scores or Path(), "case.scores")
        case = dict(read_scores([path]))
        if facts.generic_scores is None:
            return case, {}
        path = scores_file(facts.generic_scores, "case.generic_scores")
        found = read_scores([path])
        chosen = {name: choose_basis(path, found, self._anywhere(name)).system for name in case}
        return case, {"generic": chosen}

    def _real_of(self, name: Name, real: Mapping[Name, System] | None) -> ScoreSource | None:
        if real is None or self.facts.real_scores is None:
            return None
        path = scores_file(self.facts.real_scores, "case.real_scores")
        return choose_basis(path, real, self._anywhere(name)).system.source

    def _anywhere(self, name: Name) -> Name:
        """Return what names a system whatever the pictures are, and whatever its file is called."""
        scores = self.facts.scores
        said = name if scores is None else said_by(scores_file(scores, "case.scores"), name)
        return replace(said, option="", ipd_px="")

    def _row(self, name: Name, system: System) -> Record:
        asked, source = self.asked, system.source
        row = {"experiment": self.name, **self._about(name)}
        try:
            (found,) = summarise(
                {name.method: source},
                pairs=(),
                level=asked.level,
                bootstrap=asked.bootstrap,
                seed=asked.seed,
            ).summaries.values()
        except ScoreError:
            return row | counts_record(source)
        return row | area_record(found.area) | {"psnr_y_db": None} | rates_record(found)

    def _about(self, name: Name) -> Record:
        """Return what names a system in a record."""
        upscaler = self.upscalers.get(name.method) if self.facts.scores is None else None
        label = name.method or "scores" if upscaler is None else upscaler.label
        return {
            "recogniser": name.recogniser or None,
            "option": name.option or None,
            "ipd_px": float(name.ipd_px) if name.ipd_px else None,
            "landmarks": name.landmarks or None,
            "method": name.method,
            "label": label,
        }


def _faces(simulation: Simulation, facts: Facts) -> dict[str, Sequence[torch.Tensor]]:
    """Return the first pictures of the case, if there are any, and of those who stand for it."""
    real: dict[str, Sequence[torch.Tensor]] = {}
    if facts.images is not None:
        files = sorted(one for one in facts.images.glob("*") if one.suffix.lower() in SUFFIXES)
        real = {"Pictures of the case": [read_image(file) for file in files[:_SHOWN]]}
    elif facts.pair is not None:
        files = [facts.pair.probe, facts.pair.enrolled]
        real = {"Pictures of the case": [read_image(file) for file in files]}
    simulated = {"Simulated": simulation.seen, "Enrolled": simulation.enrolled}
    return real | {
        label: [one.image for one in source.load(0, _SHOWN)] for label, source in simulated.items()
    }


def _alike(name: Name) -> tuple[str, str, str]:
    """Return what the case's pair and simulated ones have in common."""
    return name.recogniser, name.method, name.landmarks


def _score_for(scores: Mapping[Name, float], name: Name) -> float | None:
    """Return the case's score by a system; None where there is none, or no face was found."""
    found = {_alike(one): score for one, score in scores.items()}.get(_alike(name))
    return None if found is None or math.isnan(found) else found


def _evidence(about: Record, found: Weighed) -> Iterator[Record]:
    """Yield how good each calibration is."""
    for judged, some in found.evidence.items():
        for basis, one in some.items():
            yield {**about, "calibrated_on": basis, "judged_on": judged, **evidence_record(one)}


def _ratios(about: Record, found: Weighed) -> Iterator[Record]:
    """Yield what the case's score is worth by each calibration."""
    for basis, one in found.ratios.items():
        yield {**about, "calibrated_on": basis, **asdict(one)}
