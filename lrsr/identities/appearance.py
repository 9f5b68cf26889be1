"""What does a person's skin look like? Pigments, lips, brows, beard, marks and lines as textures.

:func:`sample_appearance` draws plain numbers, :class:`SkinPainter` turns them into a linear albedo,
a relief and a sheen. Everything is drawn on the template head and reaches the texture through its
position map.
"""

from typing import NamedTuple, TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.face.iris import Iris, sample_iris
from lrsr.identities.face.lashes import Lashes, sample_lashes
from lrsr.identities.ramp import smoothstep
from lrsr.identities.shape.position_map import PositionMap
from lrsr.identities.skin import regions
from lrsr.identities.skin.beard import Beard, sample_beard
from lrsr.identities.skin.brows import Brows, sample_brows
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.complexion import Complexion, sample_complexion
from lrsr.identities.skin.features import FeaturePainter
from lrsr.identities.skin.grain import Grain, GrainPainter, sample_grain
from lrsr.identities.skin.hair_colour import HairColour, sample_hair_colour
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.lines import Lines, draw_lines, sample_lines
from lrsr.identities.skin.make_up import Lips, MakeUp, sample_lips, sample_make_up
from lrsr.identities.skin.marks import Marks, sample_marks
from lrsr.identities.skin.pigments import PigmentPainter
from lrsr.identities.skin.relief import split_heights
from lrsr.identities.skin.shading import Shading, ShadingPainter, sample_shading
from lrsr.identities.skin.sheen import Sheen, SheenPainter, sample_sheen

_SHADING_MELANIN = (0.04, 0.12)
"""Melanin, a volume fraction, from which skin shades itself, and with which it does so fully."""
_SHADE_DELAY = 0.2
"""How much later lines and folds come to such skin, as a share of 25 to 75 years: a decade (Vashi
et al., J. Clin. Aesthet. Dermatol. 9, 2016: the sun draws most of them)."""


class _Appearance(TypedDict):
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
    grain: Grain
    sheen: Sheen
    shading: Shading


class SkinMaps(NamedTuple):
    """Painted skin.

    Attributes:
        albedo: ``(H, W, 3)`` float32, linear sRGB reflectance, [0, 1], filled beyond the mask.
        height: ``(H, W)`` float32, mm outwards: pores, creases and what of the lines is too fine
            for the mesh.
        roughness: ``(h, w)`` float32, of the specular reflection, [0, 1]; coarser than the albedo.
        displacement: ``(V,)`` float32, mm along the normal of each vertex that the painter knows:
            grooves below, beards above the skin.
    """

    albedo: FloatMap
    height: FloatMap
    roughness: FloatMap
    displacement: FloatMap


def sample_appearance(
    rng: Generator,
    *,
    masculinity: float,
    age: float,
    ancestry: ArrayLike,
) -> _Appearance:
    """Draw what a person's skin, lips, brows, beard and eyes look like.

    Args:
        rng: Source of randomness; every trait gets a child of its own, so that a change to one of
            them leaves the others as they were.
        masculinity: 0 (female) to 1 (male).
        age: 0 (25 years) to 1 (old); dark skin is weathered by a decade less.
        ancestry: ``(3,)`` shares of African, Asian and European ancestry, summing to 1.

    Returns:
        Plain numbers and names.
    """
    shares = np.asarray(ancestry, dtype=np.float64)
    asian, european = float(shares[1]), float(shares[2])
    child = dict(zip(_Appearance.__annotations__, rng.spawn(13), strict=True))
    hair = sample_hair_colour(
        child["hair_colour"], age=age, ancestry=shares, masculinity=masculinity
    )
    complexion = sample_complexion(
        child["complexion"], masculinity=masculinity, age=age, ancestry=shares
    )
    shaded = float(smoothstep(*_SHADING_MELANIN, np.asarray(complexion["melanin"])))
    weathered = max(0.0, age - _SHADE_DELAY * shaded)
    return {
        "complexion": complexion,
        "lips": sample_lips(child["lips"], masculinity=masculinity, melanin=complexion["melanin"]),
        "make_up": sample_make_up(child["make_up"], masculinity=masculinity, age=age),
        "marks": sample_marks(child["marks"], melanin=complexion["melanin"], age=age),
        "lines": sample_lines(child["lines"], age=weathered, masculinity=masculinity),
        "brows": sample_brows(child["brows"], masculinity=masculinity, age=age),
        "beard": sample_beard(
            child["beard"], masculinity=masculinity, asian=asian, grey=hair["grey"]
        ),
        "hair_colour": hair,
        "iris": sample_iris(child["iris"], european=european, eumelanin=hair["eumelanin"], age=age),
        "lashes": sample_lashes(child["lashes"], masculinity=masculinity),
        "grain": sample_grain(child["grain"], masculinity=masculinity, age=weathered),
        "sheen": sample_sheen(child["sheen"], age=age),
        "shading": sample_shading(child["shading"], masculinity=masculinity, age=weathered),
    }


class SkinPainter:
    """Paints the skin of any number of people into one texture layout.

    Args:
        chart: The template point of each texel.
        vertices: ``(V, 3)``, the template's vertices that will be displaced, mm.
    """

    def __init__(self, chart: PositionMap, vertices: NDArray[np.floating]) -> None:
        self._layout = layout = Layout(chart)
        self._pigments = PigmentPainter(layout)
        self._grain = GrainPainter(layout)
        self._shading = ShadingPainter(layout)
        size = layout.coarse.shape[1::-1]
        lips = cv2.resize(layout.lips, size, interpolation=cv2.INTER_AREA)
        self._sheen = SheenPainter(layout.coarse, np.asarray(lips))
        vertices = np.asarray(vertices, dtype=np.float32)
        self._features = FeaturePainter(layout, vertices)
        self._vertex_pixels = regions.FACE.to_pixels(vertices)
        self._vertex_front = regions.front(vertices)

    def paint(self, appearance: _Appearance, seed: int) -> SkinMaps:
        """Paint one person.

        Args:
            appearance: As :func:`sample_appearance` draws it.
            seed: Of the noise and of the single hairs, >= 0; the same seed gives the same bytes.

        Returns:
            Albedo, relief and sheen.
        """
        of_tone, of_beard, of_brows, of_sheen, of_shading = np.random.default_rng(seed).spawn(5)
        layout, hair = self._layout, appearance["hair_colour"]
        lines = draw_lines(appearance["lines"], regions.FACE)
        coarse, fine = split_heights(lines, regions.FACE.pixel_mm)
        groove = regions.FACE.sample(fine, layout.face_pixels)
        groove *= layout.front
        grain = self._grain.paint(appearance["grain"])
        albedo = self._pigments.paint(
            appearance["complexion"],
            appearance["lips"],
            appearance["marks"],
            grain,
            groove,
            of_tone,
        )
        self._shading.paint(albedo, appearance["shading"], of_shading)
        grain.height[layout.face] += groove
        self._features.paint_make_up(albedo, appearance["make_up"])
        self._features.paint_lash_lines(albedo, appearance["lashes"])
        beard = self._features.paint_beard(albedo, appearance["beard"], hair, of_beard)
        self._features.paint_brows(albedo, appearance["brows"], hair, of_brows)
        np.clip(albedo, 0.0, 1.0, out=albedo)
        roughness = self._sheen.paint(appearance["sheen"], appearance["beard"], of_sheen)
        grooves = regions.FACE.sample(coarse, self._vertex_pixels) * self._vertex_front
        displacement = np.asarray(grooves + beard, dtype=np.float32)
        return SkinMaps(albedo, grain.height, roughness, displacement)
