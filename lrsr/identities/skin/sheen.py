"""How does skin shine? Oily in the middle, matte at the sides and under a beard, moist on lips."""

from typing import TypedDict

import cv2
import numpy as np
from numpy.random import Generator

from lrsr.identities.skin.beard import Beard, beard_mask, beard_zones
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.regions import blob

_ROUGHNESS_LIMITS = (0.30, 0.75)
"""Square roots of the slopes α: 0.08 is wet, 0.56 powdery."""


_UNDER_BEARD = np.float32(0.25)


class Sheen(TypedDict):
    """Roughness (the square root of α): the level and what regions differ from it by."""

    roughness: float
    t_zone: float
    lips: float
    patchiness: float


def sample_sheen(rng: Generator, *, age: float) -> Sheen:
    """Draw how a person's skin shines.

    Weyrich et al. 2006 ("Analysis of human faces using a measurement-based skin reflectance
    model") found lobes of α about 0.2 to 0.35, narrower on nose, forehead and lips. The relief
    of the skin widens what is drawn here.

    Args:
        rng: Source of randomness.
        age: 0 (25 years) to 1 (old): drier.

    Returns:
        Plain numbers.
    """
    oiliness = rng.normal(0.0, 1.0)
    return {
        "roughness": float(np.clip(0.50 - 0.045 * oiliness + 0.03 * age, 0.42, 0.65)),
        "t_zone": float(-np.clip(0.08 + 0.03 * oiliness + rng.normal(0.0, 0.02), 0.01, 0.13)),
        "lips": float(-np.clip(rng.normal(0.13 - 0.05 * age, 0.05), 0.0, 0.22)),
        "patchiness": float(rng.uniform(0.02, 0.05)),
    }


class SheenPainter:
    """Paints the roughness of any number of people.

    Args:
        position: ``(h, w, 3)`` float32, template points of the texels, mm; coarse ones suffice.
        lips: ``(h, w)``, the vermilion, [0, 1].
    """

    def __init__(self, position: FloatMap, lips: FloatMap) -> None:
        nose = blob(position, (4.0, -36.0, 20.0), (9.0, 18.0, 18.0))
        forehead = blob(position, (0.0, 46.0, 10.0), (30.0, 18.0, 40.0))
        cheekbones = blob(position, (40.0, -21.0, -8.0), (13.0, 9.0, 25.0))
        lids = blob(position, (31.0, 4.0, 0.0), (12.0, 5.0, 20.0))
        oily = nose + forehead + np.float32(0.5) * cheekbones + np.float32(0.6) * lids
        self._t_zone = np.minimum(oily, np.float32(1)) * (1 - lips)
        chin = blob(position, (0.0, -102.0, 6.0), (20.0, 12.0, 25.0))
        jaws = blob(position, (55.0, -55.0, -30.0), (18.0, 25.0, 40.0))
        self._matte = np.float32(0.04) * (jaws + chin) * (1 - lips)
        self._lips = lips
        self._beards = beard_zones(position, lips)

    def paint(self, sheen: Sheen, beard: Beard, rng: Generator) -> FloatMap:
        """Paint one person.

        Args:
            sheen: As :func:`sample_sheen` draws it.
            beard: Its hairs break what would shine.
            rng: Source of randomness of the patches.

        Returns:
            ``(h, w)`` float32, roughness, within ``ROUGHNESS_LIMITS``.
        """
        height, width = self._lips.shape
        cells = rng.standard_normal((max(2, height // 3), max(2, width // 3)), dtype=np.float32)
        patches = cv2.resize(cells, (width, height), interpolation=cv2.INTER_CUBIC)
        roughness = np.float32(sheen["patchiness"]) * patches + self._matte
        roughness += np.float32(sheen["t_zone"]) * self._t_zone
        roughness += np.float32(sheen["lips"]) * self._lips
        roughness += np.float32(sheen["roughness"])
        roughness += _UNDER_BEARD * beard_mask(beard, self._beards)
        return np.asarray(np.clip(roughness, *_ROUGHNESS_LIMITS), dtype=np.float32)
