"""How does each frame of a burst lie over the first? A motion of the picture plane, in pixels.

A motion M is a matrix ``(2, 3)``: what the first frame shows at (x, y), it shows at M (x, y, 1).
"""

from math import nan
from typing import Protocol

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.configuration import as_number, as_whole, require
from lrsr.errors import ImageContractError
from lrsr.images import luminance, resize_bicubic

_MOTIONS = {
    "shift": cv2.MOTION_TRANSLATION,
    "rigid": cv2.MOTION_EUCLIDEAN,
    "affine": cv2.MOTION_AFFINE,
}
_ITERATIONS, _CHANGE = 200, 1e-7
"""When ECC ends: after so many steps, or when the correlation rises by less."""

_SMOOTHING_PX = 5
"""Window of the Gaussian that ECC looks through, on the enlarged frames."""


class Registration(Protocol):
    """Finds the motions of bursts."""

    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Return the motions ``(B, N, 2, 3)`` float32 of bursts ``(B, N, 3, H, W)``.

        Args:
            srgb: In [0, 1].
            landmarks_px: ``(B, N, P, 2)``, (x, y) px, for those who need them.

        Returns:
            The first of each burst is the identity; NaN: that frame could not be laid over it.
        """

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it; JSON-serialisable."""


class Correlation:
    """Climbs to the highest enhanced correlation of the luminance, by OpenCV.

    Evangelidis and Psarakis, "Parametric image alignment using enhanced correlation coefficient
    maximization", IEEE TPAMI 30(10), 2008. It does not see brightness and contrast. Frames are
    enlarged bicubically first, as OpenCV looks between pixels bilinearly.

    Args:
        motion: "shift", "rigid" (and turn) or "affine".
        finer: How many times frames are enlarged, 1 to 8.
        least: Correlation below which a frame is not of the same scene, 0 to 1.

    Raises:
        InputError: An argument is none of those.
    """

    def __init__(self, motion: str = "rigid", finer: int = 4, least: float = 0.5) -> None:
        known = f"one of {', '.join(_MOTIONS)}"
        require(motion in _MOTIONS, "registration.motion", motion, known)
        self.motion, self.finer = motion, as_whole(finer, "registration.finer")
        require(1 <= self.finer <= 8, "registration.finer", finer, "1 to 8")
        self.least = as_number(least, "registration.least")
        require(0 <= self.least <= 1, "registration.least", least, "0 to 1")

    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Find motions; see :class:`Registration`. Landmarks are not looked at."""
        grey = luminance(srgb.flatten(0, 1))
        grey = grey if self.finer == 1 else resize_bicubic(grey, self.finer)
        bursts = grey.reshape(*srgb.shape[:2], *grey.shape[-2:]).numpy(force=True)
        found = [[self._over(burst[0], frame) for frame in burst[1:]] for burst in bursts]
        still = np.eye(2, 3)
        motions = np.stack([np.stack([still, *each]) for each in found])
        return torch.from_numpy(motions.astype(np.float32))

    def _over(self, first: NDArray[np.float32], frame: NDArray[np.float32]) -> NDArray[np.float64]:
        criteria = (cv2.TERM_CRITERIA_COUNT | cv2.TERM_CRITERIA_EPS, _ITERATIONS, _CHANGE)
        start = np.eye(2, 3, dtype=np.float32)
        try:
            correlation, found = cv2.findTransformECC(
                first, frame, start, _MOTIONS[self.motion], criteria, None, _SMOOTHING_PX
            )
        except cv2.error:  # it has no step that helps: the frames do not overlap, or are flat
            correlation, found = nan, start
        if not correlation >= self.least:
            return np.full((2, 3), nan)
        motion = np.asarray(found, dtype=np.float64)
        to_fine = (self.finer - 1) / 2  # a point x of ours is finer x + that
        motion[:, 2] = (motion[:, :2].sum(axis=1) * to_fine + motion[:, 2] - to_fine) / self.finer
        return motion

    def describe(self) -> dict[str, object]:
        """Return its settings."""
        return {"by": "ECC", "motion": self.motion, "finer": self.finer, "least": self.least}


class TrueLandmarks:
    """Lays known points over each other: the oracle, where the true landmarks are given.

    It is the similarity (shift, turn, scale) of least squares. A later frame whose landmarks are
    NaN is not registered.
    """

    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        """Find motions; see :class:`Registration`.

        Raises:
            ImageContractError: There are none, not as many as frames, or none of a first frame.
        """
        if landmarks_px is None or landmarks_px.shape[:2] != srgb.shape[:2]:
            got = None if landmarks_px is None else tuple(landmarks_px.shape)
            wanted = f"({srgb.shape[0]}, {srgb.shape[1]}, P, 2)"
            raise ImageContractError(f"landmarks_px: got {got}, wanted {wanted}")
        if not landmarks_px[:, 0].isfinite().all():
            raise ImageContractError("landmarks_px: those of a first frame are not known")
        points = torch.view_as_complex(landmarks_px.double().contiguous())
        middles = points.mean(dim=-1, keepdim=True)
        first = (points - middles)[:, :1]
        size = (first.conj() * first).sum(dim=-1)
        turn = (first.conj() * (points - middles)).sum(dim=-1) / size
        shift = middles[..., 0] - turn * middles[:, :1, 0]
        columns = [turn, 1j * turn, shift]  # where (1, 0), (0, 1) and nothing go
        motions = torch.stack([torch.view_as_real(one) for one in columns], dim=-1)
        return motions.float()

    def describe(self) -> dict[str, object]:
        """Say that it is the truth."""
        return {"by": "true landmarks", "motion": "similarity"}
