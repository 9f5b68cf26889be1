"""Which photographs become people? Each is looked at once: taken, or refused in one line."""

import csv
import hashlib
import io
import json
import logging
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from tqdm import tqdm

from lrsr.configuration import as_word, flag, require, section
from lrsr.errors import InputError
from lrsr.files import read_bytes, write_json, write_text
from lrsr.identities.photographs.choices import HAIRS, PHOTOGRAPHS_VERSION, Hair, Kept
from lrsr.identities.photographs.person import FORMAT, RECORD, Network, Photographed
from lrsr.identities.photographs.picture_file import decode
from lrsr.identities.photographs.quality import Filters, Quality
from lrsr.identities.photographs.reconstructor import shared_reconstructor
from lrsr.paths import path_if_any
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.image_files import read_file
from lrsr.pictures.recipe import digest
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.portrait import portrait_faces
from lrsr.rendering.scene import Quality as Rendering

if TYPE_CHECKING:
    from omegaconf import DictConfig

_TABLE = "photographs.csv"
_LEAST_PX = 64

Told = dict[str, Any]
"""What became of one photograph: file, who is on it, sha256, filter and why, which are empty where
it was taken, and what was measured, where it came to that."""

logger = logging.getLogger(__name__)


@dataclass(frozen=True)
class Intake:
    """How photographs become people, and which are taken.

    Attributes:
        filters: Which photographs are taken.
        hair: "painted" or "none".
        neutral: The face at rest, not as photographed.
        reconstructor: ONNX file of a calibrated network; None: the one that ships.

    Raises:
        InputError: A value is wrong, or the network cannot be used.
    """

    filters: Filters = field(default_factory=Filters)
    hair: Hair = "painted"
    neutral: bool = False
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
        return Network(str(self.reconstructor), shared_reconstructor(self.reconstructor).digest)

    @classmethod
    def from_config(cls, config: "DictConfig") -> Self:
        """Read what has the keys of ``conf/reconstruction``.

        Raises:
            InputError: A value is wrong; the message names the setting and the remedy.
        """
        return cls(
            filters=section(Filters, config, "filters"),
            hair=as_word(config.hair, "hair"),  # type: ignore[arg-type]  # checked above
            neutral=flag(config, "neutral"),
            reconstructor=path_if_any(config.reconstructor, "reconstructor"),
        )

    def describe(self) -> dict[str, Any]:
        """Return what decides about a photograph besides its bytes, in plain values."""
        network = self.network and self.network.sha256
        return {**asdict(self), "reconstructor": network}

    def look(
        self,
        sources: Mapping[Path, str],
        cache: RenderCache,
        *,
        refused: Mapping[Path, str] | None = None,
        progress: bool = True,
    ) -> Iterator[Told]:
        """Yield what became of each photograph; what is known from earlier is not found again.

        Args:
            sources: Absolute paths, and who is on each.
            cache: Where that is kept, beside renderings.
            refused: Who is too young, and why; those are not looked at.
            progress: Show a bar.

        Raises:
            InputError: The cache cannot be written.
        """
        before: dict[str, Path] = {}
        memory = cache.folder / "photographs"
        bar = tqdm(sources.items(), desc="looking", unit="photo", disable=not progress)
        for source, who in bar:
            told: Told = {"file": str(source), "who": who, "sha256": "", "filter": "", "why": ""}
            try:
                content = read_file(source)
                told["sha256"] = sha256 = hashlib.sha256(content).hexdigest()
                if sha256 in before:
                    told |= _refused("twice", f"the same picture as {before[sha256]}")
                elif refused and source in refused:
                    told |= _refused("adult", refused[source])
                else:
                    told |= self._known(memory, sha256, content, source)
                before.setdefault(sha256, source)
            except InputError as error:
                told |= _refused("picture", str(error))
            if told["why"]:
                logger.info("%s refused: %s", source, told["why"])
            yield told

    def _known(self, memory: Path, sha256: str, content: bytes, source: Path) -> Told:
        """Return what was found on a photograph before, or now.

        Raises:
            InputError: It is no picture, or no face of it is measured.
        """
        asked = digest({**self.describe(), "version": PHOTOGRAPHS_VERSION})
        path = memory / sha256[:2] / f"{sha256}_{asked[:16]}.json"
        with suppress(OSError, ValueError):
            return _plain(read_bytes(path))
        found = self._reconstruct(content, source, sha256)
        write_json(path, found)
        return _plain(json.dumps(found))  # as it will be remembered

    def _reconstruct(self, content: bytes, source: Path, sha256: str) -> Told:
        """Reconstruct one photograph; return what is to be told of it.

        Raises:
            InputError: It is no picture, or no face of it is measured.
        """
        pixels = decode(content, str(source))
        height, width = pixels.shape[:2]
        if min(height, width) < _LEAST_PX:
            why = f"{width} x {height} px, at least {_LEAST_PX} px are needed"
            return _refused("size", why)
        faces = portrait_faces(pixels, self._detector)
        if not faces:
            return _refused("face", "no face found")
        if len(faces) > 1:
            return _refused("face", f"{len(faces)} faces: cut out the one that is meant")
        five = faces[0].landmarks_px.astype(np.float64)
        ipd_px, least = float(np.linalg.norm(five[1] - five[0])), self.filters.least_ipd_px
        if least is not None and ipd_px < least:
            why = f"{ipd_px:.0f} px between the eyes; filters.least_ipd_px is {least:g}"
            return _refused("size", why)
        places = tuple((round(float(x), 3), round(float(y), 3)) for x, y in five)
        kept: Kept = "neutral" if self.neutral else "photograph"
        network = self.network
        somebody = Photographed(str(source), sha256, places, self.hair, kept, reconstructor=network)
        made = somebody.reconstruction(Rendering().texture_size)
        person = {
            "five_px": [list(place) for place in places],
            "hair": self.hair,
            "expression": kept,
            "reconstructor": network and network._asdict(),
            "quality": asdict(made.quality),
        }
        refusal = self.filters.refusal(made.quality)
        return person | _refused(*refusal) if refusal else person

    @cached_property
    def _detector(self) -> Detector:
        return Detector()


