import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.morphable import position_map
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.shading import Shading, ShadingPainter, sample_shading

SIZE = 256
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


@pytest.fixture(scope="module")
def layout() -> Layout:
    return Layout(position_map(SIZE))


@pytest.fixture(scope="module")
def painter(layout: Layout) -> ShadingPainter:
    return ShadingPainter(layout)


def usual(**changes: float) -> Shading:
    """Somebody who is like everybody: no deviation anywhere."""
    people = [
        sample_shading(np.random.default_rng(seed), masculinity=1.0, age=0.3) for seed in range(400)
    ]
    mean = {
        name: float(np.mean([one["left"][name] for one in people])) for name in people[0]["left"]
    }
    return {
        "depth": changes.get("depth", 1.0),
        "below_nose": changes.get("below_nose", 0.0),
        "unevenness": changes.get("unevenness", 0.0),
        "left": mean,
        "right": mean,
    }


def shade(painter: ShadingPainter, layout: Layout, shading: Shading) -> NDArray[np.float64]:
    """Paint a grey skin; return the logarithm of what luminance was multiplied by."""
    albedo = np.full((*layout.shape, 3), 0.3, dtype=np.float32)
    painter.paint(albedo, shading, np.random.default_rng(0))
    return np.log(albedo @ LUMINANCE / 0.3)


def around(layout: Layout, x: float, y: float, reach: float = 3.0) -> NDArray[np.bool_]:
    """Texels near a point of the template and its mirror image."""
    position = layout.position
    away = np.hypot(np.abs(position[..., 0]) - x, position[..., 1] - y)
    near = np.zeros(layout.shape, dtype=bool)
    near[layout.face] = ((away < reach) & (position[..., 2] > -25.0))[layout.face]
    return near


@pytest.mark.parametrize(
    ("place", "x", "y", "low", "high"),
    [
        # docs/people.md: albedos of photographs minus ours, at places between features.
        # Pictures of both beside the cheeks: a photograph's forehead is 0.1 to 0.2 lighter, ours
        # was 0.4.
        ("forehead", 0.0, 29.0, -0.20, -0.02),
        ("inner corner of the eye", 22.0, -1.0, -0.90, -0.40),
        ("outer corner of the eye", 41.0, -1.0, -1.00, -0.55),
        ("flank of the nose", 8.0, -7.0, -0.40, -0.10),
        ("ridge of the nose", 0.0, -37.0, 0.05, 0.30),
        ("below the nose", 2.0, -52.0, -0.80, -0.30),
        ("nasolabial fold", 32.0, -61.0, -0.70, -0.30),
        ("apple of the cheek", 34.0, -37.0, 0.05, 0.25),
    ],
)
def test_a_place_is_as_much_darker_or_lighter_as_photographs_show(
    painter: ShadingPainter, layout: Layout, place: str, x: float, y: float, low: float, high: float
) -> None:
    change = shade(painter, layout, usual())
    assert low < change[around(layout, x, y)].mean() < high, place


def test_nostrils_are_dark_and_what_lies_before_them_is_not(
    painter: ShadingPainter, layout: Layout
) -> None:
    """Albedos of photographs: the darkest fifth of a nostril has -0.96 against the cheeks."""
    change, depth = shade(painter, layout, usual()), layout.position[..., 2]
    place = around(layout, 9.5, -45.0, 4.0)
    inside, before = change[place & (depth < 19.0)], change[place & (depth > 22.0)]
    assert np.quantile(inside, 0.2) < -0.9
    assert before.mean() > -0.35


def test_no_depth_leaves_plain_skin_as_it_is(painter: ShadingPainter, layout: Layout) -> None:
    change = shade(painter, layout, usual(depth=0.0))
    cheek = around(layout, 48.0, -30.0)
    np.testing.assert_allclose(change[cheek], 0.0, atol=0.01)


def test_nothing_behind_the_temples_is_shaded(painter: ShadingPainter, layout: Layout) -> None:
    change = shade(painter, layout, usual(unevenness=2.0))
    np.testing.assert_allclose(change[layout.position[..., 2] < -64.0], 0.0, atol=1e-6)


def test_what_only_one_side_has_is_painted_there(painter: ShadingPainter, layout: Layout) -> None:
    person = usual(depth=0.0)
    deeper: Shading = {**person, "left": {**person["left"], "apple": -0.5}}
    change = shade(painter, layout, deeper) - shade(painter, layout, person)
    apple = around(layout, 34.0, -37.0)
    left = layout.position[..., 0] < 0.0
    assert change[apple & left].mean() < -0.3
    np.testing.assert_allclose(change[apple & ~left], 0.0, atol=1e-6)


def test_lids_nose_and_mouth_are_less_even_than_plain_skin(
    painter: ShadingPainter, layout: Layout
) -> None:
    plain = usual(depth=0.0)
    change = shade(painter, layout, {**plain, "unevenness": 1.0}) - shade(painter, layout, plain)
    cheek = change[around(layout, 42.0, -25.0, 12.0)].std()
    # Albedos of photographs: 0.032 to 0.053 an octave on plain skin from 2 to 16 mm.
    assert 0.02 < cheek < 0.09
    assert change[around(layout, 10.0, -44.0, 9.0)].std() > 1.5 * cheek


def test_a_woman_has_no_shadow_of_a_beard(painter: ShadingPainter, layout: Layout) -> None:
    woman, man = (
        sample_shading(np.random.default_rng(0), masculinity=masculinity, age=0.0)
        for masculinity in (0.0, 1.0)
    )
    assert woman["below_nose"] < -1.0
    assert man["below_nose"] == 0.0
    same = usual()
    lighter = shade(painter, layout, {**same, "below_nose": woman["below_nose"]})
    lighter = lighter - shade(painter, layout, same)
    assert lighter[around(layout, 8.0, -60.0)].mean() > 0.1
    np.testing.assert_allclose(lighter[around(layout, 30.0, -10.0)], 0.0, atol=1e-6)


def test_shadows_are_redder_than_the_skin(painter: ShadingPainter, layout: Layout) -> None:
    albedo = np.full((*layout.shape, 3), 0.3, dtype=np.float32)
    painter.paint(albedo, usual(), np.random.default_rng(0))
    red, green, blue = albedo[around(layout, 32.0, -61.0)].mean(axis=0)
    assert red > green > blue


def test_people_differ_and_the_same_stream_gives_the_same() -> None:
    one, again, other = (
        sample_shading(np.random.default_rng(s), masculinity=0.5, age=0.4) for s in (1, 1, 2)
    )
    assert one == again
    assert one != other


def test_folds_deepen_with_age() -> None:
    depths = [
        np.mean(
            [
                sample_shading(np.random.default_rng(s), masculinity=0.5, age=age)["depth"]
                for s in range(200)
            ]
        )
        for age in (0.0, 1.0)
    ]
    assert depths[1] > depths[0] + 0.2
