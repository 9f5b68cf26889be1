"""What holds for skin's fine relief, however deep its pores are drawn."""

import json
from functools import lru_cache

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.morphable import position_map
from lrsr.identities.shape.position_map import PositionMap
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.grain import (
    _FULL_TEXTURE,
    _TILE_TEXELS,
    Grain,
    GrainMaps,
    GrainPainter,
    _Tiles,
    _tiles,
    sample_grain,
)
from lrsr.identities.skin.layout import Layout

SIZE = 256
NONE: Grain = {
    "pore_depth_mm": 0.0,
    "pore_coarseness": 0.4,
    "pore_darkness": 0.0,
    "crease_mm": 0.0,
    "bump_mm": 0.0,
    "lip_furrow_mm": 0.0,
    "place_seed": 1,
}
AMOUNTS = ("pore_depth_mm", "crease_mm", "bump_mm", "lip_furrow_mm")


@lru_cache
def _layout() -> Layout:
    return Layout(position_map(SIZE))


@lru_cache
def _painter() -> GrainPainter:
    return GrainPainter(_layout())


def _paint(**changes: float) -> GrainMaps:
    return _painter().paint(NONE | changes)  # type: ignore[arg-type]  # the keys are the fields


def _sample(seed: int = 0, *, masculinity: float = 0.5, age: float = 0.3) -> Grain:
    return sample_grain(np.random.default_rng(seed), masculinity=masculinity, age=age)


def _near(x: float, y: float, radius_mm: float) -> NDArray[np.bool_]:
    points, mask = position_map(SIZE)
    near = np.hypot(points[..., 0] - x, points[..., 1] - y) < radius_mm
    return near & mask & (points[..., 2] > -50)


@pytest.mark.parametrize("age", [0.0, 1.0], ids=["young", "old"])
@pytest.mark.parametrize("masculinity", [0.0, 1.0], ids=["woman", "man"])
def test_amounts_are_those_of_skin(age: float, masculinity: float) -> None:
    people = [_sample(seed, masculinity=masculinity, age=age) for seed in range(200)]
    for name in AMOUNTS:
        drawn = [person[name] for person in people]  # type: ignore[literal-required]  # a field
        assert min(drawn) > 0
        assert max(drawn) < 0.5  # mm
    for name in ("pore_coarseness", "pore_darkness"):
        drawn = [person[name] for person in people]  # type: ignore[literal-required]
        assert min(drawn) >= 0
        assert max(drawn) <= 1


@pytest.mark.parametrize("name", ["crease_mm", "bump_mm", "lip_furrow_mm", "pore_coarseness"])
def test_the_same_person_grows_coarser_with_age(name: str) -> None:
    ages = [_sample(4, age=age) for age in (0.0, 0.3, 0.6, 1.0)]
    grown = [person[name] for person in ages]  # type: ignore[literal-required]  # a field
    assert grown == sorted(grown)
    assert grown[0] < grown[-1]


def test_men_have_coarser_pores_and_nothing_else() -> None:
    woman, man = (_sample(4, masculinity=masculinity) for masculinity in (0.0, 1.0))
    assert man["pore_coarseness"] > woman["pore_coarseness"]
    assert man | {"pore_coarseness": 0.0} == woman | {"pore_coarseness": 0.0}


def test_the_same_stream_draws_the_same_grain() -> None:
    assert _sample(7) == _sample(7)
    assert _sample(7) != _sample(8)


def test_a_sample_survives_json() -> None:
    assert json.loads(json.dumps(_sample())) == _sample()


