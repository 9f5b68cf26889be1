"""What holds for the gloss of skin, however oily it is drawn."""

import json
from functools import lru_cache

import cv2
import numpy as np
import pytest

from lrsr.identities.morphable import position_map
from lrsr.identities.skin.beard import Beard
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.sheen import _ROUGHNESS_LIMITS, Sheen, SheenPainter, sample_sheen

SIZE = 128
EVEN: Sheen = {"roughness": 0.5, "t_zone": 0.0, "lips": 0.0, "patchiness": 0.0}
SHAVEN: Beard = {
    "kind": "none", "density": 1.0, "length_mm": 3.0, "cheek_line_mm": 0.0, "shadow": 0.0,
    "patchiness": 0.0, "grey": 0.0,
}  # fmt: skip
POINTS = {
    "forehead": (0, 46, 10),
    "nose": (4, -36, 20),
    "chin": (0, -102, 6),
    "neck": (0, -140, -5),
}
NOSE, SIDE, LIP = (0.0, -40.0), (60.0, -60.0), (0.0, -80.0)


@lru_cache
def _layout() -> Layout:
    return Layout(position_map(SIZE))


@lru_cache
def _painter() -> SheenPainter:
    return SheenPainter(_layout().position, _layout().lips)


def _paint(seed: int = 0, **changes: float) -> FloatMap:
    sheen: Sheen = EVEN | changes  # type: ignore[assignment]  # the keys are the fields
    return _painter().paint(sheen, SHAVEN, np.random.default_rng(seed))


def _at(roughness: FloatMap, place: tuple[float, float]) -> float:
    points, mask = position_map(SIZE)
    near = np.linalg.norm(points[..., :2] - np.array(place), axis=-1) < 4.0
    return float(roughness[near & mask & (points[..., 2] > -60)].mean())


def _painter_of_points() -> SheenPainter:
    position = np.array(list(POINTS.values()), dtype=np.float32)[None]
    return SheenPainter(position, np.zeros(position.shape[:2], dtype=np.float32))


def _sample(seed: int = 0, age: float = 0.3) -> Sheen:
    return sample_sheen(np.random.default_rng(seed), age=age)


@pytest.mark.parametrize("age", [0.0, 1.0], ids=["young", "old"])
def test_skin_is_within_the_limits_and_noses_and_lips_are_glossier(age: float) -> None:
    people = [_sample(seed, age) for seed in range(200)]
    low, high = _ROUGHNESS_LIMITS
    assert all(low < person["roughness"] < high for person in people)
    assert all(person["t_zone"] <= 0 and person["lips"] <= 0 for person in people)
    assert all(0 < person["patchiness"] < 0.1 for person in people)


def test_lobes_are_of_the_width_that_was_measured_on_people() -> None:
    # Slopes of about 0.2 to 0.35, as Weyrich et al. 2006 are quoted in the docstring.
    alpha = np.array([_sample(seed)["roughness"] for seed in range(400)]) ** 2
    assert 0.18 < np.median(alpha) < 0.36


@pytest.mark.parametrize("name", ["roughness", "lips"])
def test_the_same_person_grows_drier_with_age(name: str) -> None:
    young, old = ([_sample(seed, age)[name] for seed in range(60)] for age in (0.0, 1.0))  # type: ignore[literal-required]
    assert all(a <= b for a, b in zip(young, old, strict=True))
    assert np.mean(young) < np.mean(old)


def test_oily_people_have_the_glossier_noses() -> None:
    people = [_sample(seed) for seed in range(200)]
    level, zone = ([person[name] for person in people] for name in ("roughness", "t_zone"))  # type: ignore[literal-required]
    assert np.corrcoef(level, zone)[0, 1] > 0.5


def test_the_same_stream_draws_the_same_sheen() -> None:
    assert _sample(7) == _sample(7)
    assert _sample(7) != _sample(8)
    assert json.loads(json.dumps(_sample(7))) == _sample(7)


