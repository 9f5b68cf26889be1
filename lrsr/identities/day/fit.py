"""Where on this head do things rest? Maps of its front and sides, its skull and its ears.

All of it is measured on the skin as it is that day and in that expression, so that what is worn
neither cuts into a face nor floats before it.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.ndimage import distance_transform_edt, map_coordinates, maximum_filter

from lrsr.identities.hair.anchors import SKULL_CENTRE_MM, chart_angles, load_anchors
from lrsr.identities.hair.chart import sample_chart

Points = NDArray[np.float64]

_CELL_MM = 2.0
_CRANIUM = slice(0, 30)
_STANDS_OUT_MM = 4.0
"""What of the ears' vertices stands off the skull that far is ear."""


@dataclass(frozen=True)
class Relief:
    """How far skin reaches, over a plane.

    Attributes:
        low: ``(2,)`` the least coordinates, mm.
        reach: ``(N, M)``, mm; filled where there is no skin.
    """

    low: Points
    reach: Points

    def at(self, first: ArrayLike, second: ArrayLike) -> Points:
        """Return how far the skin reaches at any places, mm."""
        a, b = np.broadcast_arrays(np.atleast_1d(first), np.atleast_1d(second))
        where = [(a - self.low[0]) / _CELL_MM, (b - self.low[1]) / _CELL_MM]
        return np.asarray(map_coordinates(self.reach, where, order=1, mode="nearest"))


class Fit:
    """What is known of one head.

    Args:
        skin: ``(V, 3)`` render vertices of the skin, mm.
        pupils: ``(2, 3)``, mm.
    """

    def __init__(self, skin: NDArray[np.floating], pupils: Points) -> None:
        self.skin = np.asarray(skin, dtype=np.float64)
        self.pupils = pupils
        anchors = load_anchors()
        self.chart = anchors.locate(skin)
        moved = self.chart[:, _CRANIUM] - anchors.template[:, _CRANIUM]
        self._shift = moved.mean(axis=(0, 1))
        self.centre = np.asarray(SKULL_CENTRE_MM) + self._shift
        self.is_ear = np.zeros(len(self.skin), dtype=bool)
        self.is_ear[anchors.ears] = True

    @cached_property
    def front(self) -> Relief:
        """How far the face reaches to the front, over x and y; without the ears."""
        chosen = self.skin[~self.is_ear & (self.skin[:, 2] > -90.0)]
        return relief(chosen[:, :2], chosen[:, 2], (-90.0, -190.0), (90.0, 90.0))

    def side(self, sign: int) -> Relief:
        """How far the head reaches to a side, over z and y; without the ears.

        Args:
            sign: 1 for the subject's left, -1 for the right.
        """
        chosen = self.skin[(np.sign(self.skin[:, 0]) == sign) & ~self.is_ear]
        low, high = (-160.0, -150.0), (30.0, 100.0)
        return relief(chosen[:, [2, 1]], sign * chosen[:, 0], low, high)

    def skull_mm(self, points: Points) -> Points:
        """Return how far points ``(..., 3)`` are off the skull, along rays from its centre, mm."""
        azimuth, polar = chart_angles(points - self._shift)
        surface = sample_chart(self.chart, azimuth, polar)
        radius = np.linalg.norm(surface - self.centre, axis=-1)
        return np.asarray(np.linalg.norm(points - self.centre, axis=-1) - radius)

    def ear(self, sign: int) -> tuple[Points, Points, Points]:
        """Return top of an ear, foremost point of its upper third, and lobe, each ``(3,)``, mm.

        Args:
            sign: 1 for the subject's left, -1 for the right.
        """
        around = self.skin[self.is_ear & (np.sign(self.skin[:, 0]) == sign)]
        inner = around[(around[:, 1] < 30.0) & (around[:, 1] > -70.0)]
        ear = inner[self.skull_mm(inner) > _STANDS_OUT_MM]
        if len(ear) < 10:  # ears that lie flat
            ear = inner
        top = ear[np.argsort(ear[:, 1])[-max(1, len(ear) // 100)]]
        upper = ear[ear[:, 1] > top[1] - 20.0]
        fore = upper[np.argsort(upper[:, 2])[-max(1, len(upper) // 50)]]
        return top, fore, ear[np.argsort(ear[:, 1])[len(ear) // 50]]


def relief(
    places: Points, reach: Points, low: tuple[float, float], high: tuple[float, float]
) -> Relief:
    """Keep the farthest vertex of each cell, and fill the cells between them."""
    corner = np.asarray(low)
    shape = tuple(int(n) for n in (np.asarray(high) - corner) / _CELL_MM + 1)
    cell = np.rint((places - corner) / _CELL_MM).astype(np.intp)
    inside = ((cell >= 0) & (cell < shape)).all(axis=1)
    table = np.full(shape, -np.inf)
    np.maximum.at(table, tuple(cell[inside].T), reach[inside])
    empty = np.isinf(table)
    nearest = distance_transform_edt(empty, return_distances=False, return_indices=True)
    filled = table[tuple(nearest)]
    return Relief(corner, maximum_filter(filled, size=3))
