"""Where are the faces on somebody's own photographs? Each is looked over once, and cut out."""

import hashlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional as F
from tqdm import tqdm

from lrsr.configuration import require, settle
from lrsr.errors import InputError
from lrsr.images import resize_bicubic, scale_points
from lrsr.pictures.folder import Entry, read_picture
from lrsr.pictures.image_files import read_file
from lrsr.pictures.picture import Picture
from lrsr.pictures.source import Photographs
from lrsr.recognition.finder import Finder

_Floats = NDArray[np.floating[Any]]


@dataclass(frozen=True)
class Cut:
    """What of a large photograph is enlarged and recognised.

    Attributes:
        ipds: Side of the square about the face, in distances of its pupils.
        longest_px: A photograph of longer sides is cut; what is cut out and still longer, or shows
            no face to cut out, is shrunk to this.

    Raises:
        InputError: A number is out of range.
    """

    ipds: float = 6.0
    longest_px: int = 384

    def __post_init__(self) -> None:
        settle(self, "cut")
        require(self.ipds >= 3, "cut.ipds", self.ipds, "at least 3: less holds no whole face")
        require(self.longest_px >= 112, "cut.longest_px", self.longest_px, "at least 112")

    def __call__(self, picture: Picture, landmarks_px: _Floats | None) -> Picture:
        """Return a picture, or what of it shows the face.

        Args:
            picture: As a camera stored it.
            landmarks_px: ``(5, 2)`` of the face; None: it is not known where it is.
        """
        if max(picture.image.shape[1:]) <= self.longest_px:
            return picture
        if landmarks_px is not None:
            picture = _cropped(picture, landmarks_px, self.ipds * _pupils_apart(landmarks_px))
        longest = max(picture.image.shape[1:])
        return picture if longest <= self.longest_px else _shrunk(picture, self.longest_px)


@dataclass(frozen=True, eq=False)
class Portrait:
    """A photograph that could be read, and the face on it.

    Attributes:
        entry: What its folder says of it.
        sha256: Of its file.
        size_px: (height, width).
        landmarks_px: ``(5, 2)``: those that are given, else those that were found; None: neither.
        detector_score: [0, 1]; None: nothing was found, or nobody looked.
    """

    entry: Entry
    sha256: str
    size_px: tuple[int, int]
    landmarks_px: _Floats | None
    detector_score: float | None

    @property
    def ipd_px(self) -> float | None:
        """Distance of the pupils; None where no face is known."""
        return None if self.landmarks_px is None else _pupils_apart(self.landmarks_px)

    def describe(self) -> dict[str, Any]:
        """Return what a report says of it, in plain values."""
        return {
            "file": self.entry.file,
            "identity_id": self.entry.identity_id,
            "width_px": self.size_px[1],
            "height_px": self.size_px[0],
            "ipd_px": self.ipd_px,
            "detector_score": self.detector_score,
        }


@dataclass(frozen=True)
class Portraits:
    """Photographs that could be read, cut as they are loaded.

    Attributes:
        root: Their folder.
        members: In order.
        cut: What of each is taken.
    """

    root: Path
    members: Sequence[Portrait]
    cut: Cut

    @property
    def identity_ids(self) -> Sequence[str]:
        """Who each picture shows, as its folder says."""
        return [one.entry.identity_id for one in self.members]

    @property
    def names(self) -> Sequence[str]:
        """The file of each picture."""
        return [one.entry.file for one in self.members]

    def load(self, start: int, stop: int) -> list[Picture]:
        """Read and cut the pictures ``start`` to ``stop - 1``.

        Raises:
            InputError: One cannot be read any more.
        """
        return [
            self.cut(read_picture(self.root, one.entry), one.landmarks_px)
            for one in self.members[start:stop]
        ]


def look_over(
    photographs: Photographs, finder: Finder | None, *, progress: bool = True
) -> tuple[list[Portrait], list[InputError]]:
    """Look at every photograph of a folder.

    Args:
        photographs: Of the folder.
        finder: Finds faces; None: only those that are given are known.
        progress: Show a bar.

    Returns:
        Those that could be read, and what was wrong with each of the others.
    """
    found, refused = [], []
    bar = tqdm(photographs.entries, photographs.root.name, unit="photo", disable=not progress)
    for entry in bar:
        try:
            found.append(look_at(photographs.root, entry, finder))
        except InputError as error:
            refused.append(error)
    return found, refused


def look_at(root: Path, entry: Entry, finder: Finder | None) -> Portrait:
    """Look at one photograph.

    Raises:
        InputError: It cannot be read.
    """
    content = read_file(root / entry.file)
    picture = read_picture(root, entry)
    points = None if picture.landmarks_px is None else picture.landmarks_px.numpy()
    score = None
    if finder is not None:
        faces = finder(picture.image[None])
        if np.isfinite(faces.scores[0]):
            score = float(faces.scores[0])
            points = faces.landmarks_px[0] if points is None else points
    height, width = picture.image.shape[1:]
    return Portrait(entry, hashlib.sha256(content).hexdigest(), (height, width), points, score)


def without_copies(
    probes: Sequence[Portrait], gallery: Sequence[Portrait]
) -> tuple[list[Portrait], list[tuple[Portrait, Portrait]]]:
    """Leave out probes whose very file is in the gallery, too: it would be compared with itself.

    Returns:
        The others, and each that was left out with its copy.
    """
    enrolled = {one.sha256: one for one in reversed(gallery)}
    copies = [(one, enrolled[one.sha256]) for one in probes if one.sha256 in enrolled]
    return [one for one in probes if one.sha256 not in enrolled], copies


def _pupils_apart(landmarks_px: _Floats) -> float:
    """Return the distance of the first two of five landmarks, px.

    Example:
        >>> _pupils_apart(np.array([[0, 0], [3, 4], [0, 0], [0, 0], [0, 0]]))
        5.0
    """
    return float(np.linalg.norm(landmarks_px[1] - landmarks_px[0]))


def _cropped(picture: Picture, landmarks_px: _Floats, side_px: float) -> Picture:
    """Return the square about a face, as much of it as the picture holds."""
    height, width = picture.image.shape[1:]
    x, y = landmarks_px.mean(axis=0).tolist()
    left, right = _within(x, side_px, width)
    top, bottom = _within(y, side_px, height)
    image = picture.image[:, top:bottom, left:right].contiguous()
    points = picture.landmarks_px
    moved = None if points is None else points - torch.tensor([left, top], dtype=points.dtype)
    return replace(picture, image=image, landmarks_px=moved)


def _within(middle: float, side_px: float, size_px: int) -> tuple[int, int]:
    """Return first and end of a span about a place, inside a picture; at least 16 px long."""
    half = max(side_px / 2, 8.0)
    first = min(max(0, round(middle - half)), max(0, size_px - 16))
    return first, max(min(size_px, round(middle + half)), min(size_px, first + 16))


def _shrunk(picture: Picture, longest_px: int) -> Picture:
    """Return a picture made smaller by the least whole factor that makes it fit."""
    height, width = picture.image.shape[1:]
    factor = math.ceil(max(height, width) / longest_px)
    spare = (0, -width % factor, 0, -height % factor)
    image = resize_bicubic(F.pad(picture.image[None], spare, mode="replicate"), 1 / factor)
    points = picture.landmarks_px
    return replace(
        picture,
        image=image[0].clamp(0, 1),
        landmarks_px=None if points is None else scale_points(points, 1 / factor),
    )
