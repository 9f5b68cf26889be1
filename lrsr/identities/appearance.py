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

from lrsr.identities import brows as brows_module
from lrsr.identities import regions
from lrsr.identities.brows import Brows, draw_brows, sample_brows
from lrsr.identities.canvas import FloatMap
from lrsr.identities.hair_colour import HairColour, hair_rgb, sample_hair_colour
from lrsr.identities.iris import Iris, sample_iris
from lrsr.identities.skin_tone import tone_map

_MELANIN_MEANS = np.log([0.22, 0.045, 0.022])
_MELANIN_LIMITS = (0.009, 0.32)
_BLOOD_MEAN = float(np.log(0.022))
_BLOOD_LIMITS = (0.013, 0.05)


class Complexion(TypedDict):
    """Pigments of the skin: means as volume fractions, the rest as changes of their logarithms."""

    melanin: float
    blood: float
    melanin_mottle: float
    blood_mottle: float
    cheeks: float
    nose: float
    ears: float
    lids: float
    chin: float
    forehead: float
    dark_circles: float
    tan: float


class Lips(TypedDict):
    """Natural lips by their pigments, or a lipstick's colour over them."""

    blood: float
    melanin: float
    lipstick: float
    colour: tuple[float, float, float]


class Appearance(TypedDict):
    """Everything about one person that is painted; plain numbers and names, JSON-serialisable."""

    complexion: Complexion
    lips: Lips
    brows: Brows
    hair_colour: HairColour
    iris: Iris


@dataclass(frozen=True)
class SkinMaps:
    """Painted skin.

    Attributes:
        albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, [0, 1], filled beyond the mask.
    """

    albedo: FloatMap


def sample_appearance(
    rng: Generator, *, masculinity: float, age: float, ancestry: ArrayLike
) -> Appearance:
    """Draw what a person's skin, lips, brows, hair and eyes look like.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old).
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.

    Returns:
        Plain numbers and names.
    """
    shares = np.asarray(ancestry, dtype=np.float64)
    hair_colour = sample_hair_colour(rng, age=age, ancestry=shares)
    return {
        "complexion": _sample_complexion(rng, masculinity, age, shares),
        "lips": _sample_lips(rng, masculinity),
        "brows": sample_brows(rng, masculinity=masculinity),
        "hair_colour": hair_colour,
        "iris": sample_iris(
            rng, european=float(shares[2]), eumelanin=hair_colour["eumelanin"], age=age
        ),
    }


def _sample_complexion(
    rng: Generator, masculinity: float, age: float, ancestry: NDArray[np.float64]
) -> Complexion:
    melanin = np.exp(ancestry @ _MELANIN_MEANS + rng.normal(0.0, 0.35))
    blood = np.exp(rng.normal(_BLOOD_MEAN, 0.35))
    flush = float(np.exp(rng.normal(0.0, 0.45)))
    return {
        "melanin": float(np.clip(melanin, *_MELANIN_LIMITS)),
        "blood": float(np.clip(blood, *_BLOOD_LIMITS)),
        "melanin_mottle": float(rng.uniform(0.6, 1.5)),
        "blood_mottle": float(rng.uniform(0.6, 1.5)),
        "cheeks": float(0.42 * flush * rng.uniform(0.3, 1.5)),
        "nose": float(0.38 * flush * rng.uniform(0.3, 1.4)),
        "ears": float(rng.uniform(0.15, 0.6)),
        "lids": float(rng.uniform(0.1, 0.5)),
        "chin": float(rng.uniform(0.0, 0.35)),
        "forehead": float(rng.uniform(-0.25, 0.1)),
        "dark_circles": float(np.clip(rng.normal(0.18 + 0.25 * age, 0.2), 0.0, 0.8)),
        "tan": float(rng.uniform(-0.1, 0.25)),
    }


def _sample_lips(rng: Generator, masculinity: float) -> Lips:
    made_up = rng.random() < 0.42 * (1 - masculinity) ** 2
    hue = rng.uniform(0.0, 1.0)
    red = np.array([0.36, 0.035, 0.045])
    berry = np.array([0.20, 0.03, 0.06])
    rose = np.array([0.48, 0.16, 0.16])
    shade = red + (rose - red) * hue if rng.random() < 0.7 else berry + (red - berry) * hue
    return {
        "blood": float(rng.uniform(0.7, 2.0 + 0.4 * (1 - masculinity))),
        "melanin": float(rng.uniform(0.0, 0.35)),
        "lipstick": float(rng.uniform(0.45, 0.9)) if made_up else 0.0,
        "colour": (float(shade[0]), float(shade[1]), float(shade[2])),
    }


