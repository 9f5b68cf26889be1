"""How alike does each recogniser find pictures, after each way of enlarging? Scores, no verdict."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol, cast

import numpy as np
from tqdm import tqdm

from lrsr.errors import InputError
from lrsr.evaluation.score_files.system import Name, System
from lrsr.experiments.seen import Seen
from lrsr.experiments.several import Several
from lrsr.experiments.table import Record
from lrsr.pictures.picture import Picture
from lrsr.recognition.finder import Finder
from lrsr.recognition.recognisers import Recogniser
from lrsr.recognition.settings import Landmarks
from lrsr.sr.upscaler import Bicubic, Upscaler

_AT_ONCE = 4
"""Pictures in memory: of 384 px, enlarged four times by a network of 64 channels, 2.4 GB."""


class Pictures(Protocol):
    """Pictures in an order that does not change, as of :mod:`lrsr.pictures.source`."""

    @property
    def identity_ids(self) -> Sequence[str]:
        """Who each picture shows."""

    @property
    def names(self) -> Sequence[str]:
        """What each picture is called."""

    def load(self, start: int, stop: int) -> list[Picture]:
        """Return the pictures ``start`` to ``stop - 1``."""


@dataclass(frozen=True)
class Comparison:
    """All probes against the whole gallery, by one recogniser after one method.

    Attributes:
        name: Of the system, as files of scores have it.
        label: Of the method.
        system: The scores.
        seen: What was made of the probes.
        enrolled: What was made of the gallery.
    """

    name: Name
    label: str
    system: System
    seen: Seen
    enrolled: Seen

    @property
    def failures(self) -> tuple[list[str], list[str]]:
        """The probes and the enrolled pictures that were not acquired."""
        sides = (self.seen, self.system.probes), (self.enrolled, self.system.gallery)
        lost, unenrolled = (
            [
                names[k]
                for k in np.flatnonzero(np.isnan(one.joined(self.landmarks)).any(axis=1)).tolist()
            ]
            for one, names in sides
        )
        return lost, unenrolled

    @property
    def landmarks(self) -> Landmarks:
        """Their source."""
        return cast("Landmarks", self.name.landmarks)

    @property
    def about(self) -> Record:
        """What names it in a record."""
        name = self.name
        return {
            "recogniser": name.recogniser,
            "option": int(name.option) if name.option else None,
            "ipd_px": float(name.ipd_px) if name.ipd_px else None,
            "landmarks": name.landmarks,
            "method": name.method,
            "label": self.label,
        }


@dataclass(frozen=True)
class Comparer:
    """Compares pictures by every recogniser after every method.

    Attributes:
        methods: Enlarge probes, by name; enrolled pictures stay as they are.
        engines: Recognise, by name.
        landmarks: Of which sources.
        finder: Finds faces; None where landmarks are the true ones.
        progress: Show bars.
    """

    methods: Mapping[str, Upscaler | Several]
    engines: Mapping[str, Recogniser]
    landmarks: Sequence[Landmarks]
    finder: Finder | None = None
    progress: bool = True

    def compare(
        self, probes: Pictures, gallery: Pictures, *, option: str = "1", ipd_px: float | None = None
    ) -> list[Comparison]:
        """Return the scores of every recogniser, source of landmarks and method.

        Args:
            probes: To be recognised.
            gallery: What they are compared with.
            option: What files of scores call the condition.
            ipd_px: Of the probes, where all are alike.
        """
        as_it_is = {"base": Bicubic(1)}
        enrolled = self._look(gallery, as_it_is, "gallery")
        seen = self._look(probes, self.methods, "probes")
        size = "" if ipd_px is None else f"{ipd_px:g}"
        ids = tuple(probes.identity_ids), tuple(gallery.identity_ids)
        return [
            Comparison(
                Name(option, size, method, source, recogniser),
                upscaler.label,
                System(
                    engine.compare(
                        seen[recogniser, method].joined(source),
                        enrolled[recogniser, "base"].joined(source),
                        *ids,
                    ),
                    probes.names,
                    gallery.names,
                    seen[recogniser, method].qualities,
                ),
                seen[recogniser, method],
                enrolled[recogniser, "base"],
            )
            for recogniser, engine in self.engines.items()
            for source in self.landmarks
            for method, upscaler in self.methods.items()
        ]

    def _look(
        self, pictures: Pictures, methods: Mapping[str, Upscaler | Several], what: str
    ) -> dict[tuple[str, str], Seen]:
        finder = self.finder if "own" in self.landmarks else None
        seen = {
            (recogniser, method): Seen(self.landmarks, finder)
            for recogniser in self.engines
            for method in methods
        }
        total = len(pictures.names)
        with tqdm(total=total, desc=what, unit="picture", disable=not self.progress) as bar:
            for start in range(0, total, _AT_ONCE):
                some = pictures.load(start, min(start + _AT_ONCE, total))
                for (recogniser, method), one in seen.items():
                    one.look(self.engines[recogniser], some, methods[method])
                bar.update(len(some))
        return seen


def known_landmarks(
    asked: Sequence[Landmarks], where: str, *, known: bool
) -> tuple[Landmarks, ...]:
    """Return the sources of landmarks that there are: what was asked for, as far as it is known.

    Args:
        asked: For.
        where: What messages call the pictures.
        known: Somebody has marked them.

    Raises:
        InputError: True ones alone are asked for, and nobody knows any.
    """
    if known:
        return tuple(asked)
    if "own" not in asked:
        raise InputError(
            f"recognition.landmarks=shared: no picture in {where} has landmarks_px; give"
            " recognition.landmarks=own"
        )
    return ("own",)
