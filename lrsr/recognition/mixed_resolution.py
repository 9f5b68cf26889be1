"""Can a small probe be compared with a large enrolled picture as they are, neither resized?

Mixed-resolution comparison after Peng, Spreeuwers and Veldhuis, *Likelihood ratio based mixed
resolution facial comparison* (IWBF 2015): either side has its own number of pixels and its own
projection into one common space, and two faces are compared by the likelihood ratio of the pair,
from the joint statistics of small and large pictures. :mod:`lrsr.training.mixed_resolution` learns
both projections. A probe that was enlarged before is averaged back to the pixels that it is for.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import ArrayLike, NDArray
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from lrsr.errors import InputError
from lrsr.evaluation.paired_gaussians import paired_log_ratios
from lrsr.evaluation.scores import ScoreSource
from lrsr.files import why_no_file, write_bytes
from lrsr.images import check_srgb, luminance
from lrsr.onnx import sha256_of
from lrsr.recognition.alignment import CROP_PX, TEMPLATE_IPD_PX, align

NAME = "mixed_resolution"
"""What it is called in ``recognition=[...]``."""

_Floats = NDArray[np.float32]
_TENSORS = ("probe_mean", "probe_map", "gallery_mean", "gallery_map", "correlations")


def _side_px(ipd_px: float) -> int:
    """Return the side of the aligned face in which the eyes are as far apart as in the picture.

    Example:
        >>> _side_px(8.0), _side_px(32.0)
        (25, 102)
    """
    return round(CROP_PX * ipd_px / TEMPLATE_IPD_PX)


def cut_faces(
    srgb: torch.Tensor, landmarks_px: ArrayLike, ipd_px: float
) -> tuple[_Floats, NDArray[np.bool_]]:
    """Align faces to so many pixels between the eyes; each gets mean 0 and variance 1.

    Args:
        srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
        landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``; NaN or masked = no face.
        ipd_px: Of the result.

    Returns:
        Luminance ``(B, side²)``, row by row, and ``(B,)``: was there a face?

    Raises:
        ImageContractError: See :meth:`lrsr.recognition.engine.Engine.embed`.
    """
    side = _side_px(ipd_px)
    crops, found = align(check_srgb(srgb), landmarks_px, antialias=True, size_px=(side, side))
    rows = luminance(crops).flatten(1).numpy(force=True)
    rows = rows - rows.mean(axis=1, keepdims=True)
    return rows / np.maximum(rows.std(axis=1, keepdims=True), np.float32(1e-6)), found


@dataclass(frozen=True)
class Card:
    """What the weights serve, and what they have learned from.

    Attributes:
        probe_ipd_px: Distance of the eyes in the probes, px.
        gallery_ipd_px: Distance to which enrolled faces are brought, px.
        people: How many were learned from.
        scene: How they were seen, in words.
        source: What made the weights.
    """

    probe_ipd_px: float
    gallery_ipd_px: float
    people: int
    scene: str
    source: str


@dataclass(frozen=True, eq=False)
class CommonSpace:
    """Two projections into one space of D numbers, whitened, in which like goes with like.

    Attributes:
        probe_mean: ``(p,)`` mean face of the probes, p pixels.
        probe_map: ``(p, D)``.
        gallery_mean: ``(q,)`` mean enrolled face, q pixels.
        gallery_map: ``(q, D)``.
        correlations: ``(D,)``, of number k of one person's probe and enrolled picture.
    """

    probe_mean: _Floats
    probe_map: _Floats
    gallery_mean: _Floats
    gallery_map: _Floats
    correlations: _Floats

    def compare(
        self,
        probes: NDArray[Any],
        gallery: NDArray[Any],
        probe_ids: Sequence[str],
        gallery_ids: Sequence[str],
    ) -> ScoreSource:
        """Return log-likelihood ratios of projected rows ``(P, D)`` and ``(G, D)``."""
        return paired_log_ratios(probes, gallery, self.correlations, probe_ids, gallery_ids)

    def of_probes(self, rows: _Floats) -> _Floats:
        """Project faces ``(B, p)`` as probes: ``(B, D)``."""
        return np.asarray((rows - self.probe_mean) @ self.probe_map, dtype=np.float32)

    def of_gallery(self, rows: _Floats) -> _Floats:
        """Project faces ``(B, q)`` as enrolled ones: ``(B, D)``."""
        return np.asarray((rows - self.gallery_mean) @ self.gallery_map, dtype=np.float32)


def write_space(path: Path, space: CommonSpace, card: Card) -> None:
    """Write the weights and their card as one safetensors file.

    Raises:
        InputError: The file cannot be written.
    """
    tensors = {name: np.ascontiguousarray(getattr(space, name)) for name in _TENSORS}
    # One note, not several: safetensors writes these in random order, and equal means equal bytes.
    write_bytes(path, save(tensors, metadata={NAME: json.dumps(asdict(card))}))


def _read_space(path: Path) -> tuple[CommonSpace, Card]:
    """Read what :func:`write_space` wrote.

    Raises:
        InputError: The file is missing, broken, or of something else.
    """
    if why := why_no_file(path):
        raise InputError(f"{path} {why}: lrsr train recognition={NAME} leaves weights")
    try:
        with safe_open(path, framework="np") as file:
            text, names = file.metadata() or {}, set(file.keys())
            tensors = {name: file.get_tensor(name) for name in names & {*_TENSORS}}
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path} is no safetensors file ({error}); fetch it again") from error
    try:
        card, space = _card(text[NAME]), CommonSpace(**tensors)
        whole = _fits(space, card)
    except (KeyError, ValueError, TypeError, IndexError) as error:
        raise InputError(f"{path} is not of {NAME} ({error}); train again") from error
    if not whole:
        raise InputError(f"{path}: its numbers do not fit its card; train again")
    return space, card


def _card(text: str) -> Card:
    told = json.loads(text)
    sizes = float(told["probe_ipd_px"]), float(told["gallery_ipd_px"])
    return Card(*sizes, int(told["people"]), str(told["scene"]), str(told["source"]))


def _fits(space: CommonSpace, card: Card) -> bool:
    """Are the shapes those of the card, and are all numbers usable?"""
    sides = _side_px(card.probe_ipd_px), _side_px(card.gallery_ipd_px)
    dimension = len(space.correlations)
    wanted: dict[str, tuple[int, ...]] = {"correlations": (dimension,)}
    for name, side in zip(("probe", "gallery"), sides, strict=True):
        wanted |= {f"{name}_mean": (side**2,), f"{name}_map": (side**2, dimension)}
    shapes = all(getattr(space, name).shape == shape for name, shape in wanted.items())
    finite = all(np.isfinite(getattr(space, name)).all() for name in _TENSORS)
    rho = space.correlations
    return shapes and finite and dimension > 0 and bool(((rho >= 0) & (rho < 1)).all())


class MixedResolution:
    """A recogniser that sees probes and enrolled pictures with different eyes.

    Args:
        weights: A file of ``lrsr train recognition=mixed_resolution``.

    Raises:
        InputError: See :func:`_read_space`.
    """

    def __init__(self, weights: Path) -> None:
        self.weights = weights
        self.space, self.card = _read_space(weights)

    def embed(
        self, srgb: torch.Tensor, landmarks_px: ArrayLike, boxes_px: ArrayLike | None = None
    ) -> _Floats:
        """Project faces both as probes and as enrolled ones: :meth:`compare` takes what it needs.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``; NaN or masked = no face.
            boxes_px: Not needed.

        Returns:
            ``(B, 2 D)`` float32, as a probe and as an enrolled face; a row of NaN is a failure to
            acquire.

        Raises:
            ImageContractError: See :meth:`lrsr.recognition.engine.Engine.embed`.
        """
        small, found = cut_faces(srgb, landmarks_px, self.card.probe_ipd_px)
        large, _ = cut_faces(srgb, landmarks_px, self.card.gallery_ipd_px)
        rows = np.hstack([self.space.of_probes(small), self.space.of_gallery(large)])
        rows[~found] = np.nan
        return rows

    def compare(
        self,
        probes: NDArray[Any],
        gallery: NDArray[Any],
        probe_ids: Sequence[str],
        gallery_ids: Sequence[str],
    ) -> ScoreSource:
        """Return natural log-likelihood ratios of ``(P, 2 D)`` probes and ``(G, 2 D)`` gallery."""
        dimension = len(self.space.correlations)
        return self.space.compare(
            probes[:, :dimension], gallery[:, dimension:], probe_ids, gallery_ids
        )

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it; JSON-serialisable."""
        return {
            "model": self.weights.name,
            "sha256": self._sha256,
            "dimension": len(self.space.correlations),
            "compared_by": "log-likelihood ratio",
            "alignment": "arcface5",
            **asdict(self.card),
        }

    @cached_property
    def _sha256(self) -> str:
        return sha256_of(self.weights)
