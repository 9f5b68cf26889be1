"""Does skin dip into an eye?"""

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes
from lrsr.identities.face.lids import Lids


def pierced_mm(skin: NDArray[np.float64], eyes: Eyes, lids: Lids) -> float:
    """Return how deep skin that covers an eyeball on the template dips into it, the worse eye."""
    deep = 0.0
    for which in (0, 1):
        offset = skin[lids.vertices[which]] - eyes.centres[which]
        below = eyes.surface_mm(which, offset) - np.linalg.norm(offset, axis=1)
        over = (offset[:, 2] > 0.0) & (lids.distances[which] >= 1.0)
        deep = max(deep, float(below[over].max(initial=0.0)))
    return deep
