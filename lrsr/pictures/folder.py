"""Which pictures are in this folder, and what is known of each?

``manifest.csv`` has a row a picture; ``lrsr render`` writes one, and any CSV with the columns
``file`` and ``identity_id`` serves, whatever other columns it has and in whichever order. A folder
without one is read, too: pictures in a sub-folder show the person that it is named after, others
the person that the file is named after.
"""

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, fields
from pathlib import Path, PurePosixPath
from typing import Any

import numpy as np
import torch

from lrsr.errors import InputError
from lrsr.files import write_text
from lrsr.identities.person import Traits
from lrsr.pictures.image_files import SUFFIXES, read_image
from lrsr.pictures.picture import Picture
from lrsr.tables import read_rows

MANIFEST = "manifest.csv"


@dataclass(frozen=True)
class Entry:
    """One picture of a folder; the fields are the columns, empty where nothing is known.

    Attributes:
        file: Path relative to the folder, with forward slashes.
        identity_id: Who it is.
        kind: "probe" or "gallery".
        pose: Name.
        lighting: Name.
        compression: Name.
        camera: Name of the preset.
        ipd_px: Interpupillary distance of the frontal face on the ×1 film, px.
        scale: How many times finer than the ×1 film this picture is.
        seed: Of the sampler.
        landmarks_px: Ten numbers, x y of left eye, right eye, nose, left and right mouth corner
            as seen in the image, px of this picture, separated by spaces in the file.
        linear_file: The linear light of the same picture in 16 bits, if it was asked for.
        sex: "female" or "male".
        age_years: As drawn.
        ancestry: Share of each, e.g. "african=0.02 asian=0.9 caucasian=0.08".
        ita_deg: Individual typology angle of the bare cheeks' albedo; see
            :mod:`lrsr.identities.person`.
        skin_tone: Its class, "very light" to "dark".
        expression: Name.
        lens: Name.
        standpoint: Name.
        yaw_deg: Of the head; see :class:`lrsr.rendering.pose.Pose`, as the next two.
        pitch_deg: Of the head.
        roll_deg: Of the head.
        skin: Name of what light meets.
        samples_per_pixel: Of the ×1 film.
        run_seed: From which that of the sampler follows.
        another_day: Name of what may have changed since the person was enrolled.
        changes: What has, e.g. "hair=cut years=4.2 glasses=round".
        frame: Number of the picture in the burst that it belongs to; 0 is the first, or the only
            one.
        settings: Everything that made the picture, as JSON.
        further: Columns that are not ours, by their names.
    """

    file: str
    identity_id: str
    kind: str = ""
    pose: str = ""
    lighting: str = ""
    compression: str = ""
    camera: str = ""
    ipd_px: float | None = None
    scale: int = 1
    seed: int | None = None
    landmarks_px: tuple[float, ...] | None = None
    linear_file: str = ""
    sex: str = ""
    age_years: str = ""
    ancestry: str = ""
    ita_deg: str = ""
    skin_tone: str = ""
    expression: str = ""
    lens: str = ""
    standpoint: str = ""
    yaw_deg: float | None = None
    pitch_deg: float | None = None
    roll_deg: float | None = None
    skin: str = ""
    samples_per_pixel: int | None = None
    run_seed: int | None = None
    another_day: str = ""
    changes: str = ""
    frame: int = 0
    settings: str = ""
    further: Mapping[str, str] = field(default_factory=dict)


_COLUMNS = tuple(each.name for each in fields(Entry) if each.name != "further")
_REQUIRED = ("file", "identity_id")


def about(traits: Traits | None) -> dict[str, Any]:
    """Return the columns that tell who a picture shows; none where that is not known."""
    if traits is None:
        return {}
    return {
        "sex": traits.sex,
        "age_years": f"{traits.age_years:g}",
        "ancestry": " ".join(f"{race}={share:g}" for race, share in traits.ancestry.items()),
        "ita_deg": f"{traits.ita_deg:g}",
        "skin_tone": traits.skin_tone,
        "changes": " ".join(f"{kind}={what}" for kind, what in (traits.changes or {}).items()),
    }


def write_manifest(folder: Path, entries: Iterable[Entry]) -> Path:
    """Write ``manifest.csv`` into ``folder``, whole or not at all; return its path.

    Raises:
        InputError: The folder cannot be written or the disk is full.
    """
    entries = list(entries)
    further = list(dict.fromkeys(name for entry in entries for name in entry.further))
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow([*_COLUMNS, *further])
    for entry in entries:
        own = [_text(getattr(entry, name)) for name in _COLUMNS]
        writer.writerow([*own, *(entry.further.get(name, "") for name in further)])
    path = folder / MANIFEST
    write_text(path, text.getvalue())
    return path


def _text(value: object) -> str:
    if value is None:
        return ""
    if isinstance(value, tuple):  # as exact as the points of a picture are: float32
        return " ".join(str(np.float32(x)).removesuffix(".0") for x in value)
    return str(value).removesuffix(".0") if isinstance(value, float) else str(value)


