import json
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray

from lrsr.identities.appearance import SkinMaps, SkinPainter, sample_appearance
from lrsr.identities.morphable import position_map, template
from lrsr.identities.skin import regions

SIZE = 256
EUROPEAN, AFRICAN = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)


@lru_cache
def _painter() -> SkinPainter:
    return SkinPainter(position_map(SIZE), template().skin)


def _person(
    seed: int = 0,
    *,
    masculinity: float = 0.2,
    age: float = 0.2,
    ancestry: ArrayLike = EUROPEAN,
    **changes: dict[str, Any],
) -> Any:
    person = sample_appearance(
        np.random.default_rng(seed), masculinity=masculinity, age=age, ancestry=ancestry
    )
    for part, values in changes.items():
        person[part] = person[part] | values
    return person


def _plain(**changes: dict[str, Any]) -> Any:
    """A person without make-up, marks, beard or much mottling."""
    plain = {
        "make_up": {"lipstick": 0.0, "eyeliner": 0.0, "eyeshadow": 0.0},
        "marks": {"moles": 0, "freckles": 0, "age_spots": 0},
        "beard": {"kind": "none", "shadow": 0.0},
        "complexion": {
            "melanin": 0.022,
            "blood": 0.022,
            "melanin_mottle": 0.2,
            "blood_mottle": 0.2,
            "tan": 0.0,
            "carotene": 0.0,
            "perioral": 0.0,
            "orbits": 0.0,
            "sides": 0.0,
            "forehead": 0.0,
        },
    }
    for part, values in changes.items():
        plain[part] = plain.get(part, {}) | values
    return _person(**plain)


def _paint(person: Any, seed: int = 0) -> SkinMaps:
    return _painter().paint(person, seed)


def _texels(centre: tuple[float, float], radius_mm: float = 4.0) -> NDArray[np.bool_]:
    points, mask = position_map(SIZE)
    near = np.linalg.norm(points[..., :2] - np.array(centre), axis=-1) < radius_mm
    return near & mask & (points[..., 2] > -50)


def _colour(
    person: Any, centre: tuple[float, float], radius_mm: float = 4.0
) -> NDArray[np.float32]:
    return _paint(person).albedo[_texels(centre, radius_mm)].mean(axis=0)


def test_the_albedo_is_a_reflectance_everywhere() -> None:
    for seed in range(6):
        person = _person(seed, masculinity=seed / 5, age=seed / 5, ancestry=np.eye(3)[seed % 3])
        maps = _paint(person, seed)
        assert maps.albedo.shape == (SIZE, SIZE, 3)
        assert maps.albedo.dtype == np.float32
        assert maps.albedo.min() >= 0
        assert maps.albedo.max() <= 1
        assert np.isfinite(maps.displacement).all()
        assert np.abs(maps.displacement).max() < 6


def test_the_same_seed_gives_the_same_bytes_whatever_was_painted_before() -> None:
    person = _person(3, masculinity=0.9)
    first = _paint(person, 5)
    _paint(_person(4), 6)
    again = _paint(person, 5)
    np.testing.assert_array_equal(first.albedo, again.albedo)
    np.testing.assert_array_equal(first.displacement, again.displacement)
    assert (first.albedo != _paint(person, 6).albedo).any()


def test_a_painter_of_ones_own_paints_the_same() -> None:
    person = _person(3)
    alone = SkinPainter(position_map(SIZE), template().skin[:7]).paint(person, 5)
    np.testing.assert_array_equal(alone.albedo, _paint(person, 5).albedo)
    assert alone.displacement.shape == (7,)


def test_forehead_has_the_tone_that_was_asked_for() -> None:
    fair = _colour(_plain(), (0.0, 45.0), 15.0)
    dark = _colour(_plain(complexion=_plain()["complexion"] | {"melanin": 0.25}), (0.0, 45.0), 15.0)
    assert fair == pytest.approx([0.48, 0.29, 0.22], rel=0.15)
    assert (dark < 0.6 * fair).all()


