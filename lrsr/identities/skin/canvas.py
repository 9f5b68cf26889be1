"""Where on the face is a feature drawn? A frontal sheet of 0.2 mm pixels before the template head.

Every feature is drawn in the template's own millimetres and carried into the texture through the
position map (texel to template point), so it follows the anatomy whatever the person's shape.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatMap = NDArray[np.float32]

SUBPIXEL_BITS = 4
"""OpenCV draws corners that are given in sixteenths of a pixel."""

_LIST_WIDTH = 1024
STRAND_POINTS = 4
"""Of the polyline of a hair of brows or beards."""


@dataclass(frozen=True)
class Canvas:
    """A rectangle of the frontal plane (x to the subject's left, y up), rows from top to bottom.

    Attributes:
        left_mm: Smallest x.
        top_mm: Largest y.
        width_mm: Extent in x, > 0.
        height_mm: Extent in y, > 0.
        pixel_mm: Pixel size, > 0.
    """

    left_mm: float
    top_mm: float
    width_mm: float
    height_mm: float
    pixel_mm: float = 0.2

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns.

        Example:
            >>> Canvas(-10.0, 5.0, 20.0, 10.0).shape
            (50, 100)
        """
        return (
            max(1, round(self.height_mm / self.pixel_mm)),
            max(1, round(self.width_mm / self.pixel_mm)),
        )

    def to_pixels(self, points_mm: ArrayLike) -> FloatMap:
        """Turn template points into canvas positions (pixel centres at integers, as OpenCV has it).

        Args:
            points_mm: ``(..., 2 or 3)``, x, y (and an unused z), mm.

        Returns:
            ``(..., 2)`` float32, column and row.

        Example:
            >>> Canvas(-10.0, 5.0, 20.0, 10.0, pixel_mm=0.5).to_pixels([-8.75, 4.25])
            array([2., 1.], dtype=float32)
        """
        points = np.asarray(points_mm, dtype=np.float32)
        column = (points[..., 0] - np.float32(self.left_mm)) / np.float32(self.pixel_mm)
        row = (np.float32(self.top_mm) - points[..., 1]) / np.float32(self.pixel_mm)
        return np.stack([column, row], axis=-1) - np.float32(0.5)

    def holds(self, pixels: FloatMap) -> NDArray[np.bool_]:
        """Tell which positions of :meth:`to_pixels`, ``(..., 2)``, the sheet may colour."""
        size = np.array(self.shape[::-1], dtype=np.float32)
        return np.asarray(((pixels > -1) & (pixels < size)).all(axis=-1))

    def to_corners(self, points_mm: ArrayLike) -> NDArray[np.int32]:
        """Turn template points into what OpenCV draws with ``shift=SUBPIXEL_BITS``.

        Args:
            points_mm: ``(..., 2 or 3)``, mm.

        Returns:
            ``(..., 2)`` int32, column and row.
        """
        return np.round(self.to_pixels(points_mm) * (1 << SUBPIXEL_BITS)).astype(np.int32)

    def blank(self) -> NDArray[np.uint8]:
        """Return an empty sheet, ``(H, W)`` uint8."""
        return np.zeros(self.shape, dtype=np.uint8)

    def draw_strands(
        self, sheet: NDArray[np.uint8], strands_mm: NDArray[np.floating[Any]], levels: ArrayLike
    ) -> None:
        """Draw antialiased hairs one pixel wide into the sheet; later groups cover earlier ones.

        Args:
            sheet: ``(H, W)`` uint8, changed in place.
            strands_mm: ``(N, K, 2)``, the polyline of each hair, mm.
            levels: ``(L,)`` grey levels, 0..255; the strands are dealt to them in equal shares.
        """
        draw_corners(sheet, self.to_corners(strands_mm), np.asarray(levels).astype(int).tolist())

    def draw_dots(
        self,
        sheet: NDArray[np.uint8],
        centres_mm: NDArray[np.floating[Any]],
        radii_mm: Sequence[float] | NDArray[np.floating[Any]],
        levels: Sequence[int] | NDArray[np.integer[Any]],
    ) -> None:
        """Draw antialiased filled disks into the sheet, each with its own grey level.

        Args:
            sheet: ``(H, W)`` uint8, changed in place.
            centres_mm: ``(N, 2)``, mm.
            radii_mm: ``(N,)``, mm, > 0.
            levels: ``(N,)``, 0..255.
        """
        corners = self.to_corners(centres_mm).tolist()
        for corner, radius, level in zip(corners, radii_mm, levels, strict=True):
            size = max(1, round(float(radius) / self.pixel_mm * (1 << SUBPIXEL_BITS)))
            cv2.circle(sheet, corner, size, int(level), -1, cv2.LINE_AA, SUBPIXEL_BITS)

    def fill_polygon(
        self, sheet: NDArray[np.uint8], outline_mm: NDArray[np.floating[Any]], level: int = 255
    ) -> None:
        """Fill a closed outline.

        Args:
            sheet: ``(H, W)`` uint8, changed in place.
            outline_mm: ``(N, 2)``, mm.
            level: Grey level, 0..255.
        """
        cv2.fillPoly(sheet, [self.to_corners(outline_mm)], level, cv2.LINE_AA, SUBPIXEL_BITS)

    def sample(self, sheet: NDArray[Any], pixels: FloatMap) -> NDArray[Any]:
        """Read the sheet at positions of :meth:`to_pixels`, bilinear, 0 outside.

        Args:
            sheet: ``(H, W)`` uint8 or float32.
            pixels: ``(h, w, 2)`` or ``(N, 2)`` float32, columns and rows.

        Returns:
            ``(h, w)`` or ``(N,)``, the sheet's type.
        """
        if pixels.ndim == 2:  # OpenCV takes no list, and no image of more than 32767 rows
            rows = -(-len(pixels) // _LIST_WIDTH)
            padded = np.zeros((rows * _LIST_WIDTH, 2), dtype=np.float32)
            padded[: len(pixels)] = pixels
            grid = padded.reshape(rows, _LIST_WIDTH, 2)
            return self.sample(sheet, grid).reshape(-1)[: len(pixels)] if rows else sheet[:0, 0]
        sampled = cv2.remap(sheet, pixels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT)
        return np.asarray(sampled)


def draw_corners(
    sheet: NDArray[np.uint8], corners: NDArray[np.int32], levels: Sequence[int]
) -> None:
    """Draw the strands of :meth:`Canvas.draw_strands`.

    Args:
        sheet: ``(H, W)`` uint8, changed in place.
        corners: ``(N, K, 2)``, as :meth:`Canvas.to_corners` gives them.
        levels: ``(L,)`` grey levels, 0..255.
    """
    for index, level in enumerate(levels):
        group = list(corners[index :: len(levels)])
        if group:
            cv2.polylines(sheet, group, False, level, 1, cv2.LINE_AA, SUBPIXEL_BITS)


def bend_strands(
    length_mm: NDArray[np.float64], angle: NDArray[np.float64], bend: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Lay hairs that bend evenly along their way, each from its own origin.

    Args:
        length_mm: ``(N,)``.
        angle: ``(N,)``, at the root, radians from x to y.
        bend: ``(N,)``, what a hair turns by from root to tip, radians.

    Returns:
        ``(N, 4, 2)``, mm.

    Example:
        >>> bend_strands(np.array([3.0]), np.zeros(1), np.zeros(1))[0, :, 0]
        array([0., 1., 2., 3.])
    """
    pieces = STRAND_POINTS - 1
    turn = angle[:, None] + bend[:, None] * ((np.arange(pieces) + 0.5) / pieces)
    step = (length_mm / pieces)[:, None]
    moves = np.stack([step * np.cos(turn), step * np.sin(turn)], axis=-1)
    return np.concatenate([np.zeros((len(turn), 1, 2)), np.cumsum(moves, axis=1)], axis=1)
