"""How well are templates of the IARPA Janus Benchmarks compared and found, however enlarged?"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import ClassVar

from lrsr.configuration import require
from lrsr.experiments.set_trial import Part
from lrsr.experiments.surveillance_set import SurveillanceSet, root_of
from lrsr.pictures.janus import JanusSet


@dataclass(frozen=True)
class Wanted:
    """What of the set takes part.

    Attributes:
        root: The folder that holds lists and pictures.
        galleries: Lists of enrolled templates; each is a gallery of its own.
        probes: The list of the templates that are looked for in each of them.
        path: Where the picture of a row is; see :class:`~lrsr.pictures.janus.JanusSet`.
        margin: Around a box, times its longer side.
        frames: At most so many of one medium; None: all.

    Raises:
        InputError: A number is out of range.
    """

    root: str | None = None
    galleries: list[str] = field(default_factory=list)
    probes: str | None = None
    path: str = "{filename}"
    margin: float = 0.0
    frames: int | None = None

    def __post_init__(self) -> None:
        require(self.margin >= 0, "ijb.margin", self.margin, "0 or more")
        require(self.frames is None or self.frames > 0, "ijb.frames", self.frames, "1 or more")


@dataclass(frozen=True)
class IjbStudy(SurveillanceSet):
    """Templates are compared with, and looked for in, each of the galleries.

    Attributes:
        wanted: What of the set takes part.
    """

    wanted: Wanted = field(default_factory=Wanted)

    key: ClassVar[str] = "ijb"
    title: ClassVar[str] = "IARPA Janus Benchmark"

    def parts(self) -> list[Part]:
        """Return a search for each gallery.

        Raises:
            InputError: The copy or a list is not given, or cannot be used.
        """
        asked = self.wanted
        root = root_of(asked.root, "ijb.root", "nist.gov/programs-projects/face-challenges")
        require(asked.probes is not None, "ijb.probes", None, "a CSV file of the set")
        require(bool(asked.galleries), "ijb.galleries", asked.galleries, "CSV files, [A.csv,B.csv]")
        copy = JanusSet(root, asked.path, asked.margin, asked.frames)
        probes, probe_templates = copy.read(Path(asked.probes), "probe")  # type: ignore[arg-type]
        found = []
        for number, file in enumerate(asked.galleries, start=1):
            gallery, templates = copy.read(Path(file), "gallery")
            pictures = {"probe": probes, "gallery": gallery}
            part = self.part_of(number, f"IJB, {Path(file).stem}", pictures)
            kinds = {"probe": probe_templates, "gallery": templates}
            found.append(replace(part, search=True, templates=kinds))
        return found

    def sentences(self) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a report must say was done, and what was not."""
        few = self.wanted.frames
        took = "" if few is None else f" At most {few} pictures of a medium took part."
        return (
            (
                "A template is the mean of the embeddings of its media, of which each is the mean"
                f" of its pictures.{took}",
            ),
            ("The lists of pairs of the set's own verification were not read: all were compared.",),
        )