def test_lips_are_redder_than_the_chin_and_end_at_their_border() -> None:
    person = _plain()
    lip, chin = _colour(person, (0.0, -78.0), 3.0), _colour(person, (0.0, -98.0), 5.0)
    assert lip[0] / lip[1] > 1.15 * chin[0] / chin[1]
    above = _colour(person, (0.0, -60.0), 1.5)
    assert above[0] / above[1] < 1.1 * chin[0] / chin[1]


def test_lipstick_has_its_own_colour() -> None:
    red = {"lipstick": 0.9, "lipstick_colour": (0.4, 0.03, 0.04)}
    person = _plain(make_up=red)
    assert _colour(person, (0.0, -79.0), 2.0) == pytest.approx([0.4, 0.04, 0.05], abs=0.06)


def test_brows_are_darker_than_the_skin_around_and_lie_above_the_eyes() -> None:
    person = _plain(
        brows={"thickness_mm": 7.0, "density": 2.0, "height_mm": 0.0},
        hair_colour={"eumelanin": 6.0, "grey": 0.0},
    )
    brow, above = _colour(person, (28.0, 17.0), 2.5), _colour(person, (28.0, 34.0), 3.0)
    assert (brow < 0.5 * above).all()


def test_a_dark_beard_darkens_and_thickens_the_chin() -> None:
    bare = _plain()
    person = _plain(
        beard={"kind": "full", "density": 1.2, "length_mm": 4.0, "patchiness": 0.0},
        hair_colour={"eumelanin": 6.0, "grey": 0.0},
    )
    assert (_colour(person, (0.0, -104.0)) < 0.6 * _colour(bare, (0.0, -104.0))).all()
    chin = np.linalg.norm(template().skin - (0.0, -104.0, 8.0), axis=1) < 12
    assert _paint(person).displacement[chin].mean() > 1.0
    assert np.abs(_paint(bare).displacement[chin]).max() < 0.5


def test_stubble_and_its_shadow_are_bluer_than_skin() -> None:
    bare, shaven = _plain(), _plain(beard={"kind": "none", "shadow": 0.9})
    shaven["hair_colour"]["eumelanin"] = 6.0
    plain, blue = _colour(bare, (45.0, -85.0)), _colour(shaven, (45.0, -85.0))
    assert blue[2] / blue[0] > 1.08 * plain[2] / plain[0]
    assert blue.sum() < plain.sum()


def _smooth() -> dict[str, float]:
    lines = sample_appearance(
        np.random.default_rng(0), masculinity=0.2, age=0.2, ancestry=EUROPEAN
    )["lines"]
    kept = ("paths_seed", "forehead_count")
    return {name: value if name in kept else 0.0 for name, value in lines.items()}


def test_deep_lines_lower_mesh_and_map_and_darken_the_skin() -> None:
    young, old = _plain(lines=_smooth()), _plain(lines=_smooth() | {"nasolabial": 1.0})
    assert _paint(young).displacement.min() == 0
    assert -1.3 < _paint(old).displacement.min() < -0.3
    fold = _texels((28.0, -57.0), 4.0)
    assert (_paint(old).height - _paint(young).height)[fold].min() < -0.1
    darker, fairer = (_paint(person).albedo.sum(axis=-1)[fold] for person in (old, young))
    assert 0.6 < (darker / fairer).min() < 0.95
    assert (darker / fairer).mean() > 0.9


def test_maps_of_relief_and_sheen_are_physical() -> None:
    maps = [_paint(_person(seed, age=0.9), seed) for seed in range(3)]
    cheek = _texels((40.0, -40.0), 10.0)
    for painted in maps:
        assert painted.height.shape == (SIZE, SIZE)
        assert np.abs(painted.height).max() < 1.5
        assert 0.002 < painted.height[cheek].std() < 0.12
        assert painted.roughness.min() > 0.25
        assert painted.roughness.max() < 0.8
    assert np.abs(maps[0].height - maps[1].height)[cheek].mean() > 0.003


