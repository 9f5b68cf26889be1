"""What does a person's skin look like? Pigments, lips, brows, beard, marks and lines as textures.

:func:`sample_appearance` draws plain numbers, :func:`paint_skin` turns them into a linear albedo
and a relief. Everything is drawn on the template head and reaches the texture through its
position map.
"""

from dataclasses import dataclass
from typing import Any, TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray
from scipy import ndimage

from lrsr.identities import beard as beards
from lrsr.identities import brows as eyebrows
from lrsr.identities import regions
from lrsr.identities.beard import Beard, sample_beard
from lrsr.identities.brows import Brows, sample_brows
from lrsr.identities.canvas import FloatMap
from lrsr.identities.complexion import (
    Complexion,
    Lips,
    MakeUp,
    sample_complexion,
    sample_lips,
    sample_make_up,
)
from lrsr.identities.hair_colour import HairColour, hair_rgb, sample_hair_colour
from lrsr.identities.iris import Iris, sample_iris
from lrsr.identities.lines import ALBEDO_PER_MM, Lines, draw_lines, sample_lines
from lrsr.identities.marks import LOG_MELANIN_PER_LEVEL, Marks, draw_marks, sample_marks
from lrsr.identities.skin_tone import tone_map

_WARM = np.array([1.0, 0.9, 0.8], dtype=np.float32)  # skin shines through white brows


class Appearance(TypedDict):
    """Everything about one person that is painted; plain numbers and names, JSON-serialisable."""

    complexion: Complexion
    lips: Lips
    make_up: MakeUp
    marks: Marks
    lines: Lines
    brows: Brows
    beard: Beard
    hair_colour: HairColour
    iris: Iris


@dataclass(frozen=True)
class SkinMaps:
    """Painted skin.

    Attributes:
        albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, [0, 1], filled beyond the mask.
        displacement: ``(V,)`` float32, mm along the normal of each vertex that the painter knows:
            grooves below, beards above the skin.
    """

    albedo: FloatMap
    displacement: FloatMap


def sample_appearance(
    rng: Generator,
    *,
    masculinity: float,
    age: float,
    ancestry: ArrayLike,
) -> Appearance:
    """Draw what a person's skin, lips, brows, beard and eyes look like.

    Args:
        rng: Source of randomness; every trait gets a child of its own, so that a change to one of
            them leaves the others as they were.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old).
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.

    Returns:
        Plain numbers and names.
    """
    shares = np.asarray(ancestry, dtype=np.float64)
    asian, european = float(shares[1]), float(shares[2])
    child = dict(zip(Appearance.__annotations__, rng.spawn(9), strict=True))
    hair = sample_hair_colour(child["hair_colour"], age=age, ancestry=shares)
    complexion = sample_complexion(child["complexion"], age=age, ancestry=shares)
    return {
        "complexion": complexion,
        "lips": sample_lips(child["lips"]),
        "make_up": sample_make_up(child["make_up"], masculinity=masculinity),
        "marks": sample_marks(child["marks"], melanin=complexion["melanin"], age=age),
        "lines": sample_lines(child["lines"], age=age),
        "brows": sample_brows(child["brows"], masculinity=masculinity),
        "beard": sample_beard(
            child["beard"], masculinity=masculinity, asian=asian, grey=hair["grey"]
        ),
        "hair_colour": hair,
        "iris": sample_iris(child["iris"], european=european, eumelanin=hair["eumelanin"], age=age),
    }


