"""How is a face blurred when nobody holds still or focuses? By a Gaussian, round or drawn out.

A uniform motion along a path of the length L spreads a point with the variance L²/12 along it; its
Gaussian of that variance is added to that of the defocus.
"""

import math
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional as F

from lrsr.recognition.alignment import TEMPLATE_IPD_PX
from lrsr.training.augmentation.ranges import SHARE, check_ranges

_LEAST_SIGMA_PX = 0.05
"""Less cannot be told from a single pixel."""


@dataclass(frozen=True)
class Blur:
    """How many faces are blurred and how much; lengths in distances of the pupils.

    Attributes:
        share: How many are blurred, 0 to 1.
        sigma: Least and greatest standard deviation of the defocus, 0 to 1.
        motion_share: How many of those have moved, too, 0 to 1.
        motion: Shortest and longest path, 0 to 1, in any direction.

    Raises:
        InputError: A number is out of its range.
    """

    share: float = 0.0
    sigma: tuple[float, float] = (0.0, 0.0)
    motion_share: float = 0.0
    motion: tuple[float, float] = (0.0, 0.0)

    def __post_init__(self) -> None:
        limits = {"share": SHARE, "sigma": (0.0, 1.0), "motion_share": SHARE, "motion": (0.0, 1.0)}
        check_ranges(self, "module.degradation.blur", limits, spans=["sigma", "motion"])

    def __call__(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Blur aligned faces.

        Args:
            faces: ``(B, C, 112, 112)``.
            rng: Source of every choice.

        Returns:
            The same shape; the edge is repeated outwards.
        """
        count = len(faces)
        blurred = rng.random(count) < self.share
        sigma = rng.uniform(*self.sigma, count) * TEMPLATE_IPD_PX
        path = rng.uniform(*self.motion, count) * TEMPLATE_IPD_PX
        path[rng.random(count) >= self.motion_share] = 0
        angle = rng.uniform(0, np.pi, count)
        rows = np.flatnonzero(blurred)
        if not len(rows):
            return faces
        result = faces.clone()
        kernels = _kernels(sigma[rows], path[rows], angle[rows])
        result[torch.from_numpy(rows)] = _convolve(faces[torch.from_numpy(rows)], kernels)
        return result


def _kernels(
    sigma_px: NDArray[np.float64], path_px: NDArray[np.float64], angle: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return point spread functions ``(B, k, k)``, each of the sum 1, cut off at 3 σ.

    Args:
        sigma_px: ``(B,)``, of the defocus.
        path_px: ``(B,)``, length of the motion.
        angle: ``(B,)``, its direction from x to y, radians.
    """
    across = np.maximum(sigma_px, _LEAST_SIGMA_PX)[:, None, None]
    along = np.sqrt(across**2 + path_px[:, None, None] ** 2 / 12)
    radius = math.ceil(3 * along.max())
    y, x = np.mgrid[-radius : radius + 1, -radius : radius + 1]
    cosine, sine = np.cos(angle)[:, None, None], np.sin(angle)[:, None, None]
    squared = ((cosine * x + sine * y) / along) ** 2 + ((cosine * y - sine * x) / across) ** 2
    kernels: NDArray[np.float64] = np.exp(-0.5 * squared)
    kernels /= kernels.sum(axis=(1, 2), keepdims=True)
    return kernels


def _convolve(faces: torch.Tensor, kernels: NDArray[np.float64]) -> torch.Tensor:
    """Filter each face with its kernel."""
    count, channels = faces.shape[:2]
    radius = kernels.shape[-1] // 2
    padded = F.pad(faces, (radius, radius, radius, radius), mode="replicate")
    weights = torch.from_numpy(kernels).to(faces).repeat_interleave(channels, dim=0)[:, None]
    flat = padded.reshape(1, count * channels, *padded.shape[-2:])
    return F.conv2d(flat, weights, groups=count * channels).reshape(faces.shape)
