"""Which pictures of QMUL-SurvFace are compared, and who is looked for among whom?

QMUL-SurvFace (Cheng, Zhu and Gong, *Surveillance face recognition challenge*, arXiv 1804.09691,
2018) has faces of 24 by 20 px on average from real surveillance. Verification: 5,320 pairs of one
person and as many of two. Open-set identification: 60,423 probes of the 3,000 people in the
gallery, and 121,736 of nobody in it. The user's copy is read, as its readme lays it out.
"""

from dataclasses import dataclass
from pathlib import Path

from lrsr.errors import InputError
from lrsr.pictures.folder import Entry
from lrsr.pictures.image_files import SUFFIXES
from lrsr.pictures.set_lists import photographs_of, read_listing, read_pairs
from lrsr.pictures.source import Photographs

_SEARCH = "Face_Identification_Test_Set"
_VERIFY = "Face_Verification_Test_Set"
_LISTS = {
    _SEARCH: (_SEARCH, "Face_Identification_Evaluation"),
    _VERIFY: (_VERIFY, "Face_Verification_Evaluation"),
}
"""Where the .mat files may lie."""


@dataclass(frozen=True)
class SurvFace:
    """A copy of the set.

    Attributes:
        root: The folder that holds ``Face_Identification_Test_Set`` and
            ``Face_Verification_Test_Set``.

    Raises:
        InputError: It holds neither.
    """

    root: Path

    def __post_init__(self) -> None:
        if not any((self.root / folder).is_dir() for folder in _LISTS):
            raise InputError(f"survface.root={self.root}: wanted the folder that holds {_SEARCH}")

    def search(self) -> tuple[Photographs, Photographs]:
        """Return probes, those of strangers last, and the gallery.

        Raises:
            InputError: A list or a picture is missing.
        """
        gallery = self._listed("gallery_img_ID_pairs.mat", "gallery", "gallery")
        mated = self._listed("mated_probe_img_ID_pairs.mat", "mated_probe", "mated_probe")
        folder = f"{_SEARCH}/unmated_probe"
        files = sorted(p for p in (self.root / folder).glob("*") if p.suffix.lower() in SUFFIXES)
        if not files:
            raise InputError(f"{self.root / folder} holds no pictures: unpack the set again")
        strangers = [
            Entry(f"{folder}/{path.name}", f"stranger {_person(path.name)}", "probe")
            for path in files
        ]
        return Photographs(self.root, [*mated.entries, *strangers]), gallery

    def pairs(self) -> tuple[Photographs, Photographs]:
        """Return the two pictures of every pair, those of one person first, in two lists.

        Raises:
            InputError: A list or a picture is missing, or the names of the files, which begin with
                the person's number, contradict the list.
        """
        sides: tuple[list[tuple[str, str]], list[tuple[str, str]]] = ([], [])
        for word, mated in (("positive", True), ("negative", False)):
            name = f"{word}_pairs_names"
            path = self._list(_VERIFY, f"{name}.mat")
            for pair in read_pairs(path, name):
                one, other = map(_person, pair)
                if (one == other) is not mated:
                    raise InputError(f"{path}: {pair[0]} and {pair[1]} are no {word} pair")
                for side, file, who in zip(sides, pair, (one, other), strict=True):
                    side.append((file, who))
        folder = f"{_VERIFY}/verification_images"
        probes, gallery = (
            photographs_of(self.root, folder, side, kind)
            for side, kind in zip(sides, ("probe", "gallery"), strict=True)
        )
        return probes, gallery

    def _listed(self, file: str, name: str, folder: str) -> Photographs:
        listing = read_listing(self._list(_SEARCH, file), f"{name}_set", f"{name}_ids")
        kind = "gallery" if name == "gallery" else "probe"
        return photographs_of(self.root, f"{_SEARCH}/{folder}", listing, kind)

    def _list(self, part: str, file: str) -> Path:
        places = [self.root / folder / file for folder in _LISTS[part]]
        return next((path for path in places if path.is_file()), places[0])


def _person(file: str) -> str:
    """Return whom a file shows: ``10002_cam3_1.jpg`` is of 10002."""
    return file.partition("_")[0].partition(".")[0]
