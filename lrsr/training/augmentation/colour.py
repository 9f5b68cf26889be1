"""What do other lamps, other cameras and whoever developed the picture do to colour and tone?

Hue and saturation are turned and scaled about the grey axis by the matrices of ``hueRotate`` and
``saturate`` in W3C, *Filter Effects Module Level 1*, section 9.6 (feColorMatrix).
"""

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.training.augmentation.ranges import SHARE, check_ranges

_GREY = np.tile([0.213, 0.715, 0.072], (3, 1))
_COLOURED = np.eye(3) - _GREY
_QUARTER_TURN = np.array([[-0.213, -0.715, 0.928], [0.143, 0.140, -0.283], [-0.787, 0.715, 0.072]])


@dataclass(frozen=True)
class Colour:
    """Widths of what is drawn for each face, all normal about no change.

    Attributes:
        gain: Standard deviation of the logarithm of the brightness, 0 to 1.
        tint: Of the logarithm of each channel's brightness, the white balance, 0 to 1.
        contrast: Of the logarithm of the contrast about the mean, 0 to 1.
        gamma: Of the logarithm of the exponent of the tone curve, 0 to 1.
        saturation: Of the logarithm of the saturation, 0 to 1.
        hue_deg: Of the angle that hues are turned by, degrees, 0 to 180.
        grey_share: How many faces lose their colour, 0 to 1.

    Raises:
        InputError: A number is out of its range.
    """

    gain: float = 0.0
    tint: float = 0.0
    contrast: float = 0.0
    gamma: float = 0.0
    saturation: float = 0.0
    hue_deg: float = 0.0
    grey_share: float = 0.0

    def __post_init__(self) -> None:
        widths = dict.fromkeys(("gain", "tint", "contrast", "gamma", "saturation"), (0.0, 1.0))
        limits = {**widths, "hue_deg": (0.0, 180.0), "grey_share": SHARE}
        check_ranges(self, "degradation.colour", limits)

    def __call__(self, faces: torch.Tensor, rng: np.random.Generator) -> torch.Tensor:
        """Recolour faces.

        Args:
            faces: ``(B, 3, H, W)``, srgb, [0, 1].
            rng: Source of every choice.

        Returns:
            ``(B, 3, H, W)``, srgb; not clipped.
        """
        count = len(faces)
        gain = rng.normal(0, self.gain, (count, 1)) + rng.normal(0, self.tint, (count, 3))
        contrast, gamma = (np.exp(rng.normal(0, s, count)) for s in (self.contrast, self.gamma))
        saturation = np.exp(rng.normal(0, self.saturation, count))
        saturation[rng.random(count) < self.grey_share] = 0
        hue_deg = rng.normal(0, self.hue_deg, count)
        matrices = _colour_matrices(saturation, hue_deg)
        grey = saturation == 0
        balance = np.exp(np.where(grey[:, None], gain.mean(axis=1, keepdims=True), gain))

        def a_face(values: NDArray[np.float64]) -> torch.Tensor:
            return torch.from_numpy(values.reshape(count, -1, 1, 1)).to(faces)

        toned = faces ** a_face(gamma)
        mixed = torch.einsum(
            "bdc,bchw->bdhw", torch.from_numpy(balance[:, :, None] * matrices).to(faces), toned
        )
        mean = mixed.mean(dim=(1, 2, 3), keepdim=True)
        return (mixed - mean).mul_(a_face(contrast)).add_(mean)


def _colour_matrices(
    saturation: NDArray[np.float64], hue_deg: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return ``(B, 3, 3)`` matrices, new RGB from old, of ``(B,)`` saturations and angles.

    Example:
        >>> _colour_matrices(np.ones(1), np.array([90.0]))[0, 0].round(3).tolist()
        [0.0, 0.0, 1.0]
    """
    turn = np.radians(hue_deg)[:, None, None]
    turned = np.cos(turn) * _COLOURED + np.sin(turn) * _QUARTER_TURN
    matrices: NDArray[np.float64] = _GREY + saturation[:, None, None] * turned
    return matrices
