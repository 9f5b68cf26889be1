"""What is drawn over the bare skin of a face? Make-up, the beard and the brows.

:class:`FeaturePainter` knows where each of them lies in one texture and on the render mesh; what
they look like is drawn on their own sheets (``brows``, ``beard``).
"""

from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.face.lashes import Lashes
from lrsr.identities.skin import beard as beards
from lrsr.identities.skin import brows as eyebrows
from lrsr.identities.skin import regions
from lrsr.identities.skin.beard import Beard
from lrsr.identities.skin.brows import Brows
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.hair_colour import HairColour, hair_rgb
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.make_up import MakeUp

_WARM = np.array([1.6, 1.0, 0.6], dtype=np.float32)  # skin shines through the hairs
_DARKEST_BROW = np.array([0.036, 0.016, 0.007], dtype=np.float32)
_WHITE_BROW = (0.36, 0.33, 0.30)
_BLUSH = np.array([0.46, 0.16, 0.15])
_CHEEKBONE_MM = (44.0, -30.0, -14.0)
_LASH_ROOTS = (0.030, 0.018, 0.012)
_BROW_GREY = 0.45  # brows turn grey later than the hair of the head
_WHITE_BEARD = 0.35  # share of white hairs from which a beard no longer darkens the skin

_SEEN = np.float32(1e-3)
"""What covers less of the skin than this is not painted."""

_TOP_OF_BEARDS_MM = 10.0
"""No beard grows above this height."""


class FeaturePainter:
    """Paints make-up, beards and brows of any number of people into one texture layout.

    Args:
        layout: The texture.
        vertices: ``(V, 3)`` float32, the template's vertices that beards thicken, mm.
    """

    def __init__(self, layout: Layout, vertices: FloatMap) -> None:
        position, lips, self._texel_mm = layout.position, layout.lips, layout.texel_mm
        face_pixels = regions.FACE.to_pixels(position)
        front = regions.front(position)
        self._lips = _Stencil.cut(lips)
        self._contact = regions.lip_contact(position).ravel()[self._lips.texels] * self._lips.share
        cheeks = regions.blob(position, _CHEEKBONE_MM, (13.0, 8.0, 30.0)) * front
        self._cheeks = _Stencil.cut(cheeks)
        self._lids = _Stencil.cut(regions.lids(position))
        self._liner = _Stencil.cut(regions.lid_margin(face_pixels, 2.8, upper=True) * front)
        self._lash_line = _Stencil.cut(regions.lid_margin(face_pixels, 1.9, upper=True) * front)
        self._skin_sample = np.flatnonzero(cheeks > np.float32(0.8))[::16]
        brows = eyebrows.CANVAS.to_pixels(position)
        self._brows = _Stencil.cut(front * eyebrows.CANVAS.holds(brows))
        self._brow_pixels = brows.reshape(-1, 2)[self._brows.texels]
        self._set_beard(position, lips)
        self._vertex_pixels = beards.JAW.to_pixels(beards.to_jaw(vertices))
        vertex_lips = regions.lip_mask(vertices, regions.FACE.to_pixels(vertices))
        self._vertex_zones = beards.beard_zones(vertices, vertex_lips)

    def _set_beard(self, position: FloatMap, lips: FloatMap) -> None:
        """Find the texels on which a beard may grow, and where they lie on its sheet."""
        low = np.flatnonzero(position[..., 1] < _TOP_OF_BEARDS_MM)
        zones = beards.beard_zones(position.reshape(-1, 3)[low], lips.ravel()[low])
        grows = np.maximum.reduce(list(zones.values())) > 0
        self._jaw = low[grows]
        self._zones = {name: zone[grows] for name, zone in zones.items()}
        self._shadow = beards.shadow_mask(self._zones)
        points = position.reshape(-1, 3)[self._jaw]
        self._jaw_pixels = beards.JAW.to_pixels(beards.to_jaw(points))

    def paint_make_up(self, albedo: FloatMap, make_up: MakeUp) -> None:
        """Put make-up on.

        Args:
            albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, changed in place.
            make_up: What a person wears.
        """
        # Darker skin wears darker make-up: pale colours would look like chalk.
        depth = min(1.0, 0.2 + 3.2 * float(albedo.reshape(-1, 3)[self._skin_sample].mean()))
        if make_up["lipstick"] > 0:
            texels, opacity = self._lips.times(make_up["lipstick"])
            opacity *= 1 - np.float32(0.4) * self._contact
            cover(albedo, depth * np.asarray(make_up["lipstick_colour"]), texels, opacity)
        if make_up["blush"] > 0:
            cover(albedo, depth * _BLUSH, *self._cheeks.times(make_up["blush"]))
        if make_up["eyeshadow"] > 0:
            colour = depth * np.asarray(make_up["eyeshadow_colour"])
            cover(albedo, colour, *self._lids.times(make_up["eyeshadow"]))
        if make_up["eyeliner"] > 0:
            cover(albedo, (0.012, 0.010, 0.010), *self._liner.times(make_up["eyeliner"]))

    def paint_lash_lines(self, albedo: FloatMap, lashes: Lashes) -> None:
        """Darken the upper lids where the roots of the lashes stand.

        Args:
            albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, changed in place.
            lashes: A person's lashes.
        """
        cover(albedo, _LASH_ROOTS, *self._lash_line.times(min(0.75, 3.2 * lashes["width_mm"])))

    def paint_brows(self, albedo: FloatMap, brows: Brows, hair: HairColour, rng: Generator) -> None:
        """Paint the brows.

        Args:
            albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, changed in place.
            brows: A person's brows.
            hair: The pigments of the hair.
            rng: Source of randomness of the single hairs.
        """
        hairs = eyebrows.lay_brows(brows, rng)
        white = round(min(1.0, _BROW_GREY * hair["grey"]) * len(hairs))
        colour = hair_rgb(hair, darker=2.2, grey=0.0) * _WARM
        colour *= min(1.0, 0.13 / float(colour.max()))
        colour = np.maximum(colour, _DARKEST_BROW)
        _shade(albedo, colour, self._brows.texels, self._brow_opacity(hairs[white:]))
        if white:
            cover(albedo, _WHITE_BROW, self._brows.texels, self._brow_opacity(hairs[:white]))

    def _brow_opacity(self, hairs: NDArray[Any]) -> FloatMap:
        sheet = self._soften(eyebrows.cover_brows(hairs), eyebrows.CANVAS.pixel_mm)
        opacity = eyebrows.CANVAS.sample(sheet, self._brow_pixels).astype(np.float32)
        opacity *= self._brows.share / np.float32(255)
        return opacity

    def paint_beard(
        self, albedo: FloatMap, beard: Beard, hair: HairColour, rng: Generator
    ) -> FloatMap:
        """Paint shaven hair and the beard.

        Args:
            albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, changed in place.
            beard: A person's beard.
            hair: The pigments of the hair.
            rng: Source of randomness of the single hairs.

        Returns:
            How far the beard stands out at each vertex, ``(V,)`` float32, mm.
        """
        colour = hair_rgb(hair, darker=2.0, grey=beard["grey"])
        if beard["shadow"] > 0:
            dark = 1 - min(1.0, 4.0 * float(colour.mean()))
            opacity = np.float32(0.42 * beard["shadow"] * dark) * self._shadow
            cover(albedo, (0.055, 0.058, 0.064), self._jaw, opacity)
        if beard["kind"] == "none":
            return np.zeros(len(self._vertex_pixels), dtype=np.float32)
        sheet = beards.draw_beard(beard, rng)
        tufts = beards.thin_out(beard, rng, sheet.shape)
        sheet = np.asarray(cv2.multiply(sheet, tufts, dtype=cv2.CV_8U), dtype=np.uint8)
        sheet = self._soften(sheet, beards.JAW.pixel_mm)
        opacity = beards.JAW.sample(sheet, self._jaw_pixels).astype(np.float32)
        mask = beards.beard_mask(beard, self._zones)
        paint = cover if beard["grey"] * hair["grey"] > _WHITE_BEARD else _shade
        paint(albedo, colour, self._jaw, beards.feather(opacity / np.float32(255), mask))
        length = 0.7 * beard["length_mm"] * min(1.0, beard["density"])
        length = 0.0 if beard["kind"] == "stubble" else length
        thick = beards.JAW.sample(tufts, self._vertex_pixels)
        relief = np.float32(length) * thick * beards.beard_mask(beard, self._vertex_zones)
        return np.asarray(relief, dtype=np.float32)

    def _soften(self, sheet: NDArray[np.uint8], pixel_mm: float) -> NDArray[np.uint8]:
        """Blur hairs to the size of a texel, so that none is lost between two."""
        sigma = max(0.3, 0.35 * self._texel_mm / pixel_mm)
        return np.asarray(cv2.GaussianBlur(sheet, (0, 0), sigma), dtype=np.uint8)


