"""Whom of those that a generator draws are taken? Made neutral, past the filters, unlike all.

What becomes of somebody depends on those drawn before, not on how many follow or how often the work
was interrupted.
"""

import hashlib
import math
from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from tqdm import tqdm

from lrsr.errors import InputError
from lrsr.evaluation.distinctness import nearest
from lrsr.experiments.learned_directions import DETECTED_PX, Pixels, as_srgb
from lrsr.experiments.report.sheets import draw_contact_sheet
from lrsr.files import write_bytes, write_json
from lrsr.identities.generated.attributes import AttributeMeter
from lrsr.identities.generated.boundaries import Boundaries
from lrsr.identities.generated.generator import Generator
from lrsr.identities.photographs.choices import PHOTOGRAPHS_VERSION
from lrsr.identities.photographs.picture_file import frame
from lrsr.identities.photographs.quality import Filters
from lrsr.identities.photographs.reconstruct import reconstruct
from lrsr.journal import Journal
from lrsr.pictures.folder import Entry, write_manifest
from lrsr.pictures.image_files import read_image, write_png
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.portrait import portrait_faces
from lrsr.recognition.recognisers import Recogniser

Told = dict[str, Any]
Change = tuple[str, float]
"""An attribute, and its increment; "" and 0: none."""

_RECORD, _SHEET, _FOUND = "generated.json", "sheet.png", "people.jsonl"
_NEUTRAL: Change = ("", 0.0)
_PREFIX = "generated-"
_STREAM = 1
"""Second number of the seeds of people."""
_TEXELS = 128
"""Of the texture that filters measure."""
_SHOWN = 24
"""People on the sheet."""


