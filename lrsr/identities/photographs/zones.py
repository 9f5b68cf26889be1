"""Which texels are plain skin, and which are features? Masks on the template's millimetres."""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.morphable import position_map

Mask = NDArray[np.bool_]


class Zones(NamedTuple):
    """Parts of the skin, each ``(S, S)`` bool.

    Attributes:
        front: The face, from the hairline to below the chin and to before the ears.
        plain: Skin of the face without brows, eyes, lips and nostrils: what light is read from.
        core: Cheeks and nose, where neither hair nor the edge of the face comes.
        features: What is never taken for an outlier.
        hair: Where hair may fall over skin: the forehead and the sides.
        mouth: Lips and what is between them.
        points: ``(S, S, 3)`` float32, mm, the template point of each texel.
    """

    front: Mask
    plain: Mask
    core: Mask
    features: Mask
    hair: Mask
    mouth: Mask
    points: NDArray[np.float32]


@lru_cache(maxsize=2)
def zones(size: int) -> Zones:
    """Return the parts of a texture of that many rows; later calls are free."""
    points = position_map(size).points
    x, y, z = np.moveaxis(points, -1, 0)
    aside = np.abs(x)
    eyes = ((aside - 32) / 25) ** 2 + ((y + 1) / 13) ** 2 < 1
    brows = (aside < 58) & (y > 9) & (y < 30)
    mouth = (aside < 31) & (y > -90) & (y < -58) & (z > -60)
    nostrils = (aside < 16) & (y > -54) & (y < -42) & (z < 22)
    front = (z > -60) & (y > -118) & (y < 62)
    marked = eyes | brows | mouth | nostrils
    plain = front & ~marked
    return Zones(
        front=front,
        plain=plain,
        core=plain & (y < -5) & (y > -60) & (aside < 50),
        features=marked | ((aside < 18) & (y < 5) & (y > -60)),
        hair=(y > 26) | (aside > 45),
        mouth=mouth,
        points=points,
    )
