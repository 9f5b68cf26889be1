"""Where does skin hold how much melanin and blood? Regions, mottling, lips and marks as maps.

What changes over several millimetres is painted on a coarse grid, what is finer is laid over it
from tiles (``grain``), patches (lips) and sheets (marks, lines).
"""

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.skin import regions
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.complexion import Complexion
from lrsr.identities.skin.grain import GrainMaps
from lrsr.identities.skin.layout import Layout, Patches
from lrsr.identities.skin.make_up import Lips
from lrsr.identities.skin.marks import LOG_MELANIN_PER_LEVEL, Marks, draw_capillaries, draw_marks
from lrsr.identities.skin.tone import tone_map

_CAVITY_PER_MM = (0.7, 1.3)
"""A groove of 1 mm looks as if the logarithms of melanin and blood were larger by this: light is
reflected to and fro in it, and each time gets darker and redder. Set by eye."""

_EVEN_MELANIN = 0.03
_NOISE_SHAPE = (256, 320)
_AXIS_Z_MM = -80.0
_OCTAVES = ((7, 0.030, 0.070), (16, 0.026, 0.055), (40, 0.024, 0.055), (100, 0.032, 0.070))
"""Cells around the head and amplitudes in the logarithms of melanin and blood."""


class PigmentPainter:
    """Turns the pigments of any number of people into colour within one texture layout.

    Args:
        layout: The texture.
    """

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._regions = regions.pigment_regions(layout.coarse)
        self._noise_pixels = _noise_pixels(layout.coarse)
        self._lips = Patches(layout.lips)
        waterline = np.zeros(layout.shape, dtype=np.float32)
        waterline[layout.face] = regions.lid_margin(layout.face_pixels, 1.2) * layout.front
        self._waterline = Patches(waterline)
        contact = regions.lip_contact(layout.position) * layout.lips
        self._contact = Patches(np.float32(0.45) * contact)

    def paint(
        self,
        skin: Complexion,
        lips: Lips,
        marks: Marks,
        grain: GrainMaps,
        groove: FloatMap,
        rng: Generator,
    ) -> FloatMap:
        """Paint one person's bare skin.

        Args:
            skin: Its pigments.
            lips: The lips' pigments.
            marks: Moles, freckles, spots and capillaries.
            grain: Pores and unevenness of the whole texture.
            groove: ``(h, w)``, heights of the lines in the layout's box of the face, mm.
            rng: Source of randomness of the mottling.

        Returns:
            ``(H, W, 3)`` float32, linear sRGB reflectance.
        """
        noise = self._mottle(rng)
        contrast = _melanin_contrast(skin["melanin"])
        coarse = self._tint_regions(noise, skin, contrast)
        melanin, blood = (self._layout.enlarge(part) for part in coarse)
        cv2.scaleAdd(grain.bumps, 0.035 * contrast * skin["melanin_mottle"], melanin, melanin)
        cv2.scaleAdd(grain.specks, 0.06 * skin["blood_mottle"], blood, blood)
        cv2.scaleAdd(grain.pores, 0.9 * contrast, melanin, melanin)
        cv2.scaleAdd(grain.pores, 0.7, blood, blood)
        self._lips.add(melanin, lips["melanin"])
        self._lips.add(blood, lips["blood"] * (1 - skin["lip_fading"]))
        self._waterline.add(blood, 0.6)
        face, of_marks = self._layout.face, LOG_MELANIN_PER_LEVEL * contrast**0.5
        melanin[face] += np.float32(-_CAVITY_PER_MM[0] * contrast) * groove
        blood[face] += np.float32(-_CAVITY_PER_MM[1]) * groove
        self._mark(melanin[face], draw_marks(marks, regions.FACE), of_marks)
        if marks["capillaries"]:
            self._mark(blood[face], draw_capillaries(marks, regions.FACE), 1.2 / 255)
        colour = tone_map(melanin, blood, carotene=skin["carotene"])
        self._contact.shade(colour)
        return colour

    def _tint_regions(
        self, noise: FloatMap, skin: Complexion, contrast: float
    ) -> tuple[FloatMap, FloatMap]:
        """Add the person's means and what each region has more of."""
        melanin = np.float32(skin["melanin_mottle"] * contrast) * noise[..., 0]
        blood = np.float32(skin["blood_mottle"]) * noise[..., 1]
        circles = np.float32(skin["dark_circles"]) * self._regions["circles"]
        melanin += np.float32(contrast) * circles
        melanin += np.float32(skin["tan"] * contrast) * self._regions["forehead"]
        shown = contrast**0.5  # what has no edges may differ more
        for place in ("perioral", "orbits", "sides"):
            melanin += np.float32(skin[place] * shown) * self._regions[place]
        melanin += np.float32(np.log(skin["melanin"]))
        flush = np.zeros_like(blood)
        for name in ("cheeks", "nose", "ears", "lids", "chin", "forehead"):
            flush += np.float32(skin[name]) * self._regions[name]
        flush *= 1 + np.float32(3.0) * noise[..., 1]  # blood's own mottling breaks a flush up
        blood += flush
        blood += np.float32(0.9) * circles
        blood += np.float32(0.5 * skin["orbits"]) * self._regions["orbits"]
        blood += np.float32(np.log(skin["blood"]))
        return melanin, blood

    def _mottle(self, rng: Generator) -> FloatMap:
        """Octaves of noise for the logarithms of melanin and of blood: ``(h, w, 2)``."""
        height, width = _NOISE_SHAPE
        sheet = np.zeros((height, width, 2), dtype=np.float32)
        for cells, melanin, blood in _OCTAVES:
            rows = max(2, cells * height // width)
            grid = rng.standard_normal((rows, cells, 2), dtype=np.float32)
            grid *= np.array([melanin, blood], dtype=np.float32)
            grid = np.concatenate([grid, grid[:, :1]], axis=1)
            sheet += cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC)
        noise = cv2.remap(
            sheet, self._noise_pixels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
        )
        return np.asarray(noise)

    def _mark(self, part: FloatMap, sheet: NDArray[np.uint8], per_level: float) -> None:
        levels = regions.FACE.sample(sheet, self._layout.face_pixels)
        part += np.float32(per_level) * levels * self._layout.bare


def _melanin_contrast(melanin: float) -> float:
    """How much of a change of the logarithm of melanin is let show; 1 in fair skin.

    The epidermis darkens light by exp(-melanin), so the same relative change of melanin would show
    ten times as strongly in dark skin as in fair; in photographs both are about equally even.

    Args:
        melanin: Mean volume fraction, > 0.

    Returns:
        (0, 1].

    Example:
        >>> round(_melanin_contrast(0.015), 2), round(_melanin_contrast(0.24), 2)
        (1.0, 0.29)
    """
    return float(min(1.0, (_EVEN_MELANIN / melanin) ** 0.6))


def _noise_pixels(position: FloatMap) -> FloatMap:
    """Cylinder around the head: azimuth to columns, height to rows; it wraps behind the head."""
    azimuth = np.arctan2(position[..., 0], position[..., 2] - np.float32(_AXIS_Z_MM))
    column = (azimuth / np.float32(2 * np.pi) + np.float32(0.5)) * (_NOISE_SHAPE[1] - 1)
    row = (np.float32(130.0) - position[..., 1]) / np.float32(340.0) * _NOISE_SHAPE[0]
    return np.stack([column, row], axis=-1).astype(np.float32)
