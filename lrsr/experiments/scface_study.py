"""Does a recreated camera show what SCface's real one does? Photographs, and people rendered so."""

import logging
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from scipy.stats import kendalltau

from lrsr.camera import Camera
from lrsr.configuration import require, words
from lrsr.experiments.design import Design
from lrsr.experiments.set_trial import Part, people_of
from lrsr.experiments.surveillance_set import OF_VERIFICATION, SurveillanceSet
from lrsr.experiments.table import Record
from lrsr.paths import path_if_any
from lrsr.pictures.scface import CAMERAS, DISTANCES_M, MUGSHOTS, WHERE_TO_ASK, SCFace
from lrsr.presets import preset

if TYPE_CHECKING:
    from omegaconf import DictConfig

_MOST_FEW = 3
"""Methods from which on their order says something."""

_RECREATED = (
    "Recreated: synthetic people, rendered where SCface's cameras stood, by camera presets whose "
    "numbers are estimates (docs/camera.md). Half of the people set the threshold, half are judged."
)
_REAL = (
    "SCface: everyone's mugshot is enrolled. The threshold is that of people {0} to {1}, judged on "
    "{2} to {3}, as bob.db.scface splits them; all people are in every other figure."
)
_POINTS = (
    "SCface's coordinates were read, as shared landmarks: its middle of the mouth became two "
    "corners. Of cropped mugshots there are none."
)
_NO_SET = f"The set itself took no part: {WHERE_TO_ASK}."
_NO_HEADS = (
    "The row 'SCFace Syn' of the paper, heads made from the set's own mugshots, is missing: lrsr "
    "does not make a head from a photograph yet."
)
_NOT_LEARNED = "Nothing was fitted to SCface: neither the recreated cameras nor a network."

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Wanted:
    """What of the set takes part; see ``conf/experiment/scface.yaml``.

    Attributes:
        root: The folder of the set; None: the recreations alone.
        annotations: See :class:`lrsr.pictures.scface.SCFace`.
        cameras: Numbers, 1 to 7.
        distances: Numbers, 1 to 3.
        mugshots: "original", "cropped" or both.
        development: Numbers of the first and the last one on whom the threshold is set.
        evaluation: Of those on whom it is judged.

    Raises:
        InputError: There is no such camera, distance or kind of mugshot, or somebody is on both
            sides of the threshold.
    """

    root: str | None = None
    annotations: str | None = None
    cameras: list[int] = field(default_factory=lambda: [1, 3])
    distances: list[int] = field(default_factory=lambda: [1])
    mugshots: list[str] = field(default_factory=lambda: [*MUGSHOTS])
    development: list[int] = field(default_factory=lambda: [44, 87])
    evaluation: list[int] = field(default_factory=lambda: [88, 130])

    def __post_init__(self) -> None:
        known = {"cameras": CAMERAS, "distances": DISTANCES_M, "mugshots": MUGSHOTS}
        for name, some in known.items():
            given = getattr(self, name)
            wish = f"some of {', '.join(map(str, some))}, each once"
            right = given and len({*given}) == len(given) and {*given} <= {*some}
            require(bool(right), f"scface.{name}", given, wish)
        for name in ("development", "evaluation"):
            given = getattr(self, name)
            require(len(given) == 2, f"scface.{name}", given, "the first and the last, [44,87]")
        (a, b), (c, d) = self.development, self.evaluation
        wish = f"people who are not among scface.development={self.development}"
        require(b < c or d < a, "scface.evaluation", self.evaluation, wish)


