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

_SUBPIXEL_BITS = 4
_LIST_WIDTH = 1024


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
        scale = 1 << _SUBPIXEL_BITS
        pixels = np.round(self.to_pixels(strands_mm) * scale).astype(np.int32)
        levels = np.asarray(levels, dtype=np.int64)
        for index, level in enumerate(levels):
            group = list(pixels[index :: len(levels)])
            if group:
                cv2.polylines(sheet, group, False, int(level), 1, cv2.LINE_AA, shift=_SUBPIXEL_BITS)

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
        scale = 1 << _SUBPIXEL_BITS
        pixels = np.round(self.to_pixels(centres_mm) * scale).astype(np.int64)
        for (column, row), radius, level in zip(pixels, radii_mm, levels, strict=True):
            size = max(1, round(float(radius) / self.pixel_mm * scale))
            cv2.circle(
                sheet,
                (int(column), int(row)),
                size,
                int(level),
                -1,
                cv2.LINE_AA,
                shift=_SUBPIXEL_BITS,
            )

    def fill_polygon(
        self, sheet: NDArray[np.uint8], outline_mm: NDArray[np.floating[Any]], level: int = 255
    ) -> None:
        """Fill a closed outline.

        Args:
            sheet: ``(H, W)`` uint8, changed in place.
            outline_mm: ``(N, 2)``, mm.
            level: Grey level, 0..255.
        """
        scale = 1 << _SUBPIXEL_BITS
        pixels = np.round(self.to_pixels(outline_mm) * scale).astype(np.int32)
        cv2.fillPoly(sheet, [pixels], level, cv2.LINE_AA, shift=_SUBPIXEL_BITS)

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
