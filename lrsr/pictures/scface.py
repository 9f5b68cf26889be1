"""Which pictures of SCface are there, of whom, by which camera, and where are their eyes?

SCface (Grgic, Delac and Grgic, *SCface - surveillance cameras face database*, Multimedia Tools and
Applications 51, 2011) has 130 people, each by five cameras in visible light and two in infrared, at
4.2, 2.6 and 1.0 m, and on a mugshot. It is not public: scface.org hands it out after an agreement.
Both layouts of it are read: all pictures of the cameras in one folder, or in a folder for each
distance and camera.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Literal, get_args

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import read_bytes
from lrsr.images import resize_bicubic, scale_points
from lrsr.pictures.folder import Entry, read_picture
from lrsr.pictures.image_files import SUFFIXES
from lrsr.pictures.picture import Picture
from lrsr.pictures.source import Photographs

WHERE_TO_ASK = "ask for SCface at scface.org, then give scface.root=DIR"

DISTANCES_M = {1: 4.2, 2: 2.6, 3: 1.0}
"""How far from the camera, by the number in a file's name."""

CAMERAS = range(1, 8)
"""In visible light 1 to 5, in infrared 6 and 7."""

Mugshots = Literal["original", "cropped"]
MUGSHOTS: tuple[Mugshots, ...] = get_args(Mugshots)

_PATTERNS = (
    "surveillance_cameras_all/*",
    "surveillance_cameras_distance_*/cam_*/*",
    *(f"mugshot_frontal_{kind}_all/*" for kind in MUGSHOTS),
)
_NAME = re.compile(r"(\d{3})_(?:cam(\d)_(\d)|(frontal))", re.IGNORECASE)
_POINTS = ("leye", "reye", "nose", "mouth")
_LARGEST_PX = 768
"""Of a mugshot's longer side, which leaves some 80 px between the eyes: 64 of 6 megapixels at once
would not fit into memory."""

_HALF_MOUTH_IPDS = 0.414
"""From the middle of the mouth to its corner, in distances of the eyes, as in ArcFace's template:
SCface has the middle alone. (Estimated.)"""


@dataclass(frozen=True)
class SCFace:
    """A copy of the set.

    Attributes:
        root: The folder that holds ``mugshot_frontal_original_all`` and the others.
        annotations: A file of coordinates as the set has it (``NNN_camC_D`` and eight numbers a
            line: eyes, nose, mouth), or a folder of bob's ``.pos`` files; None: lines of the
            ``.txt`` files in ``root``, and ``.pos`` files beside the pictures, if there are any.

    Raises:
        InputError: There is no such folder, or nothing of the set in it.
    """

    root: Path
    annotations: Path | None = None

    def __post_init__(self) -> None:
        if not self._files:
            raise InputError(
                f"scface.root={self.root}: wanted the folder with surveillance_cameras_all or"
                " surveillance_cameras_distance_1, and mugshot_frontal_original_all"
            )

    def gallery(self, mugshots: Mugshots) -> Photographs:
        """Return everyone's frontal mugshot.

        Those of more than 768 px are shrunk by the least whole factor that brings them below, so
        that many fit into memory.

        Args:
            mugshots: As the camera took it, or cut to the face. The set's coordinates are those of
                the former; of the latter none are known.

        Raises:
            InputError: There are none, or coordinates cannot be read.
        """
        folder = f"mugshot_frontal_{mugshots}_all"
        require(mugshots in MUGSHOTS, "scface.mugshots", mugshots, f"of {', '.join(MUGSHOTS)}")
        shown = [path for path in self._files if path.parent.name == folder]
        if not shown:
            raise InputError(f"{self.root / folder} holds no NNN_frontal.jpg: copy them there")
        known = mugshots == "original"
        entries = [self._entry(path, kind="gallery", known=known) for path in shown]
        return _Shrunk(self.root, entries)

    def probes(self, camera: int, distance: int) -> Photographs:
        """Return what one camera saw of everybody at one distance.

        Raises:
            InputError: There is no such camera, distance or picture, or coordinates cannot be read.
        """
        require(camera in CAMERAS, "scface.cameras", camera, "of 1 to 7")
        require(distance in DISTANCES_M, "scface.distances", distance, "of 1, 2, 3")
        end = f"_cam{camera}_{distance}"
        shown = {p.stem.lower(): p for p in self._files if p.stem.lower().endswith(end)}
        if not shown:
            raise InputError(f"{self.root} holds no picture NNN{end}.jpg: leave that camera out")
        named = f"scface_cam{camera}"
        entries = [self._entry(shown[stem], kind="probe", camera=named) for stem in sorted(shown)]
        return Photographs(self.root, entries)

    @cached_property
    def _files(self) -> list[Path]:
        """Every picture of the set, in order."""
        found = (path for pattern in _PATTERNS for path in sorted(self.root.glob(pattern)))
        return [p for p in found if p.suffix.lower() in SUFFIXES and _NAME.fullmatch(p.stem)]

    def _entry(self, path: Path, *, kind: str, known: bool = True, camera: str = "") -> Entry:
        points = self._points(path) if known else None
        return Entry(
            file=path.relative_to(self.root).as_posix(),
            identity_id=path.stem[:3],
            kind=kind,
            camera=camera,
            ipd_px=None if points is None else math.dist(points[:2], points[2:4]),
            landmarks_px=points,
        )

    def _points(self, path: Path) -> tuple[float, ...] | None:
        if (listed := self._listed.get(path.stem.lower())) is not None:
            return listed
        folder = path.parent if self.annotations is None else self.annotations
        beside = folder / f"{path.stem}.pos"
        return _read_pos(beside) if beside.is_file() else None

    @cached_property
    def _listed(self) -> dict[str, tuple[float, ...]]:
        """Landmarks of coordinates files, by the picture's name.

        Raises:
            InputError: One cannot be read.
        """
        if self.annotations is None:
            files = sorted(self.root.glob("*.txt"))
        elif self.annotations.exists():
            files = [self.annotations] if self.annotations.is_file() else []
        else:
            raise InputError(f"scface.annotations={self.annotations} does not exist: mend the path")
        return {name: points for file in files for name, points in _read_coordinates(file)}


