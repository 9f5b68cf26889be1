"""What of a photograph is the person? GrabCut between the face and the edges of the picture.

Rother, Kolmogorov and Blake, "GrabCut: interactive foreground extraction using iterated graph
cuts", SIGGRAPH 2004, as OpenCV has it; the fitted head stands for the user's strokes.
"""

import cv2
import numpy as np
from numpy.typing import NDArray

from lrsr.identities.photographs.shot import Shot

Mask = NDArray[np.bool_]

_IPD_PX = 50.0
"""Size at which people are cut out."""
_ROUNDS = 5
_HAIR_IPDS = 0.9
"""Beyond this distance from the head there is no hair."""
_LIKELY_IPDS = 0.25
"""Up to this distance there may well be: at first all of it counts as the person's, so that hair is
not learned as a colour of the background."""
_SURE_IPDS = 0.12
"""Inside the face by this, everything is the person."""
_DEEP_IPDS = 0.35
"""Inside the fitted head by this, too: only near its edge can background come in."""
_BELOW_IPDS = 0.3
"""Below the chin by this, clothes begin."""


def find_person(shot: Shot, covered: Mask, face: Mask) -> Mask:
    """Return where the person is: ``(H, W)``.

    Args:
        shot: The photograph.
        covered: ``(H, W)``, where the fitted head is.
        face: ``(H, W)``, where the face is, by its landmarks.
    """
    height, width = covered.shape
    factor = min(1.0, _IPD_PX / shot.ipd_px)
    size = (max(1, round(width * factor)), max(1, round(height * factor)))
    ipd = shot.ipd_px * factor

    def small(mask: Mask) -> NDArray[np.uint8]:
        return np.asarray(cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST))

    head, inner = small(covered | face), small(face)
    away = cv2.distanceTransform(1 - head, cv2.DIST_L2, 5) / ipd
    deep, sure = (cv2.distanceTransform(part, cv2.DIST_L2, 5) / ipd for part in (head, inner))
    rows = np.flatnonzero(inner.any(axis=1))
    clothes = np.arange(size[1])[:, None] > rows.max(initial=0) + _BELOW_IPDS * ipd
    likely = away < _LIKELY_IPDS
    strokes = np.where(likely, cv2.GC_PR_FGD, cv2.GC_PR_BGD).astype(np.uint8)
    strokes[away > _HAIR_IPDS] = cv2.GC_BGD
    strokes[(deep > _DEEP_IPDS) | (sure > _SURE_IPDS)] = cv2.GC_FGD
    usable = ~np.broadcast_to(clothes, strokes.shape)
    if not ((strokes == cv2.GC_BGD) & usable).any() or not (strokes == cv2.GC_FGD).any():
        return covered | face
    last = int(np.flatnonzero(usable.any(axis=1)).max()) + 1
    light = np.clip(cv2.resize(shot.linear, size, interpolation=cv2.INTER_AREA), 0, 1)[:last]
    coded = (255 * np.sqrt(light)).astype(np.uint8)
    cut = np.ascontiguousarray(strokes[:last])
    cv2.setRNGSeed(0)
    models = np.zeros((1, 65)), np.zeros((1, 65))
    cv2.grabCut(coded, cut, None, *models, _ROUNDS, cv2.GC_INIT_WITH_MASK)
    person = head.copy()
    person[:last] = np.isin(cut, (cv2.GC_FGD, cv2.GC_PR_FGD))
    return np.asarray(cv2.resize(person, (width, height), interpolation=cv2.INTER_LINEAR) > 0)
