"""Where in a texture does the skin lie? Everything about a layout that no person changes."""

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from lrsr.identities.shape.position_map import PositionMap
from lrsr.identities.skin import regions
from lrsr.identities.skin.canvas import FloatMap

_COARSE = 256
"""Rows of the maps of everything that changes over several millimetres."""

Box = tuple[slice, slice]


class Layout:
    """A texture of the skin.

    Args:
        chart: The template point of each texel.

    Attributes:
        position: ``(H, W, 3)`` float32, mm; beyond the skin the nearest skin's.
        coarse: The same in at most ``_COARSE`` rows.
        texel_mm: Size of a texel on the face, mm.
        face: The box that holds the face, without the islands of what hides inside the head.
        face_pixels: ``(h, w, 2)``, the box's texels on ``regions.FACE``.
        front: ``(h, w)``, 1 in front, 0 behind the temples.
        lips: ``(H, W)``, the vermilion and the mouth's inside, [0, 1].
        bare: ``(h, w)``, skin in front without the lips, [0, 1].
    """

    def __init__(self, chart: PositionMap) -> None:
        self.position, mask = chart
        self.shape = mask.shape
        size = tuple(min(_COARSE, extent) for extent in reversed(mask.shape))
        self.coarse = cv2.resize(self.position, size, interpolation=cv2.INTER_AREA)
        self.texel_mm = _texel_size(self.position, mask)
        front = regions.front(self.position)
        self.face = largest_box(mask & (front > 0))
        pixels = regions.FACE.to_pixels(self.position)
        self.face_pixels = np.ascontiguousarray(pixels[self.face])
        self.front = np.ascontiguousarray(front[self.face])
        self.lips = regions.lip_mask(self.position, pixels)
        self.bare = self.front * (1 - self.lips[self.face])

    def enlarge(self, coarse: FloatMap) -> FloatMap:
        """Bring a map of ``coarse``'s size to the texture's."""
        size = self.shape[::-1]
        return np.asarray(cv2.resize(coarse, size, interpolation=cv2.INTER_LINEAR))


class Patches:
    """A map that is zero but for some small patches.

    Args:
        weight: ``(H, W)`` float32; below 0.01 it counts as zero.
    """

    def __init__(self, weight: FloatMap) -> None:
        labels, _ = ndimage.label(weight > 0.01)
        boxes: list[Box] = ndimage.find_objects(labels)
        self._patches = [(box, np.ascontiguousarray(weight[box])) for box in boxes]

    def add(self, target: FloatMap, amount: float) -> None:
        """Add the map times ``amount`` to ``target``, ``(H, W)``, in place."""
        for box, weight in self._patches:
            target[box] += np.float32(amount) * weight

    def shade(self, target: FloatMap) -> None:
        """Multiply ``target``, ``(H, W, 3)``, by one minus the map, in place."""
        for box, weight in self._patches:
            target[box] *= 1 - weight[..., None]


def largest_box(mask: NDArray[np.bool_]) -> Box:
    """Return the box of the largest connected patch; an empty box for an empty mask."""
    labels, count = ndimage.label(mask)
    if not count:
        return slice(0, 0), slice(0, 0)
    largest = int(np.bincount(labels.ravel())[1:].argmax())
    box: Box = ndimage.find_objects(labels)[largest]
    return box


def _texel_size(position: FloatMap, mask: NDArray[np.bool_]) -> float:
    """Median distance of neighbouring texels on the front of the face, mm."""
    both = mask[:, 1:] & mask[:, :-1] & (position[:, 1:, 2] > -15) & (position[:, 1:, 1] > -110)
    step = np.linalg.norm(np.diff(position, axis=1), axis=-1)[both]
    return float(np.median(step)) if step.size else 1.0
