"""What does one method make of pictures? Enlarged, found, embedded, and held against the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.experiments.likeness import Truth, by_size
from lrsr.experiments.several import Several, see, surest
from lrsr.pictures.picture import Picture
from lrsr.recognition.alignment import landmark_errors
from lrsr.recognition.finder import Finder
from lrsr.recognition.recognisers import Recogniser
from lrsr.recognition.settings import Landmarks
from lrsr.sr.upscaler import Upscaler

_Floats = NDArray[np.floating[Any]]

WRONG_PLACE_IPDS = 0.25
"""A face whose landmarks are farther off than this, on average, is in a wrong place."""


class Seen:
    """What one method has made of the pictures so far, in their order.

    Args:
        landmarks: Of which sources.
        finder: Finds faces; None where landmarks are the true ones.

    Attributes:
        likeness: Of each to its true reference, by the names of
            :data:`lrsr.experiments.likeness.MEASURES`; empty where there are no references.
    """

    def __init__(self, landmarks: Sequence[Landmarks], finder: Finder | None = None) -> None:
        self._finder = finder
        self._embeddings: dict[Landmarks, list[_Floats]] = {one: [] for one in landmarks}
        self._errors: list[_Floats] = []
        self._scores: list[_Floats] = []
        self._false: list[_Floats] = []
        self.likeness: dict[str, list[float]] = {}

    def joined(self, landmarks: Landmarks) -> NDArray[np.float64]:
        """Return the embeddings of all, ``(n, D)``, with landmarks of one source."""
        return np.concatenate(self._embeddings[landmarks], dtype=np.float64)

    @property
    def errors(self) -> _Floats:
        """Of the landmarks found, in distances of the true eyes, ``(n,)``.

        NaN where no face was looked for or found, or the true landmarks are not known.
        """
        return np.concatenate(self._errors)

    @property
    def false_faces(self) -> _Floats:
        """How many faces were reported that are in a wrong place, or a second one, ``(n,)``.

        NaN where no face was looked for, or the true landmarks are not known.
        """
        return np.concatenate(self._false)

    @property
    def qualities(self) -> dict[str, list[float]]:
        """Return measures of each picture by name: the detector's score, NaN where it found none.

        They are the same whatever the landmarks; empty where no detector looked.
        """
        if self._finder is None:
            return {}
        return {"detector_score": np.concatenate(self._scores).tolist()}

    def look(
        self,
        engine: Recogniser,
        pictures: Sequence[Picture],
        upscaler: Upscaler | Several,
        true: Truth | None = None,
    ) -> None:
        """Look at further pictures.

        Args:
            engine: Embeds; a batch for each size of picture.
            pictures: Of any sizes.
            upscaler: The method.
            true: Their true references, if there are any.
        """
        groups = by_size(pictures)
        order = np.argsort(np.concatenate(groups))
        parts: dict[Landmarks, list[_Floats]] = {one: [] for one in self._embeddings}
        found: list[tuple[_Floats, ...]] = []
        likeness: list[dict[str, _Floats]] = []
        for members in groups:
            views, points = see(upscaler, [pictures[i] for i in members])
            images, known = views.flatten(0, 1), points.flatten(0, 1).numpy()
            # of several views no one is what the method makes of a probe
            measured = None if views.shape[1] > 1 else true
            faces = None if self._finder is None else self._finder(images)
            nothing = np.full(len(images), np.nan)
            scores = (nothing if faces is None else faces.scores).reshape(views.shape[:2])
            errors = nothing if faces is None else landmark_errors(faces.landmarks_px, known)
            false = nothing if faces is None else _false_faces(faces.counts, errors)
            if "shared" in parts or measured is not None:
                embedded = engine.embed(images, known)
            if "shared" in parts:
                parts["shared"].append(_pooled(upscaler, embedded, scores))
            if measured is not None:
                likeness.append(measured.measure(members, images, embedded, upscaler.scale))
            if faces is not None:
                rows = engine.embed(images, faces.landmarks_px, faces.boxes_px)
                parts["own"].append(_pooled(upscaler, rows, scores))
            best = surest(scores)  # of several views
            found.append(tuple(one.reshape(scores.shape)[best] for one in (errors, scores, false)))
        for source, rows_of in parts.items():
            self._embeddings[source].append(np.concatenate(rows_of)[order])
        for kept, some in zip(
            (self._errors, self._scores, self._false), zip(*found, strict=True), strict=True
        ):
            kept.append(np.concatenate(some)[order])
        for name in likeness[0] if likeness else ():
            values = np.concatenate([one[name] for one in likeness])[order]
            self.likeness.setdefault(name, []).extend(values.tolist())


def _false_faces(counts: _Floats, errors: _Floats) -> _Floats:
    """Return how many faces are left when the one in the right place is taken away."""
    false = counts - (errors <= WRONG_PLACE_IPDS)
    return np.where((counts > 0) & np.isnan(errors), np.nan, false)


def _pooled(upscaler: Upscaler | Several, rows: _Floats, scores: _Floats) -> _Floats:
    """Return one row for each picture, ``(B, D)``, of those of all views, ``(B * M, D)``."""
    views = rows.reshape(*scores.shape, -1)
    return upscaler.pool(views, scores) if isinstance(upscaler, Several) else views[:, 0]
