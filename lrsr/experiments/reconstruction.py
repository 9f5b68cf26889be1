"""What does ``lrsr reconstruct`` do? Photographs become people, or are refused in one line each."""

import csv
import hashlib
import io
import json
import logging
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

from lrsr.configuration import as_word, flag, require, section
from lrsr.errors import InputError
from lrsr.experiments.report.reconstructed import draw_reconstruction
from lrsr.files import write_bytes, write_json, write_text
from lrsr.identities.photographs.choices import HAIRS, Hair, Kept
from lrsr.identities.photographs.person import FORMAT, RECORD, Network, Photographed
from lrsr.identities.photographs.picture_file import decode, frame
from lrsr.identities.photographs.quality import Filters, Quality
from lrsr.identities.photographs.reconstructor import shared_reconstructor
from lrsr.paths import path_if_any, user_path
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import SUFFIXES, read_file
from lrsr.pictures.maker import Maker
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.faces import Detection
from lrsr.rendering.scene import Quality as Rendering

if TYPE_CHECKING:
    from omegaconf import DictConfig

_SHEET = "sheet.png"
_ROWS = "rows"
_TABLE = "photographs.csv"
_LEAST_PX = 64
_DETECTED_PX = 1280
"""Larger pictures are reduced to this for the detector: a face that counts is not small on them."""
_ANOTHER_FACE = 0.15
"""A second face of more than this share of the first one's area makes it two."""
_ADULT_YEARS = 18.0

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Reconstructing:
    """Which photographs are reconstructed, and how.

    Attributes:
        images: A folder with all below it, or one picture.
        filters: Which photographs are taken.
        hair: "painted" or "none".
        neutral: The face at rest, not as photographed.
        ages: CSV with the columns ``file`` and ``age_years``; who is under 18, or missing there, is
            refused. None: you say that everybody is an adult.
        reconstructor: ONNX file of a calibrated network; None: the one that ships.

    Raises:
        InputError: A value is wrong, or the network cannot be used.
    """

    images: Path
    filters: Filters = field(default_factory=Filters)
    hair: Hair = "painted"
    neutral: bool = False
    ages: Path | None = None
    reconstructor: Path | None = None

    def __post_init__(self) -> None:
        require(self.hair in HAIRS, "hair", self.hair, f"one of {', '.join(HAIRS)}")
        _ = self.network

    @cached_property
    def network(self) -> Network | None:
        """The network that finds faces; None: the one that ships.

        Raises:
            InputError: It cannot be used.
        """
        if self.reconstructor is None:
            return None
        digest = shared_reconstructor(self.reconstructor).digest
        return Network(str(self.reconstructor), digest)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read a composed configuration of ``lrsr reconstruct``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return cls(
            images=user_path(config.images, "images"),
            filters=section(Filters, config, "filters"),
            hair=as_word(config.hair, "hair"),  # type: ignore[arg-type]  # checked above
            neutral=flag(config, "neutral"),
            ages=path_if_any(config.ages, "ages"),
            reconstructor=path_if_any(config.reconstructor, "reconstructor"),
        )

    def run(
        self, folder: Path, cache: RenderCache, *, maker: Maker | None = None, progress: bool = True
    ) -> Path:
        """Reconstruct what is not yet; write ``people.json``, the sheet and the table.

        Stopped at any moment, the same call goes on.

        Args:
            folder: Where they go.
            cache: Where renderings are kept.
            maker: Renders; Mitsuba when None.
            progress: Show a bar.

        Raises:
            InputError: There are no pictures.
        """
        sources, ages = self._sources(), self._ages()
        work = _Work(self, folder, Detector(), cache, maker)
        known = work.read_known()
        looked: list[dict[str, Any]] = []
        for source in tqdm(sources, desc="reconstructing", unit="picture", disable=not progress):
            told = self._look(source, work, known, ages, [one["sha256"] for one in looked])
            looked.append(told)
            if told["sha256"] not in known:
                work.keep(told)
                known[told["sha256"]] = told
            if told["why"]:
                logger.info("%s refused: %s", source, told["why"])
        taken = [one for one in looked if not one["why"]]
        refused = Counter(one["filter"] for one in looked if one["why"])
        work.write(looked)
        counts = "".join(f", {which} {count}" for which, count in sorted(refused.items()))
        logger.info(
            "%d photographs: %d reconstructed, %d refused%s",
            len(looked), len(taken), len(looked) - len(taken), counts,
        )  # fmt: skip
        return folder

    @property
    def kept(self) -> Kept:
        """Whose expression people have."""
        return "neutral" if self.neutral else "photograph"

    def describe(self) -> dict[str, Any]:
        """Return what decides about a photograph besides its bytes and ages, in plain values."""
        return {
            "filters": asdict(self.filters),
            "hair": self.hair,
            "neutral": self.neutral,
            "reconstructor": self.network and self.network.sha256,
        }

    def _sources(self) -> list[Path]:
        """Return the pictures.

        Raises:
            InputError: There are none.
        """
        if self.images.is_file():
            return [self.images]
        found = [
            file
            for file in sorted(self.images.rglob("*"))
            if file.is_file()
            and file.suffix.lower() in SUFFIXES
            and not any(part.startswith(".") for part in file.relative_to(self.images).parts)
        ]
        kinds = ", ".join(suffix[1:] for suffix in SUFFIXES)
        wish = f"a folder with pictures in it ({kinds})"
        require(bool(found), "images", self.images, wish)
        return found

    def _ages(self) -> Mapping[str, str] | None:
        """Return the ages of who is on each file.

        Raises:
            InputError: The file cannot be read, or lacks a column.
        """
        if self.ages is None:
            logger.warning("ages=null: everybody is an adult on your word")
            return None
        try:
            rows = list(csv.DictReader(io.StringIO(self.ages.read_text(encoding="utf-8-sig"))))
        except (OSError, UnicodeDecodeError, csv.Error) as error:
            raise InputError(f"ages={self.ages} cannot be read ({error}): give a CSV file") from (
                error
            )
        for column in ("file", "age_years"):
            missing = not rows or column not in rows[0]
            require(not missing, "ages", self.ages, f"a CSV file with a column {column}")
        return {row["file"]: row["age_years"] or "" for row in rows}

    def _look(
        self,
        source: Path,
        work: "_Work",
        known: Mapping[str, dict[str, Any]],
        ages: Mapping[str, str] | None,
        before: list[str],
    ) -> dict[str, Any]:
        """Return what became of one picture: the record of it, with ``why`` if it was refused."""
        told: dict[str, Any] = {"file": str(source), "sha256": "", "filter": "", "why": ""}
        try:
            content = read_file(source)
            told["sha256"] = digest = hashlib.sha256(content).hexdigest()
            if digest in before:
                return told | {"filter": "twice", "why": "the same picture as one before"}
            root = self.images if self.images.is_dir() else self.images.parent
            if ages is not None and (why := _too_young(ages, source.relative_to(root).as_posix())):
                return told | {"filter": "adult", "why": why}
            if digest in known:
                return {**known[digest], "file": str(source)}
            return told | work.reconstruct(content, source, digest)
        except InputError as error:
            return told | {"filter": "picture", "why": str(error)}