def test_a_map_is_as_large_as_the_lips() -> None:
    roughness = _paint()
    assert roughness.shape == (SIZE, SIZE)
    assert roughness.dtype == np.float32


@pytest.mark.parametrize(
    "extreme",
    [{"roughness": 0.0}, {"roughness": 1.0}, {"patchiness": 5.0}, {"t_zone": -2.0}],
    ids=lambda change: next(iter(change)),
)
def test_no_texel_leaves_the_limits(extreme: dict[str, float]) -> None:
    roughness = _paint(**extreme)
    assert roughness.min() >= np.float32(_ROUGHNESS_LIMITS[0])
    assert roughness.max() <= np.float32(_ROUGHNESS_LIMITS[1])


def test_the_nose_has_the_level_that_was_asked_for() -> None:
    assert _at(_paint(roughness=0.45), NOSE) == pytest.approx(0.45, abs=1e-3)


@pytest.mark.parametrize(
    ("zone", "place", "elsewhere"), [("t_zone", NOSE, LIP), ("lips", LIP, NOSE)]
)
def test_each_zone_changes_its_place_alone(
    zone: str, place: tuple[float, float], elsewhere: tuple[float, float]
) -> None:
    plain, glossy, glossier = (_paint(**{zone: amount}) for amount in (0.0, -0.05, -0.1))
    assert _at(plain, place) > _at(glossy, place) > _at(glossier, place)
    for other in (elsewhere, SIDE):
        assert _at(glossier, other) == pytest.approx(_at(plain, other), abs=0.01)


def test_forehead_and_nose_shine_and_the_chin_does_not() -> None:
    sheen: Sheen = _sample(0, 0.3) | {"patchiness": 0.0}  # type: ignore[assignment]  # a field
    painted = _painter_of_points().paint(sheen, SHAVEN, np.random.default_rng(0))
    roughness = dict(zip(POINTS, painted[0].tolist(), strict=True))
    assert max(roughness["forehead"], roughness["nose"]) < roughness["neck"] - 0.02
    assert roughness["chin"] > roughness["neck"]


def test_nobody_is_wet_or_chalk() -> None:
    rng, painter = np.random.default_rng(0), _painter_of_points()
    people = [painter.paint(sample_sheen(rng, age=k / 99), SHAVEN, rng) for k in range(100)]
    low, high = np.float32(_ROUGHNESS_LIMITS)
    assert low <= np.min(people) < np.max(people) <= high
    assert np.std([person[0, 0] for person in people]) > 0.03


def test_the_sides_of_the_face_are_no_glossier_than_its_middle() -> None:
    assert _at(_paint(), SIDE) >= _at(_paint(), NOSE)


def test_more_patchiness_is_more_uneven() -> None:
    spread = [_paint(patchiness=amount).std() for amount in (0.0, 0.01, 0.04)]
    assert spread == sorted(spread)
    assert spread[0] < 0.02 < spread[2]


def test_the_same_stream_paints_the_same_bytes() -> None:
    np.testing.assert_array_equal(_paint(5, patchiness=0.02), _paint(5, patchiness=0.02))
    assert (_paint(5, patchiness=0.02) != _paint(6, patchiness=0.02)).any()


def test_a_tiny_map_is_painted_too() -> None:
    size = (3, 2)
    position, lips = (np.asarray(cv2.resize(m, size)) for m in (_layout().position, _layout().lips))
    painted = SheenPainter(position, lips).paint(_sample(), SHAVEN, np.random.default_rng(0))
    assert painted.shape == (2, 3)


def test_hairs_of_a_beard_do_not_shine_and_bare_cheeks_stay_as_they_were() -> None:
    bearded: Beard = {**SHAVEN, "kind": "goatee"}
    shaven, grown = (
        _painter().paint(EVEN, beard, np.random.default_rng(0)) for beard in (SHAVEN, bearded)
    )
    chin, nose = (0.0, -95.0), (0.0, -40.0)
    assert _at(grown, chin) > _at(shaven, chin) + 0.15
    assert _at(grown, nose) == _at(shaven, nose)