class _Stencil(NamedTuple):
    """The texels that something may cover.

    Attributes:
        texels: ``(n,)``, indices into the flat texture.
        share: ``(n,)`` float32, the largest opacity there, [0, 1].
    """

    texels: NDArray[np.int64]
    share: FloatMap

    @classmethod
    def cut(cls, mask: FloatMap) -> "_Stencil":
        """Cut out what is seen of a mask ``(H, W)``."""
        texels = np.flatnonzero(mask > _SEEN)
        return cls(texels, mask.ravel()[texels])

    def times(self, strength: float) -> tuple[NDArray[np.int64], FloatMap]:
        """Return the texels and their opacity at a strength, [0, 1]."""
        return self.texels, np.float32(strength) * self.share


def cover(
    albedo: FloatMap, colour: ArrayLike, texels: NDArray[np.int64], opacity: FloatMap
) -> None:
    """Paint a colour over some texels.

    Args:
        albedo: ``(H, W, 3)`` float32, changed in place.
        colour: Three numbers, linear sRGB.
        texels: ``(n,)``, indices into the flat texture, each once.
        opacity: ``(n,)`` float32, [0, 1]; what covers less than a thousandth is not painted.
    """
    texels, opacity = _seen(texels, opacity)
    for channel, level in zip(albedo.reshape(-1, 3).T, np.asarray(colour, np.float32), strict=True):
        bare = channel[texels]
        channel[texels] = bare + (level - bare) * opacity


def _shade(
    albedo: FloatMap, colour: ArrayLike, texels: NDArray[np.int64], opacity: FloatMap
) -> None:
    """Paint dark hairs over some texels in place: between them skin is seen by what they let pass.

    Light reaches that skin past hairs and leaves past hairs, so what is half covered is not the
    mean of both colours, which looks like ash, but darker and warmer: their geometric mean.
    """
    texels, opacity = _seen(texels, opacity)
    for channel, level in zip(albedo.reshape(-1, 3).T, np.asarray(colour, np.float32), strict=True):
        bare = np.maximum(channel[texels], np.float32(1e-4))
        channel[texels] = bare * np.exp(np.log(level / bare) * opacity)


def _seen(texels: NDArray[np.int64], opacity: FloatMap) -> tuple[NDArray[np.int64], FloatMap]:
    """Leave out what covers less than :data:`_SEEN`."""
    seen = opacity > _SEEN
    return texels[seen], opacity[seen]
