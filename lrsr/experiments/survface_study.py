"""How well are faces of QMUL-SurvFace compared and found, after each way of enlarging?"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

from lrsr.configuration import require
from lrsr.evaluation.arranged import Templates
from lrsr.experiments.set_trial import Part
from lrsr.experiments.surveillance_set import SurveillanceSet, root_of
from lrsr.pictures.survface import SurvFace

_PROTOCOLS = ("verification", "identification")


@dataclass(frozen=True)
class Wanted:
    """What of the set takes part.

    Attributes:
        root: The folder that holds the test sets.
        protocols: "verification", "identification" or both.

    Raises:
        InputError: There is no such protocol.
    """

    root: str | None = None
    protocols: list[str] = field(default_factory=lambda: ["verification"])

    def __post_init__(self) -> None:
        known = bool(self.protocols) and {*self.protocols} <= {*_PROTOCOLS}
        require(known, "survface.protocols", self.protocols, f"some of {', '.join(_PROTOCOLS)}")


@dataclass(frozen=True)
class SurvFaceStudy(SurveillanceSet):
    """Listed pairs are compared, and probes looked for among people, some of whom are nobody there.

    Attributes:
        wanted: What of the set takes part.
    """

    wanted: Wanted = field(default_factory=Wanted)

    key: ClassVar[str] = "survface"
    title: ClassVar[str] = "QMUL-SurvFace"

    def parts(self) -> list[Part]:
        """Return the protocols.

        Raises:
            InputError: The copy is not given, or cannot be used.
        """
        root = root_of(self.wanted.root, "survface.root", "qmul-survface.github.io")
        copy = SurvFace(root)
        found = []
        for number, protocol in enumerate(self.wanted.protocols, start=1):
            pairs = protocol == "verification"
            probes, gallery = copy.pairs() if pairs else copy.search()
            name = f"{self.title}, {protocol}"
            part = self.part_of(number, name, {"probe": probes, "gallery": gallery})
            if pairs:
                found.append(replace(part, listed=True))
                continue
            templates = {"gallery": Templates(gallery.identity_ids)}
            found.append(replace(part, search=True, templates=templates))
        return found

    def sentences(self) -> tuple[Sequence[str], Sequence[str]]:
        """Return what a report must say was done, and what was not."""
        if "identification" not in self.wanted.protocols:
            return (), ()
        return (
            ("A person's pictures in the gallery became one template, the mean of embeddings.",),
            (),
        )