@dataclass(frozen=True)
class _Work:
    """What is needed for each picture, and where its traces go."""

    asked: Reconstructing
    folder: Path
    detector: Detector
    cache: RenderCache
    maker: Maker | None

    def reconstruct(self, content: bytes, source: Path, digest: str) -> dict[str, Any]:
        """Reconstruct one picture; return what is to be told of it.

        Raises:
            InputError: It is no picture, or no face of it is measured.
        """
        pixels = decode(content, str(source))
        height, width = pixels.shape[:2]
        if min(height, width) < _LEAST_PX:
            why = f"{width} x {height} px, at least {_LEAST_PX} px are needed"
            return _refused("size", why)
        faces = _find_faces(pixels, self.detector)
        if not faces:
            return _refused("face", "no face found")
        if len(faces) > 1:
            return _refused("face", f"{len(faces)} faces: cut out the one that is meant")
        five = faces[0].landmarks_px.astype(np.float64)
        ipd_px, least = float(np.linalg.norm(five[1] - five[0])), self.asked.filters.least_ipd_px
        if least is not None and ipd_px < least:
            why = f"{ipd_px:.0f} px between the eyes; filters.least_ipd_px is {least:g}"
            return _refused("size", why)
        places = tuple((round(float(x), 3), round(float(y), 3)) for x, y in five)
        hair, kept, network = self.asked.hair, self.asked.kept, self.asked.network
        somebody = Photographed(str(source), digest, places, hair, kept, network)
        made = somebody.reconstruction(Rendering().texture_size)
        person = {
            "five_px": [list(place) for place in places],
            "hair": hair,
            "expression": kept,
            "reconstructor": network and network._asdict(),
            "quality": asdict(made.quality),
        }
        refusal = self.asked.filters.refusal(made.quality)
        if refusal is not None:
            return person | _refused(*refusal)
        srgb = frame(pixels, five).srgb
        row = draw_reconstruction(somebody, srgb, made, self.cache, maker=self.maker)
        write_bytes(self._row(digest), row, durable=False)
        return person

    def _row(self, digest: str) -> Path:
        return self.folder / _ROWS / f"{digest[:12]}.png"

    def _state(self) -> Path:
        return self.folder / _ROWS / "looked.jsonl"

    def read_known(self) -> dict[str, dict[str, Any]]:
        """Return what earlier calls with the same settings found, by the picture's checksum."""
        known: dict[str, dict[str, Any]] = {}
        path, asked = self._state(), self.asked.describe()
        lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
        for line in lines:
            try:
                row = json.loads(line)
                same, told = row["asked"] == asked, row["told"]
                drawn = told["why"] or self._row(told["sha256"]).is_file()
            except (ValueError, KeyError, TypeError):  # a line that a kill cut short
                continue
            if same and drawn:
                known[told["sha256"]] = told
        return known

    def keep(self, told: Mapping[str, Any]) -> None:
        """Note what became of one picture, unless its age or its file alone decided."""
        if told["filter"] in ("adult", "twice", "picture"):
            return
        self._state().parent.mkdir(parents=True, exist_ok=True)
        with self._state().open("a", encoding="utf-8") as file:
            file.write(f"\n{json.dumps({'asked': self.asked.describe(), 'told': told})}")

    def write(self, looked: list[dict[str, Any]]) -> None:
        """Write who can be made, what became of every picture, and the contact sheet."""
        people = [one for one in looked if not one["why"]]
        table = io.StringIO()
        measures = list(Quality.__dataclass_fields__)
        writer = csv.writer(table, lineterminator="\n")
        writer.writerow(["file", "sha256", "taken", "filter", "why", *measures])
        for one in looked:
            found = one.get("quality", {})
            said = [one["file"], one["sha256"], "no" if one["why"] else "yes"]
            writer.writerow(
                [*said, one["filter"], one["why"], *(found.get(m, "") for m in measures)]
            )
        write_text(self.folder / _TABLE, table.getvalue())
        rows = [cv2.imread(str(self._row(one["sha256"]))) for one in people]
        if rows:
            _, sheet = cv2.imencode(".png", np.concatenate(rows, axis=0))
            write_bytes(self.folder / _SHEET, sheet.tobytes(), durable=False)
        refused = [
            {key: one[key] for key in ("file", "filter", "why")} for one in looked if one["why"]
        ]
        kept = [{k: v for k, v in one.items() if k not in ("filter", "why")} for one in people]
        content = {"format": FORMAT, "people": kept, "refused": refused}
        write_json(self.folder / RECORD, content)


