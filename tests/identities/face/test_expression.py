import json
from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import EXPRESSIONS
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL, Expression, _known_units
from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import draw_triangles
from lrsr.presets import preset

SEEDS = (3, 8)


def made(seed: int, expression: Expression = NEUTRAL) -> Head:
    return sample_head(seed, texture_size=64, expression=expression)


@pytest.fixture(scope="module")
def heads() -> Mapping[tuple[int, str], Head]:
    wanted = ("neutral", "smile", "mouth_open", "blink", "grin")
    return {(seed, name): made(seed, EXPRESSIONS[name]) for seed in SEEDS for name in wanted}


def seen_vertices(head: Head, which: int) -> NDArray[np.bool_]:
    """Tell which vertices of an eyeball no skin hides from in front: a small depth buffer."""
    size, half_mm = 320, 16.0
    skin, eye = head.part("skin"), head.part(("left_eye", "right_eye")[which])
    centre = head.pupils[which, :2]
    points = skin.vertices.astype(np.float64)
    near = (np.abs(points[:, :2] - centre) < half_mm + 6).all(axis=1) & (points[:, 2] > -30)
    faces = skin.faces[near[skin.faces].all(axis=1)]
    faces = faces[np.argsort(points[faces].mean(axis=1)[:, 2])]  # the nearest is drawn last
    depth, mask = draw_triangles(
        (points[:, :2] - centre) / (2 * half_mm) + 0.5, faces, points[:, 2:], size
    )
    ball = eye.vertices.astype(np.float64)
    place = ((ball[:, :2] - centre) / (2 * half_mm) + 0.5) * size - 0.5
    column, row = np.clip(np.rint(place).astype(int), 0, size - 1).T
    hidden = mask[row, column] & (depth[row, column, 0] > ball[:, 2])
    return np.asarray(~hidden & (np.abs(ball[:, :2] - centre) < half_mm).all(axis=1))


def corners(head: Head) -> NDArray[np.float64]:
    return head.landmarks[3:]


def test_a_unit_without_a_side_moves_both() -> None:
    assert Expression("smile", {"mouthSmile": 0.5}).units == {
        "mouthSmileLeft": 0.5,
        "mouthSmileRight": 0.5,
    }


def test_all_units_are_those_of_arkit_but_gaze_and_tongue() -> None:
    # Apple, ARFaceAnchor.BlendShapeLocation: 52 of them; 8 turn the eyes, one puts out the tongue.
    single = [unit for unit, sides in _known_units().items() if sides == (unit,)]
    assert len(single) == 52 - 8 - 1
    assert {"jawOpen", "cheekPuff", "eyeBlinkLeft"} <= set(single)


def test_a_unit_goes_its_share_of_the_way_to_the_end() -> None:
    basis = load_basis()
    resting = np.zeros(len(basis.names))
    column = basis.column["unit/jawOpen"]
    resting[column] = 0.2
    acting = Expression("half", {"jawOpen": 0.5}).act(basis, resting)
    assert acting[column] == pytest.approx(0.6)
    assert np.delete(acting, column).tolist() == np.delete(resting, column).tolist()


def test_neutral_is_no_expression_bit_for_bit() -> None:
    plain, neutral = sample_head(3, texture_size=64), made(3, Expression("x", {"jawOpen": 0.0}))
    for mine, theirs in zip(plain.parts, neutral.parts, strict=True):
        np.testing.assert_array_equal(mine.vertices, theirs.vertices)
        np.testing.assert_array_equal(mine.albedo, theirs.albedo)
    np.testing.assert_array_equal(plain.landmarks, neutral.landmarks)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_smile_raises_and_parts_the_corners_of_the_mouth(
    heads: Mapping[tuple[int, str], Head], seed: int
) -> None:
    rest, smile = corners(heads[seed, "neutral"]), corners(heads[seed, "smile"])
    assert (smile[:, 1] > rest[:, 1] + 1).all()
    assert smile[1, 0] - smile[0, 0] > rest[1, 0] - rest[0, 0] + 1


@pytest.mark.parametrize("seed", SEEDS)
def test_an_opened_mouth_lowers_the_chin_and_keeps_nose_and_pupils(
    heads: Mapping[tuple[int, str], Head], seed: int
) -> None:
    rest, opened = heads[seed, "neutral"], heads[seed, "mouth_open"]
    down = rest.part("skin").vertices[:, 1] - opened.part("skin").vertices[:, 1]
    assert 4 < down.max() < 15
    np.testing.assert_array_equal(opened.pupils, rest.pupils)
    np.testing.assert_allclose(opened.landmarks[2], rest.landmarks[2], atol=0.5)


