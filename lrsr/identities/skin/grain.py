"""How fine is the skin's own relief? Pores, creases and unevenness of a fraction of a millimetre.

The structures are drawn once on periodic tiles (:func:`_tiles`); every person shifts them elsewhere
and mixes them in other amounts. Amplitudes are of the order that profilometry finds on faces: 10 to
50 µm root mean square, pores 0.1 mm deep and 0.2 to 0.5 mm wide, more and larger beside the nose.
"""

from functools import lru_cache
from typing import NamedTuple, TypedDict

import cv2
import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.ramp import smoothstep
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.layout import Layout, largest_box
from lrsr.identities.skin.regions import blob

_TILE_TEXELS = 512
"""Edge of a tile in texels of a texture of 1024, 0.3 to 0.4 mm each on the face."""

_FULL_TEXTURE = 1024
_TILE_SEED = 4711


class Grain(TypedDict):
    """Relief amplitudes, mm; shares, [0, 1]; and the seed of where on the tiles a person lies."""

    pore_depth_mm: float
    pore_coarseness: float
    pore_darkness: float
    crease_mm: float
    bump_mm: float
    lip_furrow_mm: float
    place_seed: int


class _Tiles(NamedTuple):
    """Periodic structures, each ``(size, size)`` float32.

    Attributes:
        fine_pores: 0 between pores to -1 in the deepest, close together.
        coarse_pores: The same, larger and farther apart.
        creases: Net of fine furrows, mean 0, standard deviation 1.
        bumps: Unevenness of 1.5 to 4 mm, mean 0, standard deviation 1.
        specks: Noise of the size of a texel, mean 0, standard deviation 1.
    """

    fine_pores: FloatMap
    coarse_pores: FloatMap
    creases: FloatMap
    bumps: FloatMap
    specks: FloatMap


class GrainMaps(NamedTuple):
    """What grain gives to a texture, each ``(H, W)`` float32.

    Attributes:
        height: mm, outwards.
        pores: How much darker than the skin around a texel is for a pore; mean 0, at most 1.
        bumps: Unevenness for the pigments, mean 0, standard deviation 1.
        specks: The same, finer.
    """

    height: FloatMap
    pores: FloatMap
    bumps: FloatMap
    specks: FloatMap


def sample_grain(rng: Generator, *, masculinity: float, age: float) -> Grain:
    """Draw how fine or coarse a person's skin is.

    Args:
        rng: Source of randomness.
        masculinity: 0 (female) to 1 (male): larger pores.
        age: 0 (25 years) to 1 (old): larger pores, deeper creases.

    Returns:
        Plain numbers.
    """
    coarse = rng.normal(0.30 + 0.12 * masculinity + 0.15 * age, 0.22)
    return {
        "pore_depth_mm": float(np.clip(0.13 * np.exp(rng.normal(0.0, 0.4)), 0.05, 0.26)),
        "pore_coarseness": float(np.clip(coarse, 0.0, 1.0)),
        "pore_darkness": float(np.clip(0.30 * np.exp(rng.normal(0.0, 0.5)), 0.08, 0.8)),
        "crease_mm": float((0.006 + 0.032 * age) * np.exp(rng.normal(0.0, 0.35))),
        "bump_mm": float(0.018 * np.exp(rng.normal(0.6 * age, 0.35))),
        "lip_furrow_mm": float(rng.uniform(0.03, 0.12) + 0.05 * age),
        "place_seed": int(rng.integers(1 << 31)),
    }


@lru_cache(maxsize=4)
def _tiles(texture_size: int) -> _Tiles:
    """Draw the periodic structures for a texture of that size; later calls are free.

    Args:
        texture_size: Rows and columns of the texture, > 0; a coarser texture has the averages.

    Returns:
        Read-only tiles of half its size.
    """
    if texture_size != _FULL_TEXTURE:
        size = max(1, round(_TILE_TEXELS * texture_size / _FULL_TEXTURE))
        full = _tiles(_FULL_TEXTURE)
        drawn = _Tiles(*(cv2.resize(t, (size, size), interpolation=cv2.INTER_AREA) for t in full))
    else:
        rng = np.random.default_rng(_TILE_SEED)
        drawn = _Tiles(
            _pores(rng, spacing=3.4, radius=0.75),
            _pores(rng, spacing=5.6, radius=1.25),
            _creases(rng, spacing=4.2),
            _noise(rng, 2.2) + np.float32(0.6) * _noise(rng, 4.5),
            _noise(rng, 0.7),
        )
    for tile in drawn:
        tile.flags.writeable = False
    return drawn