class SkinPainter:
    """Paints the skin of any number of people into one texture layout.

    Args:
        position_map: ``(H, W, 3)`` float32, the template point of each texel, mm.
        mask: ``(H, W)`` bool, which texels lie on the skin.

    Raises:
        ValueError: The shapes disagree or the mask is empty.
    """

    def __init__(self, position_map: NDArray[Any], mask: NDArray[np.bool_]) -> None:
        if position_map.shape != (*mask.shape, 3):
            raise ValueError(
                f"position_map {position_map.shape} and mask {mask.shape} do not belong together"
            )
        if not mask.any():
            raise ValueError("the mask is empty: no texel lies on the skin")
        position = _fill_outside(position_map, mask)
        self._front = regions.front(position)
        self._face_pixels = regions.FACE.to_pixels(position)
        self._brow_pixels = brows_module.CANVAS.to_pixels(position)
        self._texel_mm = _texel_size(position, mask)
        self._noise_pixels = _noise_pixels(position)
        self._regions = regions.blood_regions(position)
        self._lips = regions.lip_mask(position, self._face_pixels)
        self._contact = regions.lip_contact(position) * self._lips
        self._nostrils = regions.nostrils(position)
        self._waterline = regions.lid_margin(self._face_pixels, 1.2) * self._front

    def paint(self, appearance: Appearance, seed: int) -> SkinMaps:
        """Paint one person.

        Args:
            appearance: As :func:`sample_appearance` draws it.
            seed: Of the noise and of the single hairs; the same seed gives the same bytes.

        Returns:
            Albedo and relief.
        """
        rng = np.random.default_rng(seed)
        albedo = self._paint_tone(appearance, rng)
        self._paint_lipstick(albedo, appearance["lips"])
        self._paint_brows(albedo, appearance, rng)
        return SkinMaps(np.clip(albedo, 0.0, 1.0))

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
        blood += np.float32(lips["blood"]) * self._lips
        melanin += np.float32(lips["melanin"]) * self._lips
        blood += np.float32(0.6) * self._waterline
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

    def _paint_lipstick(self, albedo: FloatMap, lips: Lips) -> None:
        if lips["lipstick"] > 0:
            opacity = np.float32(lips["lipstick"]) * self._lips
            opacity *= 1 - np.float32(0.4) * self._contact
            _cover(albedo, np.array(lips["colour"], dtype=np.float32), opacity)

    def _paint_brows(self, albedo: FloatMap, appearance: Appearance, rng: Generator) -> None:
        sheet = draw_brows(appearance["brows"], rng)
        sigma = 0.35 * self._texel_mm / brows_module.CANVAS.pixel_mm
        sheet = np.asarray(cv2.GaussianBlur(sheet, (0, 0), max(0.3, sigma)), dtype=np.uint8)
        opacity = brows_module.CANVAS.sample(sheet, self._brow_pixels).astype(np.float32)
        opacity *= self._front / np.float32(255)
        colour = hair_rgb(appearance["hair_colour"], darker=2.4, grey=0.35)
        colour *= min(1.0, 0.11 / float(colour.max()))
        _cover(albedo, colour, opacity)


def paint_skin(
    appearance: Appearance, seed: int, position_map: NDArray[Any], mask: NDArray[np.bool_]
) -> SkinMaps:
    """Paint one person; for many people keep a :class:`SkinPainter`, whose setting-up takes longer.

    Args:
        appearance: As :func:`sample_appearance` draws it.
        seed: Of the noise and of the single hairs.
        position_map: ``(H, W, 3)`` float32, the template point of each texel, mm.
        mask: ``(H, W)`` bool, which texels lie on the skin.

    Returns:
        Albedo and relief, ``(H, W)``.
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


def _cover(albedo: FloatMap, colour: FloatMap, opacity: FloatMap) -> None:
    """Paint a colour over the albedo in place."""
    albedo += (colour - albedo) * opacity[..., None]