@dataclass(frozen=True)
class _Shrunk(Photographs):
    """Photographs of which large ones are shrunk by a whole factor."""

    def load(self, start: int, stop: int) -> list[Picture]:
        """Read the pictures ``start`` to ``stop - 1``; see :class:`Photographs`."""
        return [_shrink(read_picture(self.root, one)) for one in self.entries[start:stop]]


def _shrink(picture: Picture) -> Picture:
    factor = math.ceil(max(picture.image.shape[1:]) / _LARGEST_PX)
    if factor == 1:
        return picture
    height, width = (side // factor * factor for side in picture.image.shape[1:])
    small = resize_bicubic(picture.image[None, :, :height, :width], 1 / factor)[0].clamp(0, 1)
    points = picture.landmarks_px
    return replace(
        picture,
        image=small,
        landmarks_px=None if points is None else scale_points(points, 1 / factor),
    )


def _read_coordinates(file: Path) -> Iterator[tuple[str, tuple[float, ...]]]:
    """Yield name and landmarks of every line that has a picture's name and eight numbers.

    Raises:
        InputError: The file cannot be read, or what follows a name is no number such as 8.5.
    """
    for number, line in enumerate(_lines(file), start=1):
        words = line.replace(",", " ").replace(";", " ").split()
        stem = words[0].partition(".")[0].lower() if words else ""
        if len(words) == 17 and "," in line and _NAME.fullmatch(stem):
            raise InputError(f"{file}, line {number}: decimal commas; save it with decimal points")
        if len(words) == 9 and _NAME.fullmatch(stem):
            values = _numbers(words[1:], file, number)
            yield (
                stem,
                _five(dict(zip(_POINTS, zip(*[iter(values)] * 2, strict=True), strict=True))),
            )


def _read_pos(file: Path) -> tuple[float, ...]:
    """Read the landmarks of one picture: a line "NAME x y" each, as bob.db's "named" files.

    Raises:
        InputError: The file cannot be read, or lacks a point.
    """
    points = {}
    for number, line in enumerate(_lines(file), start=1):
        words = line.split()
        if len(words) == 3 and words[0] in _POINTS:
            x, y = _numbers(words[1:], file, number)
            points[words[0]] = (x, y)
    if missing := [name for name in _POINTS if name not in points]:
        raise InputError(f"{file}: no {missing[0]}; wanted lines such as '{missing[0]} 31 42'")
    return _five(points)


def _lines(file: Path) -> list[str]:
    try:
        return read_bytes(file).decode("utf-8-sig", errors="replace").splitlines()
    except OSError as error:
        raise InputError(f"cannot read {file}: {error.strerror or error}; mend it") from error


def _numbers(words: list[str], file: Path, line: int) -> list[float]:
    try:
        return [float(word) for word in words]
    except ValueError as error:
        raise InputError(f"{file}, line {line}: {error}; wanted x and y, px") from error


def _five(points: dict[str, tuple[float, float]]) -> tuple[float, ...]:
    """Return left eye, right eye, nose and corners of the mouth as seen, ``(10,)``.

    Whichever eye an annotator calls the left one: a face is never upside down here.
    """
    left, right = sorted((points["leye"], points["reye"]))
    along = [_HALF_MOUTH_IPDS * (b - a) for a, b in zip(left, right, strict=True)]
    mouth = points["mouth"]
    corners = [m + sign * a for sign in (-1, 1) for m, a in zip(mouth, along, strict=True)]
    return (*left, *right, *points["nose"], *corners)
