"""Which pictures are in this folder, and what is known of each? One CSV row a picture."""

import csv
import io
import math
from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

from lrsr.errors import InputError
from lrsr.files import write_text
from lrsr.identities.person import Person

MANIFEST = "manifest.csv"


@dataclass(frozen=True)
class ManifestRow:
    """One picture; the fields are the columns.

    Attributes:
        file: Path relative to the manifest's folder, with forward slashes.
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
        sex: "female" or "male"; this and what follows is empty where it is not known.
        age_years: As drawn.
        ancestry: Share of each, e.g. "african=0.02 asian=0.9 caucasian=0.08".
        ita_deg: Individual typology angle of the bare cheeks' albedo; see
            :mod:`lrsr.identities.person`.
        skin_tone: Its class, "very light" to "dark".
        expression: Name.
        lens: Name.
        standpoint: Name.
    """

    file: str
    identity_id: str
    kind: str
    pose: str
    lighting: str
    compression: str
    camera: str
    ipd_px: float
    scale: int
    seed: int
    landmarks_px: tuple[float, ...]
    linear_file: str = ""
    sex: str = ""
    age_years: str = ""
    ancestry: str = ""
    ita_deg: str = ""
    skin_tone: str = ""
    expression: str = "neutral"
    lens: str = "pinhole"
    standpoint: str = "level"


COLUMNS = tuple(field.name for field in fields(ManifestRow))
REQUIRED = COLUMNS[: COLUMNS.index("linear_file")]


def about(person: Person | None) -> dict[str, str]:
    """Return the columns that tell who a picture shows; none where that is not known."""
    if person is None:
        return {}
    return {
        "sex": person.sex,
        "age_years": f"{person.age_years:g}",
        "ancestry": " ".join(f"{race}={share:g}" for race, share in person.ancestry.items()),
        "ita_deg": f"{person.ita_deg:g}",
        "skin_tone": person.skin_tone,
    }


def write_manifest(folder: Path, rows: Iterable[ManifestRow]) -> Path:
    """Write ``manifest.csv`` into ``folder``, whole or not at all; return its path.

    Raises:
        InputError: The folder cannot be written or the disk is full.
    """
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for row in rows:
        points = " ".join(f"{x:.4f}" for x in row.landmarks_px)
        values = {name: getattr(row, name) for name in COLUMNS}
        writer.writerow({**values, "ipd_px": f"{row.ipd_px:g}", "landmarks_px": points}.values())
    path = folder / MANIFEST
    write_text(path, text.getvalue())
    return path


def read_manifest(folder: Path, *, pictures: bool = True) -> list[ManifestRow]:
    """Read and check ``folder/manifest.csv``; columns that are not ours are let be.

    Args:
        folder: Holds the manifest and, at or below it, the pictures.
        pictures: Insist that every picture is there.

    Raises:
        InputError: There is no such folder or manifest, a column is missing, a value does not
            fit, a picture is missing or lies outside the folder; the message names file and line.
    """
    path = folder / MANIFEST
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or error
        raise InputError(f"cannot read {path}: {reason}; lrsr render makes one") from error
    reader = csv.DictReader(lines, strict=True)
    try:
        missing = [name for name in REQUIRED if name not in (reader.fieldnames or ())]
        if missing:
            names = ", ".join(missing)
            raise InputError(f"{path}, line 1: no column {names}; lrsr render writes them")
        return [_row(path, reader.line_num, values, pictures) for values in reader]
    except csv.Error as error:
        line = reader.line_num + 1  # the one after the last that could be read
        raise InputError(f"{path}, line {line}: {error}; make it again") from error


def _row(path: Path, line: int, values: dict[str, str | None], pictures: bool) -> ManifestRow:
    texts = {name: values.get(name) or "" for name in COLUMNS}
    try:
        row = ManifestRow(
            **{
                **texts,
                "ipd_px": _finite(texts["ipd_px"]),
                "scale": int(texts["scale"]),
                "seed": int(texts["seed"]),
                "landmarks_px": tuple(_finite(x) for x in texts["landmarks_px"].split()),
                "expression": texts["expression"] or "neutral",
                "lens": texts["lens"] or "pinhole",
                "standpoint": texts["standpoint"] or "level",
            }  # type: ignore[arg-type]  # the keys are the fields, converted where not text
        )
    except ValueError as error:
        raise InputError(f"{path}, line {line}: {error}") from error
    if len(row.landmarks_px) != 10:
        raise InputError(
            f"{path}, line {line}: landmarks_px holds {len(row.landmarks_px)} numbers, wanted 10"
        )
    if not row.file:
        raise InputError(f"{path}, line {line}: no file is named; make it again")
    for name in filter(None, (row.file, row.linear_file)):
        inside = (path.parent / name).resolve()
        if not inside.is_relative_to(path.parent.resolve()):
            raise InputError(f"{path}, line {line}: {name} lies outside {path.parent}")
        if pictures and not inside.is_file():
            raise InputError(f"{path}, line {line}: {name} does not exist; make it again")
    return row


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text} is not a finite number")
    return value
