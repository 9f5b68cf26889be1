"""How is a face blurred when nobody holds still or focuses? By a Gaussian, round or drawn out.

A uniform motion along a path of the length L spreads a point with the variance L²/12 along it; its
Gaussian of that variance is added to that of the defocus.
"""

from dataclasses import dataclass

import numpy as np
import torch

from lrsr.recognition.alignment import TEMPLATE_IPD_PX
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.gaussians import filter_each, gaussian_kernels

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
        check_ranges(self, "degradation.blur", limits, spans=["sigma", "motion"])

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
        across = np.maximum(sigma[rows], _LEAST_SIGMA_PX)
        along = np.sqrt(across**2 + path[rows] ** 2 / 12)
        kernels = gaussian_kernels(across, along, angle[rows])
        result[torch.from_numpy(rows)] = filter_each(faces[torch.from_numpy(rows)], kernels)
        return result
