"""What did faces look like to a computer before it learned? LBP, LPQ, HOG and Gabor features.

They are taken from the luminance of the aligned 112×112 face, in 7×7 regions of 16×16 pixels where
they are histograms. Nothing is trained. Local binary patterns and phase quantisation are compared
by chi-square, the other two by the cosine.
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import scipy.fft
import scipy.ndimage
import torch
from numpy.typing import ArrayLike, NDArray

from lrsr.evaluation.chi_square import chi_square_scores
from lrsr.evaluation.scores import CosineScores, ScoreSource
from lrsr.images import check_srgb, luminance
from lrsr.recognition.alignment import CROP_PX, align

_REGION_PX = 16

_Levels = NDArray[np.uint8]
_Floats = NDArray[np.float64]


def local_binary_patterns(levels: _Levels) -> _Floats:
    """Return histograms of uniform patterns of 8 points on a circle of 2 px.

    Ahonen, Hadid and Pietikäinen, *Face description with local binary patterns* (2006):
    LBP(8, 2, u2), 59 bins a region.

    Args:
        levels: ``(112, 112)`` luminance, 0 to 255.

    Returns:
        ``(2891,)``, sum 1.
    """
    from skimage.feature import local_binary_pattern  # 0.3 s that others need not pay

    codes = local_binary_pattern(levels, P=8, R=2, method="nri_uniform").astype(np.int64)
    return _regional_histograms(codes, 59)


def local_phase_quantisation(levels: _Levels) -> _Floats:
    """Return histograms of the signs of four local frequencies, which a blur leaves alone.

    Ojansivu and Heikkilä, *Blur insensitive texture classification using local phase quantization*
    (2008), equations 5 to 9 without the decorrelation: windows of 7 px, frequency 1/7, 256 bins.

    Args:
        levels: ``(112, 112)`` luminance, 0 to 255.

    Returns:
        ``(12544,)``, sum 1.
    """
    offsets = np.arange(-3, 4)
    flat, wave = np.ones(7), np.exp(-2j * np.pi * offsets / 7)
    image = levels.astype(np.complex128)

    def response(down: NDArray[Any], across: NDArray[Any]) -> NDArray[np.complex128]:
        # convolve1d turns the window round, as the definition does: sum of f(x - y) exp(-2πiuy)
        rows = scipy.ndimage.convolve1d(image, down, axis=0, mode="nearest")
        return np.asarray(scipy.ndimage.convolve1d(rows, across, axis=1, mode="nearest"))

    found = [
        response(flat, wave),
        response(wave, flat),
        response(wave, wave),
        response(wave, wave.conj()),
    ]
    signs = [part >= 0 for one in found for part in (one.real, one.imag)]
    codes = sum(sign.astype(np.int64) << bit for bit, sign in enumerate(signs))
    return _regional_histograms(np.asarray(codes), 256)


def oriented_gradients(levels: _Levels) -> _Floats:
    """Return histograms of oriented gradients.

    Dalal and Triggs, *Histograms of oriented gradients for human detection* (2005): 9 unsigned
    orientations, cells of 8×8 px, blocks of 2×2 cells, L2-Hys.

    Args:
        levels: ``(112, 112)`` luminance, 0 to 255.

    Returns:
        ``(6084,)``.
    """
    from skimage.feature import hog  # as above

    return np.asarray(hog(levels, orientations=9, pixels_per_cell=(8, 8), cells_per_block=(2, 2)))


def gabor_magnitudes(levels: _Levels) -> _Floats:
    """Return magnitudes of 5 × 8 Gabor wavelets, every 8 px, each wavelet's brought to mean 0.

    Liu and Wechsler, *Gabor feature based classification using the enhanced Fisher linear
    discriminant model* (2002): wave numbers π/2 / √2ᵏ, eight directions, σ = 2π, which is a
    Gaussian as wide as the wave is long; each response is normalised to mean 0 and variance 1.

    Args:
        levels: ``(112, 112)`` luminance, 0 to 255.

    Returns:
        ``(7840,)``.
    """
    image = scipy.fft.fft2(levels / 255.0, (2 * CROP_PX, 2 * CROP_PX))
    parts = []
    for spectrum, (top, left) in _gabor_spectra():
        response = scipy.fft.ifft2(image * spectrum)
        inside = np.abs(response[top : top + CROP_PX, left : left + CROP_PX])[4::8, 4::8]
        parts.append((inside - inside.mean()) / max(float(inside.std()), 1e-12))
    return np.ravel(parts)


@cache
def _gabor_spectra() -> list[tuple[NDArray[np.complex128], tuple[int, int]]]:
    """Return each wavelet's spectrum and where its middle lies."""
    from skimage.filters import gabor_kernel  # as above

    spectra = []
    for scale in range(5):
        frequency = 0.25 / np.sqrt(2) ** scale  # cycles per px: wave number / 2π
        for turn in range(8):
            kernel = gabor_kernel(
                frequency,
                theta=turn * np.pi / 8,
                sigma_x=1 / frequency,
                sigma_y=1 / frequency,
                n_stds=1.5,
            )
            kernel = kernel - kernel.mean()  # blind to the mean brightness
            middle = (kernel.shape[0] // 2, kernel.shape[1] // 2)
            spectra.append((scipy.fft.fft2(kernel, (2 * CROP_PX, 2 * CROP_PX)), middle))
    return spectra


def _regional_histograms(codes: NDArray[np.int64], bins: int) -> _Floats:
    """Count codes ``(112, 112)`` in each region; return the counts, sum 1."""
    regions = CROP_PX // _REGION_PX
    blocks = codes.reshape(regions, _REGION_PX, regions, _REGION_PX).swapaxes(1, 2)
    number = np.arange(regions**2)[:, None] * bins
    counts = np.bincount(
        (blocks.reshape(regions**2, -1) + number).ravel(), minlength=regions**2 * bins
    )
    return counts / codes.size


_Measure = Callable[..., ScoreSource]

FEATURES: dict[str, tuple[Callable[[_Levels], _Floats], _Measure]] = {
    "lbp": (local_binary_patterns, chi_square_scores),
    "lpq": (local_phase_quantisation, chi_square_scores),
    "hog": (oriented_gradients, CosineScores),
    "gabor": (gabor_magnitudes, CosineScores),
}


class Features:
    """A recogniser that has learned nothing.

    Args:
        name: Of :data:`FEATURES`.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self._describe, self._measure = FEATURES[name]

    def embed(
        self, srgb: torch.Tensor, landmarks_px: ArrayLike, boxes_px: ArrayLike | None = None
    ) -> NDArray[np.float32]:
        """Describe faces whose landmarks are known.

        Args:
            srgb: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            landmarks_px: ``(B, 5, 2)``, (x, y) in px of ``srgb``; NaN or masked = no face.
            boxes_px: Not needed.

        Returns:
            ``(B, D)`` float32; rows of sum 1 where chi-square compares, else of length 1; a row of
            NaN is a failure to acquire.

        Raises:
            ImageContractError: See :meth:`lrsr.recognition.engine.Engine.embed`.
        """
        check_srgb(srgb)
        crops, found = align(srgb, landmarks_px, antialias=True)
        grey = luminance(crops).mul(255).round().clamp(0, 255).to(torch.uint8).numpy(force=True)
        result = np.stack([self._describe(one) for one in grey[:, 0]])
        if self._measure is CosineScores:
            result /= np.maximum(np.linalg.norm(result, axis=1, keepdims=True), 1e-12)
        result[~found] = np.nan
        return result.astype(np.float32)

    def compare(
        self,
        probes: NDArray[Any],
        gallery: NDArray[Any],
        probe_ids: Sequence[str],
        gallery_ids: Sequence[str],
    ) -> ScoreSource:
        """Return scores, higher = more alike."""
        return self._measure(probes, gallery, probe_ids, gallery_ids)

    def describe(self) -> dict[str, str]:
        """Return what a report must say of it; JSON-serialisable."""
        by = "cosine" if self._measure is CosineScores else "chi-square"
        return {
            "features": self.name,
            "compared_by": by,
            "alignment": "arcface5",
            "trained_on": "-",
        }