def counted(looked: Sequence[Told]) -> str:
    """Return how many photographs were taken, and what refused the others.

    Example:
        >>> counted([{"filter": "", "why": ""}, {"filter": "face", "why": "no face found"}])
        '2 photographs: 1 reconstructed, 1 refused, face 1'
    """
    refused = Counter(one["filter"] for one in looked if one["why"])
    count, total = len(looked), refused.total()
    which = "".join(f", {name} {number}" for name, number in sorted(refused.items()))
    return f"{count} photographs: {count - total} reconstructed, {total} refused{which}"


def write_people(folder: Path, looked: Sequence[Told]) -> None:
    """Write who can be made, ``people.json``, and what became of every photograph.

    Raises:
        InputError: The folder cannot be written.
    """
    table, measures = io.StringIO(), list(Quality.__dataclass_fields__)
    writer = csv.writer(table, lineterminator="\n")
    writer.writerow(["file", "who", "sha256", "taken", "filter", "why", *measures])
    for one in looked:
        found = one.get("quality", {})
        said = [one[name] for name in ("file", "who", "sha256")]
        said += ["no" if one["why"] else "yes", one["filter"], one["why"]]
        writer.writerow([*said, *(found.get(measure, "") for measure in measures)])
    write_text(folder / _TABLE, table.getvalue())
    refused = [{key: one[key] for key in ("file", "filter", "why")} for one in looked if one["why"]]
    people = [
        {k: v for k, v in one.items() if k not in ("filter", "why")}
        for one in looked
        if not one["why"]
    ]
    write_json(folder / RECORD, {"format": FORMAT, "people": people, "refused": refused})


def _plain(text: str | bytes) -> Told:
    found: Told = json.loads(text)
    return found


def _refused(which: str, why: str) -> dict[str, str]:
    return {"filter": which, "why": why}
