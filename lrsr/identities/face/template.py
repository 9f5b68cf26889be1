"""Who is the average adult? The head that features are drawn on and that others are judged by."""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes, find_eyes
from lrsr.identities.face.lids import Lids, find_lids
from lrsr.identities.shape.basis import BaseHead, load_basis


@dataclass(frozen=True)
class Template:
    """The average adult: features are drawn on it, whoever will wear them.

    Its axes are those of the head frame, its origin lies where the middle between its pupils would
    be if it looked straight ahead: the *template's millimetres* of brows, beards and hair.

    Attributes:
        skin: ``(V, 3)`` render vertices, mm.
        eyes: Its eyes.
        lids: Its skin around the eyes.
    """

    skin: NDArray[np.float64]
    eyes: Eyes
    lids: Lids


@lru_cache(maxsize=1)
def template() -> Template:
    """Return the average adult; later calls are free."""
    basis = load_basis()
    head = basis.shape(basis.neutral)
    eyes = find_eyes(basis, head)
    origin = eyes.centres.mean(axis=0)
    origin[2] += eyes.radii.mean()
    head, eyes = BaseHead(*(part - origin for part in head)), eyes.moved(np.eye(3), origin)
    skin = basis.surface.matrix @ head.skin
    return Template(skin, eyes, find_lids(skin, eyes, basis.surface.faces))
