"""How does a face lie in the crop when a detector has found its landmarks? Not quite as it should.

The errors of the five points are drawn, and the similarity is fitted to them as alignment does it:
points that are 0.05 distances of the pupils off each by itself turn the face with a standard
deviation of 1.8 degrees, and the shipped RetinaFace, of such an error, by 1.7 (docs/detection.md).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lrsr.recognition.alignment import (
    CROP_PX,
    TEMPLATE_IPD_PX,
    TEMPLATE_PX,
    fit_similarities,
)
from lrsr.training.augmentation.ranges import SHARE, check_ranges

_LARGE_PX, _SMALL_PX = 64.0, 8.0
_NOSE = 2


@dataclass(frozen=True)
class Misalignment:
    """How far landmarks are off; lengths in distances of the pupils.

    Attributes:
        share: How many faces are found by a detector, 0 to 1; the others have their true landmarks.
        error: Mean distance of a point from the true one at 64 and at 8 px between the pupils,
            each 0 to 0.5; between these and beyond, linear in the logarithm of the size.
        nose_up: How much too high a detector finds the nose, 0 to 0.5.
        jitter: Standard deviation of what all points of any face are off together: shift, relative
            size, roll in radians; 0 to 0.5.

    Raises:
        InputError: A number is out of its range.
    """

    share: float = 0.0
    error: tuple[float, float] = (0.05, 0.09)
    nose_up: float = 0.0
    jitter: float = 0.0

    def __post_init__(self) -> None:
        most = dict.fromkeys(("error", "nose_up", "jitter"), (0.0, 0.5))
        check_ranges(self, "degradation.misalignment", {"share": SHARE, **most})

    def matrices(self, count: int, ipd_px: float, rng: np.random.Generator) -> NDArray[np.float64]:
        """Draw how faces are moved from where true landmarks would put them.

        Args:
            count: B.
            ipd_px: Distance of the pupils on the picture that a detector sees, > 0.
            rng: Source of every choice.

        Returns:
            ``(B, 2, 3)``, from the pixels of the right crop to those of the wrong one.
        """
        detected = rng.random(count) < self.share
        off = rng.normal(0, self._error(ipd_px) / np.sqrt(np.pi / 2), (count, 5, 2))
        off[:, _NOSE, 1] -= self.nose_up
        size = np.exp(rng.normal(0, self.jitter, (count, 1, 1)))
        roll = rng.normal(0, self.jitter, count)
        shift = rng.normal(0, self.jitter, (count, 1, 2)) * TEMPLATE_IPD_PX
        cosine, sine = np.cos(roll), np.sin(roll)
        turn = np.stack([np.stack([cosine, -sine], -1), np.stack([sine, cosine], -1)], axis=1)
        centre = (CROP_PX - 1) / 2
        points = TEMPLATE_PX + off * TEMPLATE_IPD_PX * detected[:, None, None]
        moved = size * np.einsum("bij,bkj->bki", turn, points - centre)
        return fit_similarities(moved + centre + shift)

    def _error(self, ipd_px: float) -> float:
        """Return the mean error of a point on a picture of that size.

        Example:
            >>> round(Misalignment()._error(22.63), 3)
            0.07
        """
        large, small = self.error
        smaller = np.log(_LARGE_PX / ipd_px) / np.log(_LARGE_PX / _SMALL_PX)
        return float(max(0.0, large + (small - large) * smaller))