class GrainPainter:
    """Lays the grain of any number of people over the skin within one texture layout.

    Args:
        layout: The texture.
    """

    def __init__(self, layout: Layout) -> None:
        self._size = layout.shape[0]
        at = layout.coarse
        lids = blob(at, (31.0, 2.0, 0.0), (13.0, 6.0, 20.0))
        under_eye = blob(at, (30.0, -14.0, 0.0), (13.0, 7.0, 20.0))
        cheeks = blob(at, (24.0, -36.0, 5.0), (14.0, 15.0, 30.0))
        nose = blob(at, (5.0, -40.0, 22.0), (11.0, 14.0, 18.0))
        forehead = blob(at, (0.0, 48.0, 10.0), (40.0, 22.0, 40.0))
        chin = blob(at, (0.0, -100.0, 8.0), (18.0, 12.0, 25.0))
        around_eyes = np.minimum(lids + under_eye, 1)
        skin = 1 - layout.lips
        pores = np.float32(0.16) + cheeks + nose + np.float32(0.5) * (forehead + chin)
        pores = np.minimum(pores, np.float32(1.15)) * (1 - around_eyes)
        creases = np.float32(0.6) + lids + np.float32(1.3) * under_eye + np.float32(0.6) * cheeks
        self._pores = layout.enlarge(pores) * skin
        self._creases = layout.enlarge(creases) * skin
        self._bumps = layout.enlarge(1 - np.float32(0.6) * around_eyes) * skin
        outside = np.zeros_like(layout.lips)  # the mouth's inside is an island of its own
        outside[layout.face] = layout.lips[layout.face]
        self._lip_box = largest_box(outside > 0.02)
        x, y = (layout.position[self._lip_box][..., axis] for axis in (0, 1))
        self._furrow_place = (x * (1 + np.float32(0.012) * np.abs(y + 73)) + 40) / np.float32(0.55)
        inner = smoothstep(26.0, 20.0, np.abs(x)).astype(np.float32)
        self._furrows = layout.lips[self._lip_box] * inner

    def paint(self, grain: Grain) -> GrainMaps:
        """Lay out one person's grain.

        Args:
            grain: As :func:`sample_grain` draws it.

        Returns:
            Maps of the whole texture.
        """
        rng = np.random.default_rng(grain["place_seed"])
        fine, coarse, creases, bumps, specks = (
            np.roll(tile, (rng.random(2) * tile.shape).astype(int), axis=(0, 1))
            for tile in _tiles(self._size)
        )
        share = np.float32(grain["pore_coarseness"])
        depth = (1 - share) * fine + (np.float32(0.4) + share) * coarse
        dark = depth * depth
        dark -= dark.mean()
        pores = self._lay(dark * np.float32(grain["pore_darkness"]))
        pores *= self._pores
        bumps, specks = self._lay(bumps), self._lay(specks)
        height = self._lay(depth * np.float32(grain["pore_depth_mm"]) * (np.float32(0.6) + share))
        height *= self._pores
        net = self._lay(creases * np.float32(grain["crease_mm"]))
        net *= self._creases
        height += net
        height += cv2.multiply(bumps, self._bumps, scale=grain["bump_mm"])
        self._furrow_lips(height, grain["lip_furrow_mm"], rng)
        return GrainMaps(height, pores, bumps, specks)

    def _lay(self, tile: FloatMap) -> FloatMap:
        """Repeat a tile over the texture."""
        rows, columns = self._pores.shape
        times = -(-rows // tile.shape[0]), -(-columns // tile.shape[1])
        return np.ascontiguousarray(cv2.repeat(tile, *times)[:rows, :columns])

    def _furrow_lips(self, height: FloatMap, depth_mm: float, rng: Generator) -> None:
        """Furrows run across the lips, fanning out from the middle."""
        if not self._furrow_place.size:
            return
        profile = cv2.GaussianBlur(rng.standard_normal((1, 192)).astype(np.float32), (0, 0), 1.1)
        profile /= profile.std()
        wave = cv2.remap(
            profile,
            self._furrow_place,
            np.zeros_like(self._furrow_place),
            cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_REFLECT,
        )
        height[self._lip_box] += np.float32(0.5 * depth_mm) * wave * self._furrows


def _blur(tile: FloatMap, sigma: float) -> FloatMap:
    margin = int(np.ceil(4 * sigma)) + 1
    wrapped = np.pad(tile, margin, mode="wrap")
    blurred = cv2.GaussianBlur(wrapped, (0, 0), sigma)
    return np.ascontiguousarray(blurred[margin:-margin, margin:-margin])


def _noise(rng: Generator, sigma: float) -> FloatMap:
    noise = _blur(rng.standard_normal((_TILE_TEXELS, _TILE_TEXELS), dtype=np.float32), sigma)
    return np.asarray((noise - noise.mean()) / noise.std(), dtype=np.float32)


def _points(rng: Generator, spacing: float) -> NDArray[np.float64]:
    """A jittered grid: as even as pores are, without rows."""
    count = round(_TILE_TEXELS / spacing)
    grid = np.stack(np.meshgrid(np.arange(count), np.arange(count)), axis=-1).reshape(-1, 2)
    return np.asarray((grid + rng.uniform(-0.2, 1.2, grid.shape)) * (_TILE_TEXELS / count))


def _pores(rng: Generator, *, spacing: float, radius: float) -> FloatMap:
    places = np.floor(_points(rng, spacing)).astype(int) % _TILE_TEXELS
    sheet = np.zeros((_TILE_TEXELS, _TILE_TEXELS), dtype=np.float32)
    sheet[places[:, 1], places[:, 0]] = rng.gamma(2.0, 0.5, len(places))
    sheet = _blur(sheet, radius)
    return np.asarray(-np.minimum(sheet * np.float32(2 * np.pi * radius**2 / 1.8), 1))


def _creases(rng: Generator, spacing: float) -> FloatMap:
    """Skin's net of polygons: furrows run where two of a scatter of points are equally near."""
    points = _points(rng, spacing) % _TILE_TEXELS
    tree = cKDTree(points, boxsize=_TILE_TEXELS)
    grid = np.stack(np.meshgrid(*(np.arange(_TILE_TEXELS),) * 2), axis=-1).reshape(-1, 2)
    near, next_near = tree.query(grid.astype(np.float64), k=2)[0].T
    plateau = np.minimum(next_near - near, 1.6).reshape(_TILE_TEXELS, _TILE_TEXELS)
    plateau = _blur(plateau.astype(np.float32), 0.5)
    return np.asarray((plateau - plateau.mean()) / plateau.std(), dtype=np.float32)