class SkinPainter:
    """Paints the skin of any number of people into one texture layout.

    Args:
        position_map: ``(H, W, 3)`` float32, the template point of each texel, mm.
        mask: ``(H, W)`` bool, which texels lie on the skin.
        vertices: ``(V, 3)``, the template's vertices that will be displaced, mm; none by default.

    Raises:
        ValueError: The shapes disagree or the mask is empty.
    """

    def __init__(
        self,
        position_map: NDArray[Any],
        mask: NDArray[np.bool_],
        vertices: NDArray[Any] | None = None,
    ) -> None:
        if position_map.shape != (*mask.shape, 3):
            raise ValueError(
                f"position_map {position_map.shape} and mask {mask.shape} do not belong together"
            )
        if not mask.any():
            raise ValueError("the mask is empty: no texel lies on the skin")
        position = _fill_outside(position_map, mask)
        self._texel_mm = _texel_size(position, mask)
        self._texels = _Places(position)
        self._vertices = _Places(np.zeros((0, 3)) if vertices is None else vertices)
        self._noise_pixels = _noise_pixels(position)
        self._regions = regions.blood_regions(position)
        self._contact = regions.lip_contact(position) * self._texels.lips
        self._nostrils = regions.nostrils(position)
        front = self._texels.front
        self._waterline = regions.lid_margin(self._texels.face_pixels, 1.2) * front
        self._liner = regions.lid_margin(self._texels.face_pixels, 2.4, upper=True) * front
        self._shadow = beards.shadow_mask(self._texels.beard_zones)

    def paint(self, appearance: Appearance, seed: int) -> SkinMaps:
        """Paint one person.

        Args:
            appearance: As :func:`sample_appearance` draws it.
            seed: Of the noise and of the single hairs, >= 0; the same seed gives the same bytes.

        Returns:
            Albedo and displacement.
        """
        of_tone, of_beard, of_brows = np.random.default_rng(seed).spawn(3)
        heights = draw_lines(appearance["lines"], regions.FACE)
        albedo = self._paint_tone(appearance, of_tone)
        groove = regions.FACE.sample(heights, self._texels.face_pixels) * self._texels.front
        albedo *= np.exp(np.float32(ALBEDO_PER_MM) * groove)[..., None]
        self._paint_make_up(albedo, appearance["make_up"])
        tufts = self._paint_beard(albedo, appearance, of_beard)
        self._paint_brows(albedo, appearance, of_brows)
        return SkinMaps(np.clip(albedo, 0.0, 1.0), self._displace(appearance, heights, tufts))

    def _paint_tone(self, appearance: Appearance, rng: Generator) -> FloatMap:
        skin, lips = appearance["complexion"], appearance["lips"]
        melanin, blood = self._mottle(skin, rng)
        melanin += np.float32(np.log(skin["melanin"]))
        blood += np.float32(np.log(skin["blood"]))
        circles = np.float32(skin["dark_circles"])
        melanin += circles * self._regions["circles"]
        blood += np.float32(0.9) * circles * self._regions["circles"]
        melanin += np.float32(skin["tan"]) * self._regions["forehead"]
        for name in ("cheeks", "nose", "ears", "lids", "chin", "forehead"):
            blood += np.float32(skin[name]) * self._regions[name]
        blood += np.float32(lips["blood"]) * self._texels.lips
        melanin += np.float32(lips["melanin"]) * self._texels.lips
        blood += np.float32(0.6) * self._waterline
        marks = draw_marks(appearance["marks"], regions.FACE)
        spots = regions.FACE.sample(marks, self._texels.face_pixels).astype(np.float32)
        melanin += np.float32(LOG_MELANIN_PER_LEVEL) * spots * self._texels.bare
        colour = tone_map(melanin, blood)
        shade = 1 - np.float32(0.45) * self._contact - np.float32(0.5) * self._nostrils
        colour *= shade[..., None]
        return colour

    def _mottle(self, skin: Complexion, rng: Generator) -> tuple[FloatMap, FloatMap]:
        """Three octaves of noise in the logarithms of melanin and of blood."""
        height, width = _NOISE_SHAPE
        sheet = np.zeros((height, width, 2), dtype=np.float32)
        for cells, melanin, blood in ((12, 0.06, 0.09), (36, 0.05, 0.08), (110, 0.03, 0.05)):
            rows = max(2, cells * height // width)
            grid = rng.standard_normal((rows, cells, 2), dtype=np.float32)
            grid *= np.array([melanin, blood], dtype=np.float32)
            grid = np.concatenate([grid, grid[:, :1]], axis=1)
            sheet += cv2.resize(grid, (width, height), interpolation=cv2.INTER_CUBIC)
        sheet *= np.array([skin["melanin_mottle"], skin["blood_mottle"]], dtype=np.float32)
        noise = cv2.remap(
            sheet, self._noise_pixels, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
        )
        return np.ascontiguousarray(noise[..., 0]), np.ascontiguousarray(noise[..., 1])

    def _paint_make_up(self, albedo: FloatMap, make_up: MakeUp) -> None:
        if make_up["lipstick"] > 0:
            opacity = np.float32(make_up["lipstick"]) * self._texels.lips
            opacity *= 1 - np.float32(0.4) * self._contact
            _cover(albedo, make_up["lipstick_colour"], opacity)
        if make_up["eyeshadow"] > 0:
            opacity = np.float32(make_up["eyeshadow"]) * self._regions["lids"]
            _cover(albedo, make_up["eyeshadow_colour"], opacity)
        if make_up["eyeliner"] > 0:
            _cover(albedo, (0.012, 0.010, 0.010), np.float32(make_up["eyeliner"]) * self._liner)

    def _paint_brows(self, albedo: FloatMap, appearance: Appearance, rng: Generator) -> None:
        canvas = eyebrows.CANVAS
        sheet = self._soften(eyebrows.draw_brows(appearance["brows"], rng), canvas.pixel_mm)
        opacity = canvas.sample(sheet, self._texels.brow_pixels).astype(np.float32)
        opacity *= self._texels.front / np.float32(255)
        colour = hair_rgb(appearance["hair_colour"], darker=2.4, grey=0.3) * _WARM
        _cover(albedo, colour * min(1.0, 0.14 / float(colour.max())), opacity)

    def _paint_beard(
        self, albedo: FloatMap, appearance: Appearance, rng: Generator
    ) -> FloatMap | None:
        """Paint shaven hair and the beard; return how thick it grows on ``JAW``."""
        beard = appearance["beard"]
        colour = hair_rgb(appearance["hair_colour"], darker=2.0, grey=beard["grey"])
        if beard["shadow"] > 0:
            dark = 1 - min(1.0, 4.0 * float(colour.mean()))
            opacity = np.float32(0.42 * beard["shadow"] * dark) * self._shadow
            _cover(albedo, (0.055, 0.058, 0.064), opacity)
        if beard["kind"] == "none":
            return None
        sheet = beards.draw_beard(beard, rng)
        tufts = beards.thin_out(beard, rng, sheet.shape)
        sheet = np.asarray(cv2.multiply(sheet, tufts, dtype=cv2.CV_8U), dtype=np.uint8)
        sheet = self._soften(sheet, beards.JAW.pixel_mm)
        opacity = beards.JAW.sample(sheet, self._texels.jaw_pixels).astype(np.float32)
        mask = beards.beard_mask(beard, self._texels.beard_zones)
        _cover(albedo, colour, beards.feather(opacity / np.float32(255), mask))
        return tufts

    def _displace(
        self, appearance: Appearance, heights: FloatMap, tufts: FloatMap | None
    ) -> FloatMap:
        places, beard = self._vertices, appearance["beard"]
        if not len(places.front):
            return np.zeros(0, dtype=np.float32)
        displacement = regions.FACE.sample(heights, places.face_pixels) * places.front
        if tufts is not None and beard["kind"] != "stubble":
            thick = beards.JAW.sample(tufts, places.jaw_pixels)
            length = np.float32(0.7 * beard["length_mm"] * min(1.0, beard["density"]))
            displacement += length * thick * beards.beard_mask(beard, places.beard_zones)
        return np.asarray(displacement, dtype=np.float32)

    def _soften(self, sheet: NDArray[np.uint8], pixel_mm: float) -> NDArray[np.uint8]:
        """Blur hairs to the size of a texel, so that none is lost between two."""
        sigma = max(0.3, 0.35 * self._texel_mm / pixel_mm)
        return np.asarray(cv2.GaussianBlur(sheet, (0, 0), sigma), dtype=np.uint8)


class _Places:
    """What never changes about a set of template points: where they lie on each sheet."""

    def __init__(self, position: NDArray[Any]) -> None:
        position = np.asarray(position, dtype=np.float32)
        self.front = regions.front(position)
        self.face_pixels = regions.FACE.to_pixels(position)
        self.brow_pixels = eyebrows.CANVAS.to_pixels(position)
        self.jaw_pixels = beards.JAW.to_pixels(beards.to_jaw(position))
        self.lips = regions.lip_mask(position, self.face_pixels)
        self.bare = self.front * (1 - self.lips)
        self.beard_zones = beards.beard_zones(position, self.lips)


def paint_skin(
    appearance: Appearance, seed: int, position_map: NDArray[Any], mask: NDArray[np.bool_]
) -> SkinMaps:
    """Paint one person; for many people keep a :class:`SkinPainter`, whose setting-up takes longer.

    Args:
        appearance: As :func:`sample_appearance` draws it.
        seed: Of the noise and of the single hairs, >= 0.
        position_map: ``(H, W, 3)`` float32, the template point of each texel, mm.
        mask: ``(H, W)`` bool, which texels lie on the skin.

    Returns:
        Albedo, ``(H, W, 3)``, and no displacement.
    """
    return SkinPainter(position_map, mask).paint(appearance, seed)


_NOISE_SHAPE = (256, 320)
_AXIS_Z_MM = -80.0


def _noise_pixels(position: FloatMap) -> FloatMap:
    """Cylinder around the head: azimuth to columns, height to rows; it wraps behind the head."""
    azimuth = np.arctan2(position[..., 0], position[..., 2] - np.float32(_AXIS_Z_MM))
    column = (azimuth / np.float32(2 * np.pi) + np.float32(0.5)) * (_NOISE_SHAPE[1] - 1)
    row = (np.float32(130.0) - position[..., 1]) / np.float32(340.0) * _NOISE_SHAPE[0]
    return np.stack([column, row], axis=-1).astype(np.float32)


def _fill_outside(position_map: NDArray[Any], mask: NDArray[np.bool_]) -> FloatMap:
    """Give texels beyond the mask the nearest skin's position, so that borders never bleed."""
    nearest = ndimage.distance_transform_edt(~mask, return_distances=False, return_indices=True)
    return np.ascontiguousarray(position_map[tuple(nearest)], dtype=np.float32)


def _texel_size(position: FloatMap, mask: NDArray[np.bool_]) -> float:
    """Median distance of neighbouring texels on the front of the face, mm."""
    both = mask[:, 1:] & mask[:, :-1] & (position[:, 1:, 2] > -15) & (position[:, 1:, 1] > -110)
    step = np.linalg.norm(np.diff(position, axis=1), axis=-1)[both]
    return float(np.median(step)) if step.size else 1.0


def _cover(albedo: FloatMap, colour: ArrayLike, opacity: FloatMap) -> None:
    """Paint a colour over the albedo in place, within the box that the opacity touches."""
    rows, columns = (np.flatnonzero(opacity.any(axis=axis)) for axis in (1, 0))
    if rows.size:
        box = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        part = albedo[box]
        part += (np.asarray(colour, dtype=np.float32) - part) * opacity[box][..., None]