@pytest.mark.parametrize("size", [64, 256, _FULL_TEXTURE])
def test_tiles_are_half_the_texture(size: int) -> None:
    assert [tile.shape for tile in _tiles(size)] == [(size // 2, size // 2)] * 5
    assert all(tile.dtype == np.float32 for tile in _tiles(size))


def test_tiles_are_what_their_names_say() -> None:
    full = _tiles(_FULL_TEXTURE)
    for pores in (full.fine_pores, full.coarse_pores):
        assert pores.min() == pytest.approx(-1.0, abs=0.01)
        assert pores.max() == pytest.approx(0.0, abs=0.01)
    for even in (full.creases, full.bumps, full.specks):
        assert even.mean() == pytest.approx(0.0, abs=0.01)
    for even in (full.creases, full.specks):
        assert even.std() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("name", _Tiles._fields)
def test_a_tile_goes_on_beyond_its_edge(name: str) -> None:
    tile = getattr(_tiles(_FULL_TEXTURE), name)
    for axis in (0, 1):
        steps = np.abs(np.diff(tile, axis=axis, append=tile.take([0], axis)))
        over_edge = steps.take(_TILE_TEXELS - 1, axis).mean()
        assert over_edge == pytest.approx(steps.mean(), rel=0.25)


def test_a_coarser_texture_has_the_averages() -> None:
    blocks = _tiles(_FULL_TEXTURE).creases.reshape(128, 4, 128, 4).mean(axis=(1, 3))
    np.testing.assert_allclose(_tiles(_FULL_TEXTURE // 4).creases, blocks, atol=1e-5)


def test_tiles_are_drawn_once_and_cannot_be_spoilt() -> None:
    assert _tiles(128) is _tiles(128)
    for size in (128, _FULL_TEXTURE):
        with pytest.raises(ValueError, match="read-only"):
            _tiles(size).creases[0, 0] = 1.0


def test_maps_cover_the_texture() -> None:
    for grain in _painter().paint(_sample()):
        assert grain.shape == (SIZE, SIZE)
        assert grain.dtype == np.float32
        assert np.isfinite(grain).all()


def test_no_amount_is_no_relief() -> None:
    maps = _paint()
    assert not maps.height.any()
    assert not maps.pores.any()


@pytest.mark.parametrize("name", AMOUNTS)
def test_twice_the_amount_is_twice_the_relief(name: str) -> None:
    once, twice = (_paint(**{name: amount}).height for amount in (0.05, 0.1))
    assert once.any()
    np.testing.assert_allclose(twice, 2 * once, atol=1e-6)


def test_darker_pores_darken_and_lower_nothing() -> None:
    faint, dark = (_paint(pore_darkness=amount).pores for amount in (0.2, 0.8))
    np.testing.assert_allclose(dark, 4 * faint, atol=1e-6)
    assert dark.max() <= 1
    assert not _paint(pore_darkness=0.8).height.any()


def test_pores_are_dents() -> None:
    assert _paint(pore_depth_mm=0.2).height.max() <= 0


def test_lips_have_furrows_and_no_pores() -> None:
    lips = _near(0.0, -80.0, 3.0)
    assert (_layout().lips[lips] == 1).all()
    cheek = _near(30.0, -45.0, 6.0)
    pores, furrows = _paint(pore_depth_mm=0.2).height, _paint(lip_furrow_mm=0.2).height
    assert not pores[lips].any()
    assert pores[cheek].any()
    assert furrows[lips].any()
    assert not furrows[cheek].any()


def test_the_same_grain_is_the_same_bytes() -> None:
    first = _painter().paint(_sample(3))
    _painter().paint(_sample(4))
    for one, again in zip(first, _painter().paint(_sample(3)), strict=True):
        np.testing.assert_array_equal(one, again)


def test_everyone_lies_elsewhere_on_the_tiles() -> None:
    one, other = (_paint(bump_mm=0.02, place_seed=seed).height for seed in (1, 2))
    cheek = _near(30.0, -45.0, 12.0)
    assert np.corrcoef(one[cheek], other[cheek])[0, 1] < 0.5
    assert one[cheek].std() == pytest.approx(other[cheek].std(), rel=0.5)


@pytest.mark.parametrize("size", [64, 128])
def test_a_small_texture_has_its_grain_too(size: int) -> None:
    maps = GrainPainter(Layout(position_map(size))).paint(_sample())
    assert maps.height.shape == (size, size)
    assert maps.height.any()


def test_a_layout_without_lips_has_no_furrows() -> None:
    points, mask = position_map(64)
    above: FloatMap = np.asarray(cv2.add(points, (0.0, 300.0, 0.0, 0.0)))
    layout = Layout(PositionMap(above, mask))
    assert not layout.lips.any()
    painted = GrainPainter(layout).paint(NONE | {"lip_furrow_mm": 0.2})  # type: ignore[typeddict-item]
    assert not painted.height.any()
