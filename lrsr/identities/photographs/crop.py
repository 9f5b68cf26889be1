"""What does a landmark network see of a picture? A turned square of it, and the way back.

The box about the five points is a square of 2.6 times the longer of: eyes to mouth, 0.9 times eye
to eye. Its middle is midway between eyes and mouth.
"""

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Points = NDArray[np.float64]

_BOX_SIDE = 2.6
"""Side of the box about five points, times the longer of: eyes to mouth, 0.9 times eye to eye."""
_EYES_TO_MOUTH = 0.9
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

    def within(self, points_px: Points) -> Points:
        """Return where points of the picture ``(N, 2)`` are on the crop: the way there.

        Example:
            >>> Crop((10.0, 20.0), 64.0, 0.0, 32).within(np.array([[10.0, 20.0]])).tolist()
            [[15.5, 15.5]]
        """
        matrix = self._matrix()
        return np.asarray(np.linalg.solve(matrix[:, :2], (points_px - matrix[:, 2]).T).T)


def axes(angle: float) -> Points:
    """Return the directions of a turned crop's rows and columns, as columns ``(2, 2)``."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[cosine, -sine], [sine, cosine]])


@dataclass(frozen=True)
class CropRule:
    """How a network's crop follows from a face.

    Attributes:
        side: Of the crop, times the longer side of the face's box.
        shift: How much lower the crop's middle is than the box's, in the same unit.
        size_px: Rows and columns of the crop.
    """

    side: float
    shift: float
    size_px: int

    def of_box(self, middle: Points, box_px: float, angle_rad: float) -> Crop:
        """Return the crop of a box by its middle ``(2,)``, its longer side and how it is turned."""
        x, y = middle + axes(angle_rad) @ [0.0, self.shift * box_px]
        return Crop((float(x), float(y)), self.side * box_px, angle_rad, self.size_px)

    def of_five(self, five_px: Points) -> Crop:
        """Return the crop of the box about five points ``(5, 2)``, level with the eyes.

        Example:
            >>> five_px = np.array([[10.0, 10], [30, 10], [20, 20], [12, 30], [28, 30]])
            >>> CropRule(side=2.0, shift=0.0, size_px=64).of_five(five_px)
            Crop(centre_px=(20.0, 20.0), side_px=104.0, angle_rad=0.0, size_px=64)
        """
        eyes, mouth = five_px[:2].mean(axis=0), five_px[3:].mean(axis=0)
        across = five_px[1] - five_px[0]
        reach = max(np.linalg.norm(mouth - eyes), _EYES_TO_MOUTH * np.linalg.norm(across))
        level = float(np.arctan2(across[1], across[0]))
        return self.of_box((eyes + mouth) / 2, _BOX_SIDE * float(reach), level)
