"""What does a landmark network see of a picture? A turned square of it, and the way back."""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_SHARP = 1.5
"""Up to how many px of the picture a pixel of the crop may span before the picture is blurred."""
_BLUR = 0.45
"""Standard deviation of that blur, in px of the crop."""


@dataclass(frozen=True)
class Crop:
    """A square of a picture.

    Attributes:
        centre_px: (x, y) of its middle.
        side_px: On the picture.
        angle_rad: How far its rows are turned from the picture's, > 0 from x to y.
        size_px: Rows and columns of what is taken.
    """

    centre_px: tuple[float, float]
    side_px: float
    angle_rad: float
    size_px: int

    @property
    def scale(self) -> float:
        """Px of the picture in one px of the crop."""
        return self.side_px / self.size_px

    def _matrix(self) -> Points:
        """Return the ``(2, 3)`` affine map from the crop to the picture."""
        cosine, sine = self.scale * np.cos(self.angle_rad), self.scale * np.sin(self.angle_rad)
        turn = np.array([[cosine, -sine], [sine, cosine]])
        half = np.full(2, (self.size_px - 1) / 2)
        return np.concatenate([turn, (np.array(self.centre_px) - turn @ half)[:, None]], axis=1)

    def take(self, image: NDArray[np.float32]) -> NDArray[np.float32]:
        """Cut it out of a picture ``(H, W, 3)``; black where the picture has ended.

        Returns:
            ``(size, size, 3)``; a larger picture is blurred before it is shrunk.
        """
        if self.scale > _SHARP:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), _BLUR * self.scale), np.float32)
        size = (self.size_px, self.size_px)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        return np.asarray(cv2.warpAffine(image, self._matrix(), size, flags=flags), np.float32)

    def back(self, points: Points) -> Points:
        """Return where points of the crop ``(N, 2)`` are on the picture.

        Example:
            >>> Crop((10.0, 20.0), 64.0, 0.0, 32).back(np.array([[15.5, 15.5]])).tolist()
            [[10.0, 20.0]]
        """
        matrix = self._matrix()
        return np.asarray(points @ matrix[:, :2].T + matrix[:, 2])
