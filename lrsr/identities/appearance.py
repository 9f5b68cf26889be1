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

from lrsr.identities import regions
from lrsr.identities.beard import Beard, sample_beard
from lrsr.identities.brows import Brows, sample_brows
from lrsr.identities.canvas import FloatMap
from lrsr.identities.complexion import Complexion, sample_complexion
from lrsr.identities.features import FeaturePainter
from lrsr.identities.hair_colour import HairColour, sample_hair_colour
from lrsr.identities.iris import Iris, sample_iris
from lrsr.identities.lashes import Lashes, sample_lashes
from lrsr.identities.lines import ALBEDO_PER_MM, Lines, draw_lines, sample_lines
from lrsr.identities.make_up import Lips, MakeUp, sample_lips, sample_make_up
from lrsr.identities.marks import LOG_MELANIN_PER_LEVEL, Marks, draw_marks, sample_marks
from lrsr.identities.skin_tone import tone_map


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
    lashes: Lashes


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
    child = dict(zip(Appearance.__annotations__, rng.spawn(10), strict=True))
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
        "lashes": sample_lashes(child["lashes"], masculinity=masculinity),
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
        vertices = np.zeros((0, 3)) if vertices is None else vertices
        self._texels = _Places(position)
        self._vertices = _Places(vertices)
        self._features = FeaturePainter(position, vertices, _texel_size(position, mask))
        self._noise_pixels = _noise_pixels(position)
        self._regions = regions.blood_regions(position)
        self._contact = regions.lip_contact(position) * self._texels.lips
        self._nostrils = regions.nostrils(position)
        front = self._texels.front
        self._waterline = regions.lid_margin(self._texels.face_pixels, 1.2) * front

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
        hair = appearance["hair_colour"]
        self._features.paint_make_up(albedo, appearance["make_up"])
        beard = self._features.paint_beard(albedo, appearance["beard"], hair, of_beard)
        self._features.paint_brows(albedo, appearance["brows"], hair, of_brows)
        return SkinMaps(np.clip(albedo, 0.0, 1.0), self._displace(heights, beard))

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

    def _displace(self, heights: FloatMap, beard: FloatMap) -> FloatMap:
        places = self._vertices
        if not len(places.front):
            return np.zeros(0, dtype=np.float32)
        grooves = regions.FACE.sample(heights, places.face_pixels) * places.front
        return np.asarray(grooves + beard, dtype=np.float32)


class _Places:
    """What never changes about a set of template points: where they lie on each sheet."""

    def __init__(self, position: NDArray[Any]) -> None:
        position = np.asarray(position, dtype=np.float32)
        self.front = regions.front(position)
        self.face_pixels = regions.FACE.to_pixels(position)
        self.lips = regions.lip_mask(position, self.face_pixels)
        self.bare = self.front * (1 - self.lips)


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