@dataclass(frozen=True, eq=False)
class GeneratedPeople:
    """People, their pictures, and why others were refused.

    Attributes:
        folder: Where they go.
        generator: Makes the pictures.
        boundaries: Of its latent space.
        encoder: Says who is alike.
        seed: Of all that is drawn.
        truncation: See :meth:`lrsr.identities.generated.generator.Generator.sample`.
        variations: Increments of some attributes, from neutral.
        smallest_angle_deg: Who is nearer to somebody taken before is refused.
        filters: Who is refused besides.
        looked: What became of everybody so far.

    Raises:
        InputError: A variation is of no attribute that has a boundary.
    """

    folder: Path
    generator: Generator
    boundaries: Boundaries
    encoder: Recogniser
    seed: int
    truncation: float
    variations: Mapping[str, tuple[float, ...]]
    smallest_angle_deg: float
    filters: Filters
    looked: list[Told] = field(default_factory=list)

    def __post_init__(self) -> None:
        for name in self.variations:
            if name not in (names := self.boundaries.names):
                raise InputError(f"variations.{name}: wanted one of {', '.join(names)}")

    @property
    def taken(self) -> list[Told]:
        """Who was taken, in order."""
        return [told for told in self.looked if not told["why"]]

    @property
    def refused_in_a_row(self) -> int:
        """How many of the last ones were refused."""
        return next(
            (k for k, told in enumerate(self.looked[::-1]) if not told["why"]), len(self.looked)
        )

    def refusals(self) -> dict[str, int]:
        """Return how many each filter refused."""
        return dict(sorted(Counter(told["filter"] for told in self.looked if told["why"]).items()))

    def describe(self) -> Told:
        """Return all that decides who is taken and how they are pictured, in plain values."""
        planes = self.boundaries
        arrays = (planes.normals, planes.offsets, planes.neutral, planes.spread)
        return {
            "generator": self.generator.describe(),
            "boundaries": hashlib.sha256(b"".join(one.tobytes() for one in arrays)).hexdigest(),
            "encoder": dict(self.encoder.describe()),
            "seed": self.seed,
            "truncation": self.truncation,
            "variations": {name: list(steps) for name, steps in self.variations.items()},
            "smallest_angle_deg": self.smallest_angle_deg,
            "filters": asdict(self.filters),
            "version": PHOTOGRAPHS_VERSION,
        }

    def find(self, count: int, most_refused: int, *, progress: bool = True) -> None:
        """Draw until so many are taken, or so many in a row were refused; what is known is kept.

        Raises:
            InputError: The folder holds people of other settings, or cannot be written.
        """
        journal = Journal(self.folder / _FOUND, self.describe())
        self.looked.extend(journal.read())
        for told in self.taken:
            self._photograph(told)
        taken = len(self.taken)
        with tqdm(
            total=count, initial=taken, desc="taken", unit="person", disable=not progress
        ) as bar:
            while taken < count and self.refused_in_a_row < most_refused:
                told = self._look(len(self.looked))
                if not told["why"]:
                    self._photograph(told)
                    taken += 1
                    bar.update()
                self.looked.append(told)
                journal.note(told)

    def _look(self, number: int) -> Told:
        """Return what becomes of one who is drawn."""
        told: Told = {
            "identity_id": f"{_PREFIX}{self.seed}-{number:05d}",
            "latent_seed": [self.seed, _STREAM, number],
            "filter": "",
            "why": "",
        }
        pixels = self._picture(told, _NEUTRAL)
        faces = portrait_faces(pixels, self._detector, DETECTED_PX)
        if len(faces) != 1:
            return told | _refused("face", f"{len(faces)} faces")
        photograph = frame(pixels, faces[0].landmarks_px)
        try:
            made = reconstruct(photograph, texture_size=_TEXELS, hair="none")
        except InputError as error:
            return told | _refused("fit", str(error))
        told["quality"] = asdict(made.quality)
        if (refusal := self.filters.refusal(made.quality)) is not None:
            return told | _refused(*refusal)
        points, boxes = faces[0].landmarks_px[None], faces[0].box_px[None]
        row = self.encoder.embed(as_srgb(pixels), points, boxes)[0].astype(np.float64)
        if not np.isfinite(row).all():
            return told | _refused("face", "the encoder finds none")
        row /= np.linalg.norm(row)
        others = self.taken
        whom, angle = nearest(row, np.array([other["embedding"] for other in others]))
        if others:
            told |= {"nearest": others[whom]["identity_id"], "angle_deg": angle}
        if angle < (least := self.smallest_angle_deg):
            why = f"{angle:.1f} degrees from {told['nearest']}; smallest_angle_deg is {least:g}"
            return told | _refused("alike", why)
        return told | {"attributes": self._meter(photograph), "embedding": row.tolist()}

    def _picture(self, told: Told, change: Change | None) -> Pixels:
        """Return somebody's picture ``(H, W, 3)``, changed from neutral; None: as drawn."""
        latent = self.generator.sample([tuple(told["latent_seed"])], self.truncation)
        if change is not None:
            latent = self.boundaries.moved(latent, dict([change]) if change[0] else None)
        picture: Pixels = self.generator.pictures(latent)[0]
        return picture

    def _photograph(self, told: Told) -> None:
        """Write the pictures of somebody that are not there."""
        for change in self._changes():
            file = self.folder / _file(told, change)
            if not file.exists():
                write_png(file, as_srgb(self._picture(told, change))[0])

    def _changes(self) -> list[Change]:
        varied = self.variations.items()
        return [_NEUTRAL, *((name, step) for name, steps in varied for step in steps)]

    def write(self) -> None:
        """Write who is on which picture, the record, and the sheet."""
        taken = self.taken
        write_manifest(
            self.folder,
            [
                Entry(
                    file=_file(told, change),
                    identity_id=told["identity_id"],
                    kind="gallery" if change == _NEUTRAL else "probe",
                    further={"attribute": change[0], "increment": f"{change[1]:g}"},
                )
                for told in taken
                for change in self._changes()
            ],
        )
        hidden = ("filter", "why", "embedding")
        record = {
            "settings": self.describe(),
            "learned": self.boundaries.record,
            "drawn": len(self.looked),
            "refused": self.refusals(),
            "people": [{k: v for k, v in told.items() if k not in hidden} for told in taken],
        }
        write_json(self.folder / _RECORD, _without_nan(record))
        if taken:
            write_bytes(self.folder / _SHEET, self._sheet(taken[:_SHOWN]), durable=False)

    def _sheet(self, shown: list[Told]) -> bytes:
        drawn = [as_srgb(self._picture(told, None)) for told in shown]
        columns = {"as drawn": torch.cat(drawn)}
        for change in self._changes():
            heading = f"{change[0]}\n{change[1]:+g}" if change[0] else "neutral"
            pictures = [read_image(self.folder / _file(told, change)) for told in shown]
            columns[heading] = torch.stack(pictures)
        names = [told["identity_id"].removeprefix(_PREFIX) for told in shown]  # as fit beside tiles
        return draw_contact_sheet(columns, names)

    @cached_property
    def _detector(self) -> Detector:
        return Detector()

    @cached_property
    def _meter(self) -> AttributeMeter:
        return AttributeMeter()


def _file(told: Told, change: Change) -> str:
    """Return where a picture lies in the folder."""
    name, step = change
    who = told["identity_id"]
    return f"varied/{who}_{name}_{step:+g}.png" if name else f"neutral/{who}.png"


def _refused(which: str, why: str) -> dict[str, str]:
    return {"filter": which, "why": why}


def _without_nan(value: Any) -> Any:
    """Return plain values with null for NaN, which JSON does not know."""
    if isinstance(value, Mapping):
        return {name: _without_nan(one) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_without_nan(one) for one in value]
    return None if isinstance(value, float) and math.isnan(value) else value
