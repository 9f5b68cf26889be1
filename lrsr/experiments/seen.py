"""What does one method make of pictures? Enlarged, found, embedded, and held against the truth."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.evaluation.quality import psnr_y
from lrsr.experiments.several import Several, see, surest
from lrsr.pictures.picture import Picture, stack
from lrsr.recognition.alignment import landmark_errors
from lrsr.recognition.finder import Finder
from lrsr.recognition.recognisers import Recogniser
from lrsr.recognition.settings import Landmarks
from lrsr.sr.upscaler import Upscaler

_Floats = NDArray[np.floating[Any]]


class Seen:
    """What one method has made of the pictures so far, in their order.

    Args:
        landmarks: Of which sources.
        finder: Finds faces; None where landmarks are the true ones.

    Attributes:
        decibels: PSNR of each against its true reference, where there are references.
    """

    def __init__(self, landmarks: Sequence[Landmarks], finder: Finder | None = None) -> None:
        self._finder = finder
        self._embeddings: dict[Landmarks, list[_Floats]] = {one: [] for one in landmarks}
        self._errors: list[_Floats] = []
        self._scores: list[_Floats] = []
        self.decibels: list[float] = []

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
        true: Sequence[Picture] | None = None,
    ) -> None:
        """Look at further pictures.

        Args:
            engine: Embeds; a batch for each size of picture.
            pictures: Of any sizes.
            upscaler: The method.
            true: Their true references, as many, if there are any.
        """
        alike: dict[object, list[int]] = {}
        for number, picture in enumerate(pictures):
            alike.setdefault(picture.image.shape, []).append(number)
        order = np.argsort(np.concatenate([*alike.values()]))
        parts: dict[Landmarks, list[_Floats]] = {one: [] for one in self._embeddings}
        found: list[tuple[_Floats, _Floats]] = []
        decibels = np.empty(0 if true is None else len(true))
        for members in alike.values():
            views, points = see(upscaler, [pictures[i] for i in members])
            found.append(self._embed(engine, upscaler, views, points.numpy(), parts))
            if true is None:
                continue
            if views.shape[1] > 1:  # no one picture is what it makes of a probe
                true, decibels = None, np.empty(0)
                continue
            references = stack([true[i] for i in members])[0].numpy()
            decibels[members] = psnr_y(views[:, 0].numpy(), references, shave=upscaler.scale)
        for landmarks, rows in parts.items():
            self._embeddings[landmarks].append(np.concatenate(rows)[order])
        errors, scores = (np.concatenate(some)[order] for some in zip(*found, strict=True))
        self._errors.append(errors)
        self._scores.append(scores)
        self.decibels += decibels.tolist()

    def _embed(
        self,
        engine: Recogniser,
        upscaler: Upscaler | Several,
        views: torch.Tensor,
        points: NDArray[np.float32],
        parts: dict[Landmarks, list[_Floats]],
    ) -> tuple[_Floats, _Floats]:
        """Add embeddings of one batch; return the errors of the landmarks found, and scores.

        Of several views these are those of the one with the highest score.
        """
        images, points = views.flatten(0, 1), points.reshape(-1, *points.shape[2:])
        faces = None if self._finder is None else self._finder(images)
        nothing = np.full(len(images), np.nan)
        scores = (nothing if faces is None else faces.scores).reshape(views.shape[:2])
        errors = nothing if faces is None else landmark_errors(faces.landmarks_px, points)

        def pooled(rows: _Floats) -> _Floats:
            several = rows.reshape(*scores.shape, -1)
            if isinstance(upscaler, Several):
                return upscaler.pool(several, scores)
            return several[:, 0]

        if "shared" in parts:
            parts["shared"].append(pooled(engine.embed(images, points)))
        if faces is not None:
            rows = engine.embed(images, faces.landmarks_px, faces.boxes_px)
            parts["own"].append(pooled(rows))
        best = surest(scores)
        return errors.reshape(scores.shape)[best], scores[best]
