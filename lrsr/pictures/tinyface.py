"""Which pictures of TinyFace are looked for, and among which?

TinyFace (Cheng, Zhu and Gong, *Low-resolution face recognition*, ACCV 2018) has faces of 20 by 16
px on average: 3,728 probes are searched for among 4,443 pictures of the same 2,569 people and
153,428 distractors, who are none of them. The user's copy is read, as its readme lays it out.
"""

from dataclasses import dataclass
from pathlib import Path

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.pictures.folder import Entry
from lrsr.pictures.image_files import SUFFIXES
from lrsr.pictures.set_lists import photographs_of, read_listing
from lrsr.pictures.source import Photographs

_TEST = "Testing_Set"
_LISTS = ("", "../Face_Identification_Evaluation")
"""Where the .mat files may lie, seen from the test set."""


@dataclass(frozen=True)
class TinyFace:
    """A copy of the set.

    Attributes:
        root: The folder that holds ``Testing_Set``.
        distractors: How many of them, the first by name; None: all.

    Raises:
        InputError: There is no such folder, or fewer distractors are asked for than 0.
    """

    root: Path
    distractors: int | None = None

    def __post_init__(self) -> None:
        if not (self.root / _TEST).is_dir():
            raise InputError(f"tinyface.root={self.root}: wanted the folder that holds {_TEST}")
        few = self.distractors is not None and self.distractors < 0
        require(not few, "tinyface.distractors", self.distractors, "0 or more, or null")

    def probes(self) -> Photographs:
        """Return whoever is looked for.

        Raises:
            InputError: A list or a picture is missing.
        """
        return self._listed("probe_img_ID_pairs.mat", "probe", "Probe")

    def gallery(self) -> Photographs:
        """Return their mates, and the distractors, each of whom is a person of their own.

        Raises:
            InputError: A list or a picture is missing.
        """
        mates = self._listed("gallery_match_img_ID_pairs.mat", "gallery", "Gallery_Match")
        folder = self.root / _TEST / "Gallery_Distractor"
        found = sorted(p for p in folder.rglob("*") if p.suffix.lower() in SUFFIXES)
        if not found and self.distractors != 0:
            raise InputError(f"{folder} holds no pictures: copy them, or tinyface.distractors=0")
        others = [
            Entry(path.relative_to(self.root).as_posix(), f"distractor {path.stem}", "gallery")
            for path in found[: self.distractors]
        ]
        return Photographs(self.root, [*mates.entries, *others])

    def _listed(self, file: str, name: str, folder: str) -> Photographs:
        test = self.root / _TEST
        path = next((p for place in _LISTS if (p := test / place / file).is_file()), test / file)
        listing = read_listing(path, f"{name}_set", f"{name}_ids")
        return photographs_of(self.root, f"{_TEST}/{folder}", listing, name)