def read_folder(folder: Path) -> list[Entry]:
    """List the pictures of any folder: by its manifest, or by the names of folders and files.

    Args:
        folder: Holds pictures (PNG, JPEG, BMP, TIFF, WebP, PPM), at or one below it.

    Raises:
        InputError: There is no such folder, no picture in it, or its manifest cannot be used.
    """
    folder = Path(folder)  # a notebook may give a word
    if not folder.is_dir():
        raise InputError(f"{folder} is no folder: give one that holds pictures")
    if (folder / MANIFEST).exists():
        entries = read_manifest(folder)
    else:
        files = sorted(file for pattern in ("*", "*/*") for file in folder.glob(pattern))
        entries = [
            Entry(
                file=file.relative_to(folder).as_posix(),
                identity_id=file.stem if file.parent == folder else file.parent.name,
            )
            for file in files
            if file.suffix.lower() in SUFFIXES
            and file.is_file()
            and not any(part.startswith(".") for part in file.relative_to(folder).parts)
        ]
    if not entries:
        kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
        raise InputError(f"{folder} holds no pictures: put files in it ({kinds})")
    return entries


def read_picture(folder: Path, entry: Entry) -> Picture:
    """Read one picture of a folder.

    Raises:
        InputError: The file cannot be read, or is no picture.
    """
    points = entry.landmarks_px
    return Picture(
        image=read_image(folder / entry.file),
        identity_id=entry.identity_id,
        landmarks_px=None if points is None else torch.tensor(points).reshape(5, 2),
        source=str(folder / entry.file),
        scale=entry.scale,
    )


def read_manifest(folder: Path, *, pictures: bool = True) -> list[Entry]:
    """Read and check ``folder/manifest.csv``, as any program may have saved it.

    Another order of columns, further ones and blank lines are fine; see :mod:`lrsr.tables`.

    Args:
        folder: Holds the manifest and, at or below it, the pictures.
        pictures: Insist that every picture is there.

    Raises:
        InputError: There is no such folder or manifest, a column is missing, a value does not
            fit, a picture is missing, lies outside the folder or is named twice; the message names
            file and line.
    """
    path = folder / MANIFEST
    entries: list[Entry] = []
    seen: set[PurePosixPath] = set()
    for line, values in read_rows(path, _REQUIRED, "lrsr render makes one"):
        entry = _entry(path, line, values, pictures)
        place = PurePosixPath(entry.file)
        if place in seen:
            raise InputError(f"{path}, line {line}: {place} is named twice")
        seen.add(place)
        entries.append(entry)
    return entries


def _entry(path: Path, line: int, values: Mapping[str, str], pictures: bool) -> Entry:
    given: dict[str, Any] = {}
    for name in _COLUMNS:
        text = values.get(name, "").strip()  # what is empty has its default
        try:
            given |= {name: _READERS.get(name, str)(text)} if text else {}
        except ValueError as error:
            raise InputError(f"{path}, line {line}: {name}={text[:80]}: {error}") from error
    for name in _REQUIRED:
        if name not in given:
            raise InputError(f"{path}, line {line}: {name} is empty; fill it in")
    further = {name: text for name, text in values.items() if name and name not in _COLUMNS}
    entry = Entry(**given, further=further)
    for name in filter(None, (entry.file, entry.linear_file)):
        if "\0" in name:
            raise InputError(f"{path}, line {line}: {name!r} is no name of a file; mend it")
        inside = (path.parent / name).resolve()
        if not inside.is_relative_to(path.parent.resolve()):
            raise InputError(f"{path}, line {line}: {name} lies outside {path.parent}")
        if pictures and not inside.is_file():
            raise InputError(f"{path}, line {line}: {name} does not exist; make it again")
    return entry


def _slashed(text: str) -> str:
    return text.replace("\\", "/")


def _points(text: str) -> tuple[float, ...]:
    points = tuple(_finite(x) for x in text.split())
    if len(points) != 10:
        raise ValueError(f"{len(points)} numbers, wanted 10")
    return points


def _scale(text: str) -> int:
    scale = _whole(text)
    if scale < 1:
        raise ValueError("wanted a number >= 1")
    return scale


def _frame(text: str) -> int:
    frame = _whole(text)
    if frame < 0:
        raise ValueError("wanted a number >= 0")
    return frame


def _whole(text: str) -> int:
    value = _finite(text)
    if value != int(value):
        raise ValueError("wanted a whole number")
    return int(text) if text.isdigit() else int(value)


def _finite(text: str) -> float:
    with suppress(ValueError):
        if math.isfinite(value := float(text)):
            return value
    raise ValueError(f"{text[:20]} is no number such as 8.5")


_READERS: Mapping[str, Callable[[str], object]] = {
    **dict.fromkeys(("file", "linear_file"), _slashed),
    **dict.fromkeys(("ipd_px", "yaw_deg", "pitch_deg", "roll_deg"), _finite),
    **dict.fromkeys(("seed", "samples_per_pixel", "run_seed"), _whole),
    "frame": _frame,
    "scale": _scale,
    "landmarks_px": _points,
}
"""How a column is read; those of others are text."""
