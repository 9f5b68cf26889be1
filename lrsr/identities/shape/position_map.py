"""Which point of the template does a texel show? Triangles drawn into the texture layout."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage


class PositionMap(NamedTuple):
    """The template's skin, seen from the texture.

    Attributes:
        points: ``(H, W, 3)`` float32, mm, the template's head frame. Texels that no triangle covers
            hold the point of the nearest one that is, so that nothing bleeds in over the seams.
        mask: ``(H, W)`` bool, True where a triangle covers the centre of the texel.
    """

    points: NDArray[np.float32]
    mask: NDArray[np.bool_]


def twice_area(
    p: NDArray[np.float64], q: NDArray[np.float64], r: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return twice the area of triangles in the plane, positive when counter-clockwise.

    Args:
        p: ``(..., 2 or more)`` first corners; only x and y count.
        q: Second corners.
        r: Third corners.

    Example:
        >>> float(twice_area(np.array([0.0, 0.0]), np.array([2.0, 0.0]), np.array([0.0, 3.0])))
        6.0
    """
    (px, py), (qx, qy), (rx, ry) = ((at[..., 0], at[..., 1]) for at in (p, q, r))
    return np.asarray((qx - px) * (ry - py) - (qy - py) * (rx - px))


class Raster(NamedTuple):
    """Which triangle lies over each texel, and where within it.

    Attributes:
        size: Rows and columns.
        row: ``(n,)`` of the covered texels; where triangles overlap, the later one comes later.
        column: ``(n,)``.
        triangle: ``(n,)`` index of the triangle.
        weights: ``(n, 3)`` of its corners, summing to 1.
    """

    size: int
    row: NDArray[np.int64]
    column: NDArray[np.int64]
    triangle: NDArray[np.int64]
    weights: NDArray[np.float64]

    def draw(
        self, faces: NDArray[np.integer], values: NDArray[np.floating]
    ) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Interpolate values ``(V, C)`` of the vertices of the same faces.

        Returns:
            ``(size, size, C)``, zero where nothing is, and the covered texels ``(size, size)``.
        """
        drawn = np.zeros((self.size, self.size, values.shape[1]))
        mask = np.zeros((self.size, self.size), dtype=bool)
        corners = np.take(values, np.take(faces, self.triangle, axis=0), axis=0)
        drawn[self.row, self.column] = np.einsum("nk,nkc->nc", self.weights, corners)
        mask[self.row, self.column] = True
        return drawn, mask


def draw_triangles(
    uv: NDArray[np.floating], faces: NDArray[np.integer], values: NDArray[np.floating], size: int
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Interpolate values over triangles at the centres of a square of texels.

    Args:
        uv: ``(V, 2)``, [0, 1]; texel (row 0, column 0) has its centre at (0.5 / size, 0.5 / size).
        faces: ``(F, 3)``; where two overlap, the later one wins.
        values: ``(V, C)``.
        size: Rows and columns, > 0.

    Returns:
        ``(size, size, C)``, zero where nothing is, and the covered texels ``(size, size)``.
    """
    return cover(uv, faces, size).draw(faces, values)


def cover(uv: NDArray[np.floating], faces: NDArray[np.integer], size: int) -> Raster:
    """Find which triangle lies over each texel; see :func:`draw_triangles`.

    Args:
        uv: ``(V, 2)``, [0, 1].
        faces: ``(F, 3)``.
        size: Rows and columns, > 0.
    """
    corners = np.take(uv, faces, axis=0).astype(np.float64) * size - 0.5
    a, b, c = corners.transpose(1, 0, 2)
    low = np.ceil(np.minimum(np.minimum(a, b), c) - 1e-9).astype(int).clip(0, size)
    high = np.floor(np.maximum(np.maximum(a, b), c) + 1e-9).astype(int).clip(-1, size - 1) + 1
    width, height = np.maximum(high - low, 0).T
    count = width * height

    def at_texels(values: NDArray[Any]) -> NDArray[Any]:
        return np.repeat(values, count)

    down, across = np.divmod(
        np.arange(count.sum()) - at_texels(np.cumsum(count) - count), at_texels(width)
    )
    column, row = at_texels(low[:, 0]) + across, at_texels(low[:, 1]) + down
    total = twice_area(a, b, c)
    total = at_texels(np.where(total == 0.0, np.nan, total))
    first, second = (
        at_texels((r - q)[:, 0]) * (row - at_texels(q[:, 1]))
        - at_texels((r - q)[:, 1]) * (column - at_texels(q[:, 0]))
        for q, r in ((b, c), (c, a))
    )
    first /= total
    second /= total
    third = 1.0 - (first + second)
    inside = np.flatnonzero((first >= -1e-9) & (second >= -1e-9) & (third >= -1e-9))
    triangle = np.searchsorted(np.cumsum(count), inside, side="right")
    weights = np.stack([part[inside] for part in (first, second, third)], axis=1)
    return Raster(size, row[inside], column[inside], triangle, weights)


def fill_outside(values: NDArray[np.float64], mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Give every texel beyond the mask the value of the nearest texel within: ``(H, W, C)``."""
    nearest = ndimage.distance_transform_edt(~mask, return_distances=False, return_indices=True)
    filled: NDArray[np.float64] = values[tuple(nearest)]
    return filled