@pytest.mark.parametrize("seed", [*SEEDS, 14, 23], ids=str)  # the last two: women, large eyes
def test_a_blink_covers_the_eyeball_but_for_a_sliver_at_the_nose(
    heads: Mapping[tuple[int, str], Head], seed: int
) -> None:
    rest = heads[seed, "neutral"] if seed in SEEDS else made(seed)
    blink = heads[seed, "blink"] if seed in SEEDS else made(seed, EXPRESSIONS["blink"])
    for which in (0, 1):
        assert seen_vertices(rest, which).sum() > 100
        seen = seen_vertices(blink, which)
        assert seen.sum() <= 4
        ball = blink.part(("left_eye", "right_eye")[which]).vertices[seen]
        assert (np.linalg.norm(ball - rest.pupils[which], axis=1) > 7.5).all()


@pytest.mark.parametrize("name", ["smile", "grin", "blink", "mouth_open"])
def test_the_person_stays_the_same(heads: Mapping[tuple[int, str], Head], name: str) -> None:
    rest, acting = heads[3, "neutral"], heads[3, name]
    np.testing.assert_array_equal(acting.part("skin").albedo, rest.part("skin").albedo)
    assert (acting.identity_id, acting.ipd_mm) == (rest.identity_id, rest.ipd_mm)
    assert acting.parameters == rest.parameters
    for mine, theirs in zip(acting.parts, rest.parts, strict=True):
        assert mine.name == theirs.name
        np.testing.assert_array_equal(mine.faces, theirs.faces)
        assert np.isfinite(mine.vertices).all()


def test_half_a_strength_is_half_the_way() -> None:
    rest, half, whole = (
        corners(made(8, Expression("smile", {"mouthSmile": strength})))
        for strength in (0.0, 0.5, 1.0)
    )
    np.testing.assert_allclose(half - rest, (whole - rest) / 2, atol=1e-6)


def test_a_weaker_expression_has_weaker_units() -> None:
    weak = {"eyeBlinkLeft": 0.25, "eyeBlinkRight": 0.25}
    assert EXPRESSIONS["blink"].scaled(0.25).units == weak
    assert Expression("blink", {"eyeBlink": 1}, strength=0.25).units == weak
    assert EXPRESSIONS["smile"].scaled(0) == Expression("smile")
    assert EXPRESSIONS["smile"].scaled(1) == EXPRESSIONS["smile"]


def test_a_copy_is_as_strong() -> None:
    weak = Expression("blink", {"eyeBlink": 1}, strength=0.25)
    assert replace(weak, name="wink").units == weak.units


def test_a_side_that_is_named_has_its_own_strength() -> None:
    units = {"mouthSmileLeft": 0.1, "mouthSmile": 0.6}
    one = Expression("half", units)
    assert one.units == {"mouthSmileLeft": 0.1, "mouthSmileRight": 0.6}
    assert one == Expression("half", dict(reversed(units.items())))
    assert Expression("half", {"mouthSmile": 0.6, "mouthSmileLeft": 0}).units == {
        "mouthSmileRight": 0.6
    }


def test_given_units_replace_those_of_the_name() -> None:
    mine = preset("expression", "mouth_open", units={"jawOpen": 0.1, "mouthSmileLeft": 0.2})
    assert (mine.name, mine.units) == ("mouth_open", {"jawOpen": 0.1, "mouthSmileLeft": 0.2})


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_every_named_expression_is_plain(name: str) -> None:
    units = EXPRESSIONS[name].units
    assert json.loads(json.dumps(dict(units))) == units
    assert hash(EXPRESSIONS[name]) == hash(preset("expression", name))


@pytest.mark.parametrize(
    ("units", "message"),
    [
        ({"mouthSmille": 0.5}, "'mouthSmille' does not exist; choose one of mouthSmile"),
        ({"eyeLookUpLeft": 0.5}, "'eyeLookUpLeft' does not exist"),
        ({"zzz": 0.5}, "'zzz' does not exist; choose one of"),
        ({"jawOpen": 1.5}, "jawOpen=1.5: wanted 0 to 1"),
        ({"jawOpen": -0.1}, "jawOpen=-0.1: wanted 0 to 1"),
        ({"jawOpen": float("nan")}, "jawOpen=nan: wanted a number"),
        ({"jawOpen": "wide"}, "jawOpen=wide: wanted a number"),
        ({"jawOpen": True}, "jawOpen=[Tt]rue: wanted a number"),
    ],
    ids=lambda value: str(value)[:24],
)
def test_a_wrong_unit_is_refused(units: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Expression("mine", units)


def test_a_strength_beyond_all_is_refused() -> None:
    with pytest.raises(InputError, match=r"expression\.strength=2: wanted 0 to 1"):
        EXPRESSIONS["smile"].scaled(2)