def _find_faces(pixels: NDArray[Any], detector: Detector) -> list[Detection]:
    """Return the faces of a picture that count, the largest first, in its own px.

    Args:
        pixels: ``(H, W, 3)`` of 8 or 16 bits.
        detector: Finds them; large pictures are reduced for it.
    """
    height, width = pixels.shape[:2]
    factor = min(1.0, _DETECTED_PX / max(height, width))
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    small = cv2.resize(pixels, size, interpolation=cv2.INTER_AREA) if factor < 1 else pixels
    srgb = small.astype(np.float32) / np.float32(np.iinfo(pixels.dtype).max)
    batch = torch.from_numpy(np.ascontiguousarray(srgb.transpose(2, 0, 1)))[None]

    def area(face: Detection) -> float:
        left, top, right, bottom = face.box_px
        return float((right - left) * (bottom - top))

    faces = sorted(detector(batch)[0], key=area, reverse=True)
    back = np.array([width / size[0], height / size[1]], np.float32)
    return [
        Detection(
            ((face.box_px.reshape(2, 2) + 0.5) * back - 0.5).ravel(),
            face.score,
            (face.landmarks_px + 0.5) * back - 0.5,
        )
        for face in faces
        if area(face) > _ANOTHER_FACE * area(faces[0])
    ]


def _too_young(ages: Mapping[str, str], file: str) -> str:
    """Return why the age of who is on a file refuses it; empty: it does not."""
    if file not in ages:
        return "no age known: add a row to ages"
    try:
        years = float(ages[file])
    except ValueError:
        return f"age_years={ages[file]!r} is no number"
    return "" if years >= _ADULT_YEARS else f"{years:g} years old: only adults are taken"


def _refused(which: str, why: str) -> dict[str, str]:
    return {"filter": which, "why": why}
