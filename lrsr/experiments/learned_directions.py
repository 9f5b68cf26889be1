"""Which directions of a generator's latent space turn, light and move its faces? Learned here.

Faces are drawn, measured or scored by somebody else, and parted by
:func:`lrsr.identities.generated.boundaries.learn_boundaries`.
"""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray
from tqdm import tqdm

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.identities.generated.attributes import ATTRIBUTES, AttributeMeter
from lrsr.identities.generated.boundaries import Boundaries, learn_boundaries
from lrsr.identities.generated.generator import Generator
from lrsr.identities.photographs.choices import PHOTOGRAPHS_VERSION
from lrsr.identities.photographs.picture_file import frame
from lrsr.journal import Journal
from lrsr.paths import user_path
from lrsr.pictures.image_files import write_png
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.portrait import portrait_faces
from lrsr.tables import read_rows

Pixels = NDArray[np.uint8]
Scores = dict[str, NDArray[np.float64]]

_SAMPLES = "samples"
_STREAM = 0
"""Second number of the seeds of these faces."""
DETECTED_PX = 640
"""Of a generated picture, for the detector: its face fills it."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Learning:
    """How boundaries are learned.

    Attributes:
        samples: Faces that are drawn and measured.
        share: Of them with the most of an attribute that is parted from as many with the least.
        scores: CSV with a column ``file`` and one for each attribute that is not measured here.
        keep: Write the samples' pictures.

    Raises:
        InputError: A value is out of its range.
    """

    samples: int = 2000
    share: float = 0.1
    scores: str | None = None
    keep: bool = False

    def __post_init__(self) -> None:
        require(self.samples >= 1, "learning.samples", self.samples, "at least 1")
        require(0 < self.share <= 0.5, "learning.share", self.share, "above 0, at most 0.5")

    def learn(
        self,
        generator: Generator,
        neutral: Mapping[str, float | None],
        drawn: Mapping[str, float],
        folder: Path,
        *,
        progress: bool = True,
    ) -> Boundaries:
        """Learn a boundary for each attribute; stopped at any moment, the same call goes on.

        Args:
            generator: Makes the faces.
            neutral: Which value of each attribute is neutral; None: the median one.
            drawn: ``seed`` and ``truncation`` of the faces.
            folder: Where measures and pictures are kept.
            progress: Show a bar.

        Raises:
            InputError: An attribute is not measured and has no scores, the file of scores cannot
                be used, or too few faces have a score that tells them apart.
        """
        theirs = self._read_scores(neutral)
        seeds = [(int(drawn["seed"]), _STREAM, k) for k in range(self.samples)]
        latents = generator.sample(seeds, drawn["truncation"])
        measured = neutral.keys() - theirs.keys()
        scores: Scores = {}
        if measured or self.keep:
            asked = {"generator": generator.describe(), **drawn, "version": PHOTOGRAPHS_VERSION}
            journal = Journal(folder / _SAMPLES / "measured.jsonl", asked)
            scores = self._measure(generator, latents, journal, progress=progress)
        record = {"generator": generator.describe(), **drawn, "samples": self.samples}
        return learn_boundaries(latents, scores | theirs, neutral, self.share, record)

    def _read_scores(self, neutral: Mapping[str, float | None]) -> Scores:
        """Return the scores of the user's file by attribute, NaN where there is none.

        Raises:
            InputError: It cannot be read, or somebody's attribute is in no column of it.
        """
        rows: list[dict[str, str]] = []
        if self.scores is not None:
            path = user_path(self.scores, "learning.scores")
            remedy = "learning.scores=CSV has the scores of faces"
            rows = [row for _, row in read_rows(path, ("file",), remedy)]
        columns = rows[0].keys() if rows else set()
        for name in neutral:
            known = name in columns or name in ATTRIBUTES
            wish = f"one of {', '.join(ATTRIBUTES)}, or a column of learning.scores"
            require(known, "attributes", name, wish)
        return {name: self._column(rows, name) for name in neutral if name in columns}

    def _column(self, rows: list[dict[str, str]], name: str) -> NDArray[np.float64]:
        scores = np.full(self.samples, np.nan)
        files = {f"{k:05d}.png": k for k in range(self.samples)}
        for row in rows:
            try:
                scores[files[row["file"]]] = float(row[name] or "nan")
            except KeyError as error:
                wish = f"00000.png to {self.samples - 1:05d}.png"
                raise InputError(f"learning.scores: file {row['file']}: wanted {wish}") from error
            except (ValueError, TypeError) as error:
                raise InputError(
                    f"learning.scores: {name}={row[name]!r} of {row['file']} is no number"
                ) from error
        return scores

    def _measure(
        self,
        generator: Generator,
        latents: NDArray[np.float32],
        journal: Journal,
        *,
        progress: bool,
    ) -> Scores:
        """Measure everybody's attributes, and keep the pictures if asked to; NaN: no face."""
        known = {told["sample"]: told["attributes"] for told in journal.read()}
        detector, meter = Detector(), AttributeMeter()
        nothing = dict.fromkeys(ATTRIBUTES, None)
        for k in tqdm(range(self.samples), desc="measuring", unit="face", disable=not progress):
            file = journal.path.with_name(f"{k:05d}.png")
            keeps = self.keep and not file.exists()
            if k in known and not keeps:
                continue
            pixels = generator.pictures(latents[k : k + 1])[0]
            if keeps:
                write_png(file, as_srgb(pixels)[0])
            if k not in known:
                faces = portrait_faces(pixels, detector, DETECTED_PX)
                known[k] = meter(frame(pixels, faces[0].landmarks_px)) if faces else nothing
                journal.note({"sample": k, "attributes": known[k]})
        found = [known[k] for k in range(self.samples)]
        return {
            name: np.array([one[name] for one in found], dtype=np.float64) for name in ATTRIBUTES
        }


def as_srgb(pixels: Pixels) -> torch.Tensor:
    """Return a picture ``(H, W, 3)`` as a batch of one: ``(1, 3, H, W)`` float32, [0, 1]."""
    planes = np.ascontiguousarray(pixels.transpose(2, 0, 1))
    return torch.from_numpy(planes.astype(np.float32) / np.float32(255))[None]