@dataclass(frozen=True)
class SCFaceStudy(SurveillanceSet):
    """Recreated cameras beside the real ones, where there is a copy of the set.

    Attributes:
        wanted: What of the set takes part.
        recreations: Cameras, a size of :attr:`conditions` each.

    Raises:
        InputError: There are not as many sizes as cameras.
    """

    wanted: Wanted = field(default_factory=Wanted)
    recreations: tuple[Camera, ...] = ()

    key: ClassVar[str] = "scface"
    unread: ClassVar[tuple[str, ...]] = ("camera", "probes", *OF_VERIFICATION)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr eval``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        folder = config.gallery.folder
        wish = "null: the mugshots of scface.root are enrolled"
        require(folder is None, "gallery.folder", folder, wish)
        recreations = [preset("camera", name) for name in words(config, "recreations")]
        asked = super(SurveillanceSet, cls).from_config(config)
        sizes = len({*map(id, recreations)})
        wish = f"as many sizes as recreations, {sizes}"
        told = [one.ipd_px for one in asked.conditions]
        require(bool(sizes) and len(told) % sizes == 0, "ipd_px", told, wish)
        return replace(cls.wanting(asked, config), recreations=tuple(recreations))

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        told = Design.describe(self)
        kept = ("identities", "rendering", "gallery", "conditions")
        recreations = [camera.name for camera in self.recreations]
        return {
            **super().describe(),
            **{name: told[name] for name in kept},
            "recreations": recreations,
        }

    def parts(self) -> list[Part]:
        """Return the real cameras, if there is a copy of the set, then the recreated ones.

        Raises:
            InputError: The copy cannot be used.
        """
        real = self._real()
        return [*real, *self._recreated(1 + len(real))]

    def _real(self) -> list[Part]:
        wanted = self.wanted
        root = path_if_any(wanted.root, "scface.root")
        if root is None:
            logger.warning("the recreated cameras alone: %s", WHERE_TO_ASK)
            return []
        copy = SCFace(root, path_if_any(wanted.annotations, "scface.annotations"))
        found: list[Part] = []
        for mugshots in wanted.mugshots:
            gallery = copy.gallery(mugshots)  # type: ignore[arg-type]  # one of them, as checked
            for distance in wanted.distances:
                for camera in wanted.cameras:
                    metres = DISTANCES_M[distance]
                    name = f"SCface cam{camera}, {metres:g} m, {mugshots} mugshots"
                    pictures = {"probe": copy.probes(camera, distance), "gallery": gallery}
                    part = self.part_of(len(found) + 1, name, pictures)
                    here = people_of(gallery, wanted.development)
                    there = people_of(gallery, wanted.evaluation)
                    found.append(replace(part, development=here, evaluation=there))
        return found

    def _recreated(self, first: int) -> list[Part]:
        each = len(self.conditions) // len(self.recreations)
        people = [person.id for person in self.people.people()]
        half = len(people) // 2
        found = []
        for place, condition in enumerate(self.conditions):
            camera = self.recreations[place // each]
            told = condition.title.partition(": ")[2] if each > 1 else ""
            name = f"Recreated {camera.name}" + (f", {told}" if told else "")
            numbered = replace(condition, option=first + place)
            design = replace(self, camera=camera, conditions=(numbered,))
            sides = frozenset(people[:half]), frozenset(people[half:])
            part = Part(name, design, development=sides[0], evaluation=sides[1])
            found.append(part)
        return found

    def sentences(self) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a report must say was done, and what was not."""
        if self.wanted.root is None:
            return (_RECREATED,), (_NO_SET, _NO_HEADS)
        real = _REAL.format(*self.wanted.development, *self.wanted.evaluation)
        return (real, _POINTS, _RECREATED), (_NO_HEADS, _NOT_LEARNED)

    def compared(self, rows: Sequence[Record]) -> dict[str, list[Record]]:
        """Say whether recreated cameras put the methods in the order of the real ones."""
        return {"agreements": _agreements(rows)} if self.wanted.root is not None else {}


def _agreements(rows: Sequence[Record]) -> list[Record]:
    """Return how alike real and recreated cameras order the methods, by their AUC.

    Each real camera is held against every recreation of its number, with landmarks of the same
    source and the same recogniser: Kendall's tau-b, 1 where the order is the same and -1 where it
    is turned round; None where one of them ties all.

    Args:
        rows: Of all parts; ``setting`` says which part.
    """
    areas: dict[tuple[str, str, str], dict[str, float]] = {}
    for row in rows:
        if row["auc"] is not None:
            place = (row["recogniser"], row["landmarks"], row["setting"])
            areas.setdefault(place, {})[row["label"]] = row["auc"]
    found = []
    for (recogniser, landmarks, name), real in areas.items():
        if not name.startswith("SCface "):
            continue
        camera = name.split()[1].rstrip(",")
        for (*same, other), made in areas.items():
            shared = [label for label in real if label in made]
            recreated = f"Recreated scface_{camera}"
            apart = same != [recogniser, landmarks] or other.partition(",")[0] != recreated
            if apart or len(shared) < _MOST_FEW:
                continue
            tau = float(kendalltau([real[k] for k in shared], [made[k] for k in shared]).statistic)
            names = {"recogniser": recogniser, "landmarks": landmarks}
            told = {"real": name, "recreated": other, "methods": len(shared)}
            found.append({**names, **told, "kendall_tau": None if tau != tau else tau})
    return found