def test_nothing_of_the_face_shows_on_the_back_of_the_head() -> None:
    lined = _plain(lines={"forehead": 1.0}, brows={"density": 2.0})
    smooth = _plain(lines={"forehead": 0.0}, brows={"density": 0.4})
    points, mask = position_map(SIZE)
    behind = mask & (points[..., 2] < -90)
    np.testing.assert_array_equal(_paint(lined).albedo[behind], _paint(smooth).albedo[behind])


def test_the_texture_continues_beyond_the_mask() -> None:
    albedo, (_, mask) = _paint(_plain()).albedo, position_map(SIZE)
    assert not mask.all()
    assert albedo[~mask].min() > 0.02


def test_neighbours_across_the_back_of_the_head_agree() -> None:
    points, mask = position_map(SIZE)
    behind = mask & (np.abs(points[..., 0]) < 3) & (points[..., 2] < -120) & (points[..., 1] > 0)
    albedo, side = _paint(_plain()).albedo, points[..., 0] > 0
    left, right = (albedo[behind & half].mean(axis=0) for half in (side, ~side))
    assert left == pytest.approx(right, rel=0.05)


def test_appearances_are_plain_and_follow_the_person() -> None:
    rng = np.random.default_rng(0)

    def draw(**person: Any) -> list[Any]:
        drawn = {"masculinity": 0.5, "age": 0.3, "ancestry": EUROPEAN} | person
        return [sample_appearance(rng, **drawn) for _ in range(60)]

    fair, dark = draw(), draw(ancestry=AFRICAN)
    assert json.loads(json.dumps(fair)) == fair
    melanin = [
        np.mean([person["complexion"]["melanin"] for person in group]) for group in (fair, dark)
    ]
    assert melanin[1] > 5 * melanin[0]
    assert all(person["hair_colour"]["eumelanin"] > 2 for person in dark)


def test_lines_come_a_decade_later_to_dark_skin() -> None:
    def lines(seed: int, age: float, ancestry: Any) -> tuple[float, float]:
        rng = np.random.default_rng(seed)
        person = sample_appearance(rng, masculinity=0.1, age=age, ancestry=ancestry)
        return person["complexion"]["melanin"], person["lines"]["crows_feet"]

    drawn = [[lines(seed, 0.35, shares) for seed in range(40)] for shares in (AFRICAN, EUROPEAN)]
    fair = [lines(seed, 0.15, EUROPEAN) for seed in range(40)]
    shaded = [seed for seed, (melanin, _) in enumerate(drawn[0]) if melanin > 0.12]
    assert len(shaded) > 10
    for seed in shaded:
        assert drawn[0][seed][1] == pytest.approx(fair[seed][1])
        assert drawn[0][seed][1] < drawn[1][seed][1]


def test_the_same_stream_draws_the_same_person_and_age_only_thins_the_brows() -> None:
    assert _person(7) == _person(7)
    assert _person(7) != _person(8)
    old, young = _person(7, age=0.9)["brows"], _person(7, age=0.1)["brows"]
    assert {**old, "density": 0.0} == {**young, "density": 0.0}
    assert old["density"] < young["density"]


def test_a_beard_leaves_the_brows_hairs_where_they_were() -> None:
    bare, bearded = _plain(), _plain(beard={"kind": "full"})
    brow = _texels((28.0, 16.0), 8.0)
    np.testing.assert_array_equal(_paint(bare).albedo[brow], _paint(bearded).albedo[brow])


def test_two_people_differ_more_than_two_paintings_of_one() -> None:
    one, other = _person(1), _person(2)
    face = _texels((0.0, -20.0), 70.0)
    same = np.abs(_paint(one, 0).albedo - _paint(one, 1).albedo)[face].mean()
    different = np.abs(_paint(one, 0).albedo - _paint(other, 0).albedo)[face].mean()
    assert different > 1.5 * same


def test_lip_texels_follow_the_outline_of_the_template() -> None:
    points, _ = position_map(SIZE)
    lips = regions.lip_mask(points, regions.FACE.to_pixels(points)) > 0.5
    rows = points[lips]
    assert rows[:, 1].max() < -61
    assert rows[:, 1].min() > -88
    assert np.abs(rows[:, 0]).max() < 28
