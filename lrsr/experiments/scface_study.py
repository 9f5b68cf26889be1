"""Does a recreated camera show what SCface's real one does? Photographs, and people rendered so.

Before a recreated camera stand the set's own people, whose heads are made from their mugshots
("SCFace Syn" in the paper's Tables 5 and 6), and synthetic ones.
"""

import logging
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

from lrsr.camera import Camera
from lrsr.configuration import require, words
from lrsr.experiments.agreement import OF_HEADS, OF_NOBODY, OF_SET, find_agreements
from lrsr.experiments.design import Design
from lrsr.experiments.intake import Intake, Told, counted, write_people
from lrsr.experiments.set_trial import Part, people_of
from lrsr.experiments.surveillance_set import OF_VERIFICATION, SurveillanceSet, root_of
from lrsr.experiments.table import Record
from lrsr.experiments.trial import known_landmarks
from lrsr.identities.roster import IdentityRange
from lrsr.paths import path_if_any
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.scface import CAMERAS, DISTANCES_M, MUGSHOTS, WHERE_TO_ASK, Mugshots, SCFace
from lrsr.pictures.source import Photographs
from lrsr.presets import preset

if TYPE_CHECKING:
    from omegaconf import DictConfig

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
_SYN = (
    "SCFace Syn: heads made from the mugshots, rendered as the recreated cameras see them, and "
    "compared with everyone's mugshot. Thresholds as above, of the people who became heads. Of {0}."
)
_NO_SYN = "SCFace Syn, heads made from the mugshots: {0}."
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
        heads: How mugshots become heads; None: they do not.
        looked: What became of each mugshot; :meth:`run` finds out.
        photographed: Those who became heads; None: too few did.

    Raises:
        InputError: There are not as many sizes as cameras.
    """

    wanted: Wanted = field(default_factory=Wanted)
    recreations: tuple[Camera, ...] = ()
    heads: Intake | None = None
    looked: tuple[Told, ...] = ()
    photographed: IdentityRange | None = None

    key: ClassVar[str] = "scface"
    title: ClassVar[str] = "SCface"
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
        heads = None if config.heads is None else Intake.from_config(config.heads)
        return replace(cls.wanting(asked, config), recreations=tuple(recreations), heads=heads)

    def describe(self) -> dict[str, Any]:
        """Return all of it in plain values, for ``results.json``."""
        told = Design.describe(self)
        kept = ("identities", "rendering", "gallery", "conditions")
        recreations = [camera.name for camera in self.recreations]
        return {
            **super().describe(),
            **{name: told[name] for name in kept},
            "recreations": recreations,
            "heads": self.heads and {**self.heads.describe(), "mugshots": counted(self.looked)},
        }

    def run(
        self,
        folder: Path,
        cache: RenderCache,
        *,
        maker: Maker | None = None,
        progress: bool = True,
    ) -> Path:
        """Make heads of the mugshots, then do as any set; see :class:`SurveillanceSet`.

        Who became a head, and who was refused, why, is written into ``heads`` in the folder.

        Raises:
            InputError: A file or a folder is wrong; nothing has been rendered by then.
        """
        if self.heads is None or self.wanted.root is None:
            return super().run(folder, cache, maker=maker, progress=progress)
        for part in self._real():  # what cannot be used is refused before anything is made
            known_landmarks(part.photographs.values(), self.recognition.landmarks)
        shown = self._copy.gallery(self._kinds[0])
        sources = {shown.root / entry.file: entry.identity_id for entry in shown.entries}
        looked = tuple(self.heads.look(sources, cache, progress=progress))
        write_people(folder / "heads", looked)
        logger.info("%s", counted(looked))
        count = sum(not told["why"] for told in looked)
        place = str(folder / "heads")
        people = IdentityRange(photographs=place, count=count) if count > 1 else None
        asked = replace(self, looked=looked, photographed=people)
        return super(SCFaceStudy, asked).run(folder, cache, maker=maker, progress=progress)

    def parts(self) -> list[Part]:
        """Return the real cameras, if there is a copy of the set, then the recreated ones.

        Those see the set's people, as far as they became heads, and then synthetic ones.

        Raises:
            InputError: The copy cannot be used.
        """
        found = self._real()
        for kind in self._kinds:
            if self.photographed is not None:
                found += self._syn(1 + len(found), self.photographed, kind)
        return [*found, *self._recreated(1 + len(found))]

    @property
    def _kinds(self) -> list[Mugshots]:
        return self.wanted.mugshots  # type: ignore[return-value]  # some of them, as checked

    @cached_property
    def _copy(self) -> SCFace:
        """The user's copy.

        Raises:
            InputError: There is none, or nothing of the set in it.
        """
        root = root_of(self.wanted.root, "scface.root", "scface.org")
        return SCFace(root, path_if_any(self.wanted.annotations, "scface.annotations"))

    def _real(self) -> list[Part]:
        wanted = self.wanted
        if wanted.root is None:
            logger.warning("the recreated cameras alone: %s", WHERE_TO_ASK)
            return []
        found: list[Part] = []
        for kind in self._kinds:
            gallery = self._copy.gallery(kind)
            for distance in wanted.distances:
                for camera in wanted.cameras:
                    metres = DISTANCES_M[distance]
                    name = f"{OF_SET}cam{camera}, {metres:g} m, {kind} mugshots"
                    pictures = {"probe": self._copy.probes(camera, distance), "gallery": gallery}
                    part = self.part_of(len(found) + 1, name, pictures)
                    here, there = self._sides(gallery)
                    found.append(replace(part, development=here, evaluation=there))
        return found

    def _sides(self, gallery: Photographs) -> tuple[frozenset[str], frozenset[str]]:
        """Return on whom of the set a threshold is set, and on whom it is judged."""
        numbers = self.wanted.development, self.wanted.evaluation
        here, there = (people_of(gallery, some) for some in numbers)
        return here, there

    def _syn(self, first: int, people: IdentityRange, kind: Mugshots) -> list[Part]:
        """Return the recreated cameras before the set's own people.

        Args:
            first: Number of the first part.
            people: Who became a head.
            kind: Of the mugshots that are enrolled.
        """
        gallery = self._copy.gallery(kind)
        here, there = self._sides(gallery)
        return [
            Part(
                f"{OF_HEADS}{name}, {kind} mugshots",
                replace(design, people=people),
                {"gallery": gallery},
                development=here,
                evaluation=there,
            )
            for name, design in self._designs(first)
        ]

    def _recreated(self, first: int) -> list[Part]:
        people = [person.id for person in self.people.people()]
        half = len(people) // 2
        sides = frozenset(people[:half]), frozenset(people[half:])
        return [
            Part(f"{OF_NOBODY}{name}", design, development=sides[0], evaluation=sides[1])
            for name, design in self._designs(first)
        ]

    def _designs(self, first: int) -> Iterator[tuple[str, Self]]:
        """Yield each recreated camera's name and what it is asked, numbered from the first on."""
        each = len(self.conditions) // len(self.recreations)
        for place, condition in enumerate(self.conditions):
            camera = self.recreations[place // each]
            told = condition.title.partition(": ")[2] if each > 1 else ""
            numbered = replace(condition, option=first + place)
            design = replace(self, camera=camera, conditions=(numbered,))
            yield camera.name + (f", {told}" if told else ""), design

    def sentences(self) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a report must say was done, and what was not."""
        if self.wanted.root is None:
            return (_RECREATED,), (_NO_SET,)
        real = _REAL.format(*self.wanted.development, *self.wanted.evaluation)
        count = counted(self.looked)
        done = (real, _POINTS, *([_SYN.format(count)] if self.photographed else []), _RECREATED)
        why = f"too few of them could be made, of {count}" if self.heads else "heads=null"
        missing = () if self.photographed else (_NO_SYN.format(why),)
        return done, (*missing, _NOT_LEARNED)

    def compared(self, rows: Sequence[Record]) -> dict[str, list[Record]]:
        """Say whether recreated cameras put the methods in the order of the real ones."""
        return {"agreements": find_agreements(rows)} if self.wanted.root is not None else {}
