"""How many faces of TinyFace are found again, after each way of enlarging?"""

from dataclasses import dataclass, field, replace
from typing import ClassVar

from lrsr.experiments.set_trial import Part
from lrsr.experiments.surveillance_set import SurveillanceSet, root_of
from lrsr.pictures.tinyface import TinyFace


@dataclass(frozen=True)
class Wanted:
    """What of the set takes part.

    Attributes:
        root: The folder that holds ``Testing_Set``.
        distractors: How many; None: all.
    """

    root: str | None = None
    distractors: int | None = None


@dataclass(frozen=True)
class TinyFaceStudy(SurveillanceSet):
    """Every probe is looked for among its mates and the distractors.

    Attributes:
        wanted: What of the set takes part.
    """

    wanted: Wanted = field(default_factory=Wanted)

    key: ClassVar[str] = "tinyface"
    title: ClassVar[str] = "TinyFace"

    def parts(self) -> list[Part]:
        """Return the one search.

        Raises:
            InputError: The copy is not given, or cannot be used.
        """
        root = root_of(self.wanted.root, "tinyface.root", "qmul-tinyface.github.io")
        copy = TinyFace(root, self.wanted.distractors)
        pictures = {"probe": copy.probes(), "gallery": copy.gallery()}
        return [replace(self.part_of(1, self.title, pictures), search=True)]
