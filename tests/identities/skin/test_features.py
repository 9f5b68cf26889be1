"""What is drawn over the skin stays in its place, whatever it looks like there."""

from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.lashes import Lashes, sample_lashes
from lrsr.identities.morphable import position_map, template
from lrsr.identities.skin.beard import _BEARD_KINDS, Beard, sample_beard
from lrsr.identities.skin.brows import Brows, sample_brows
from lrsr.identities.skin.canvas import FloatMap
from lrsr.identities.skin.features import FeaturePainter, _shade
from lrsr.identities.skin.hair_colour import HairColour
from lrsr.identities.skin.layout import Layout
from lrsr.identities.skin.make_up import MakeUp, sample_make_up

SIZE = 256
BLACK: HairColour = {"eumelanin": 6.0, "pheomelanin": 0.3, "grey": 0.0}
BARE: Any = sample_make_up(np.random.default_rng(0), masculinity=1.0, age=0.2)

PLACES = {
    "lip": (0.0, -80.0),
    "cheek": (44.0, -30.0),
    "lid": (32.0, 6.0),
    "lash line": (32.0, 4.0),
    "brow": (28.0, 17.0),
    "forehead": (0.0, 45.0),
    "chin": (0.0, -102.0),
    "upper lip": (8.0, -54.0),
    "nose": (0.0, -38.0),
}


@lru_cache
def _painter() -> FeaturePainter:
    return FeaturePainter(Layout(position_map(SIZE)), template().skin.astype(np.float32))


def _skin(tone: float = 0.35) -> FloatMap:
    return np.full((SIZE, SIZE, 3), (tone, 0.65 * tone, 0.5 * tone), dtype=np.float32)


def _near(place: str, radius_mm: float = 4.0) -> NDArray[np.bool_]:
    points, mask = position_map(SIZE)
    near = np.linalg.norm(points[..., :2] - np.array(PLACES[place]), axis=-1) < radius_mm
    return near & mask & (points[..., 2] > -50)


def _touched(painted: FloatMap, bare: FloatMap | None = None) -> set[str]:
    changed = np.abs(painted - (_skin() if bare is None else bare)).max(axis=-1) > 1e-3
    return {place for place in PLACES if changed[_near(place)].mean() > 0.02}


def _made_up(tone: float = 0.35, **worn: Any) -> FloatMap:
    albedo, make_up = _skin(tone), BARE | worn
    _painter().paint_make_up(albedo, make_up)
    return albedo


def _bearded(seed: int = 0, hair: HairColour = BLACK, **changes: Any) -> tuple[FloatMap, FloatMap]:
    drawn = sample_beard(np.random.default_rng(0), masculinity=0.9, asian=0.0, grey=0.0)
    beard: Beard = drawn | {"shadow": 0.0} | changes  # type: ignore[assignment]  # its fields
    albedo = _skin()
    relief = _painter().paint_beard(albedo, beard, hair, np.random.default_rng(seed))
    return albedo, relief


def _browed(seed: int = 0, hair: HairColour = BLACK) -> FloatMap:
    brows: Brows = sample_brows(np.random.default_rng(0), masculinity=0.9, age=0.3)
    albedo = _skin()
    _painter().paint_brows(albedo, brows, hair, np.random.default_rng(seed))
    return albedo


def test_no_make_up_changes_nothing() -> None:
    np.testing.assert_array_equal(_made_up(), _skin())


@pytest.mark.parametrize(
    ("worn", "places"),
    [
        ({"lipstick": 0.9, "lipstick_colour": (0.3, 0.02, 0.03)}, {"lip"}),
        ({"blush": 0.5}, {"cheek"}),
        ({"eyeshadow": 0.8, "eyeshadow_colour": (0.05, 0.04, 0.1)}, {"lid", "lash line"}),
        ({"eyeliner": 0.9}, {"lid", "lash line"}),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else None,
)
def test_make_up_stays_in_its_place(worn: dict[str, Any], places: set[str]) -> None:
    assert _touched(_made_up(**worn)) - {"brow"} == places  # eyeshadow fades out towards it


def test_lips_take_on_the_lipstick_the_more_of_it_they_wear() -> None:
    colour, lip = np.array([0.1, 0.02, 0.3]), _near("lip", 2.0)
    away = [
        np.abs(_made_up(lipstick=amount, lipstick_colour=colour)[lip] - colour).mean()
        for amount in (0.0, 0.3, 0.6, 0.9)
    ]
    assert away == sorted(away, reverse=True)
    assert away[-1] < 0.3 * away[0]


def test_dark_skin_wears_darker_lipstick() -> None:
    lip, worn = _near("lip", 2.0), {"lipstick": 1.0, "lipstick_colour": (0.35, 0.1, 0.1)}
    fair, dark = (_made_up(tone, **worn)[lip].mean() for tone in (0.5, 0.05))
    assert dark < 0.8 * fair


def test_the_same_holds_for_anybodys_make_up_that_it_is_a_reflectance() -> None:
    for seed in range(8):
        make_up: MakeUp = sample_make_up(np.random.default_rng(seed), masculinity=0.0, age=0.2)
        albedo = _skin()
        _painter().paint_make_up(albedo, make_up)
        assert albedo.dtype == np.float32
        assert albedo.min() >= 0
        assert albedo.max() <= 1


def test_lashes_darken_their_roots_and_nothing_else() -> None:
    albedo = _skin()
    lashes: Lashes = sample_lashes(np.random.default_rng(0), masculinity=0.2)
    _painter().paint_lash_lines(albedo, lashes)
    assert _touched(albedo) <= {"lid", "lash line"}
    assert "lash line" in _touched(albedo)
    assert (albedo <= _skin()).all()


def test_thicker_lashes_have_darker_roots() -> None:
    means = []
    for width_mm in (0.0, 0.05, 0.1, 0.2):
        albedo, lashes = _skin(), sample_lashes(np.random.default_rng(0), masculinity=0.2)
        _painter().paint_lash_lines(albedo, lashes | {"width_mm": width_mm})  # type: ignore[arg-type]
        means.append(albedo.mean())
    assert means == sorted(means, reverse=True)
    assert means[0] == pytest.approx(_skin().mean())


def test_brows_lie_above_the_eyes_on_both_sides_alike_dark() -> None:
    darker = _skin() - _browed()
    assert _touched(_browed()) <= {"brow", "lid"}
    assert darker[_near("lid", 3.0)].max() < 0.01  # the lowest hairs end 10 mm above the pupil
    points, _ = position_map(SIZE)
    left, right = (darker[points[..., 0] * side > 0].sum() for side in (-1, 1))
    assert left == pytest.approx(right, rel=0.3)


def test_white_brows_are_lighter_than_black_ones() -> None:
    brow = _near("brow", 6.0)
    black, white = (_browed(hair=BLACK | {"grey": grey})[brow].mean() for grey in (0.0, 1.0))  # type: ignore[arg-type]
    assert white > black


@pytest.mark.parametrize("kind", sorted(set(_BEARD_KINDS) - {"none"}))
def test_a_beard_stays_off_lips_nose_eyes_and_forehead(kind: str) -> None:
    albedo, _ = _bearded(kind=kind, density=1.2)
    assert _touched(albedo)
    assert _touched(albedo) <= {"chin", "upper lip", "cheek"}


@pytest.mark.parametrize("kind", _BEARD_KINDS)
def test_how_far_a_beard_stands_out_is_told_for_each_vertex(kind: str) -> None:
    _, relief = _bearded(kind=kind, length_mm=3.0)
    assert relief.shape == (len(template().skin),)
    assert relief.dtype == np.float32
    assert relief.min() >= 0
    assert relief.any() == (kind not in {"none", "stubble"})


def test_a_longer_beard_stands_out_farther() -> None:
    short, long = (_bearded(kind="full", length_mm=length)[1] for length in (1.0, 4.0))
    assert long.max() > short.max()
    assert (long >= short).all()


def test_no_beard_and_no_shadow_change_nothing() -> None:
    albedo, _ = _bearded(kind="none")
    np.testing.assert_array_equal(albedo, _skin())


def test_a_shaven_beard_shows_through_the_more_the_darker_it_is() -> None:
    chin = _near("chin")
    levels = [
        _bearded(kind="none", shadow=shadow, hair=hair)[0][chin].mean()
        for shadow, hair in ((0.0, BLACK), (0.3, BLACK), (0.9, BLACK))
    ]
    assert levels == sorted(levels, reverse=True)
    assert levels[0] > levels[-1]


def test_a_white_shaven_beard_is_not_seen() -> None:
    white: HairColour = {"eumelanin": 0.0, "pheomelanin": 0.0, "grey": 1.0}
    albedo, _ = _bearded(kind="none", shadow=0.9, hair=white)
    np.testing.assert_array_equal(albedo, _skin())


def test_the_same_stream_draws_the_same_hairs() -> None:
    for paint in (_browed, lambda seed: _bearded(seed, kind="full")[0]):
        np.testing.assert_array_equal(paint(5), paint(5))
        assert (paint(5) != paint(6)).any()


def test_nothing_reaches_the_back_of_the_head() -> None:
    points, mask = position_map(SIZE)
    behind = mask & (points[..., 2] < -110)
    albedo, relief = _bearded(kind="full")
    for painted in (albedo, _browed(), _made_up(blush=1.0, eyeshadow=1.0, lipstick=1.0)):
        np.testing.assert_array_equal(painted[behind], _skin()[behind])
    assert not relief[template().skin[:, 2] < -130].any()


def test_without_vertices_nothing_is_displaced() -> None:
    painter = FeaturePainter(Layout(position_map(64)), np.zeros((0, 3), np.float32))
    beard = sample_beard(np.random.default_rng(0), masculinity=0.9, asian=0.0, grey=0.0)
    for kind in ("none", "full"):
        worn: Beard = beard | {"kind": kind}  # type: ignore[assignment]  # one of the kinds
        albedo = np.full((64, 64, 3), 0.3, dtype=np.float32)
        relief = painter.paint_beard(albedo, worn, BLACK, np.random.default_rng(0))
        assert relief.shape == (0,)


def test_dark_hairs_shade_skin_by_their_share_and_leave_the_rest() -> None:
    skin, hair = np.float32([0.4, 0.2, 0.1]), np.float32([0.02, 0.01, 0.01])
    albedo = np.tile(skin, (1, 3, 1)).astype(np.float32)
    _shade(albedo, hair, np.arange(3), np.float32([0.0, 0.5, 1.0]))
    assert np.array_equal(albedo[0, 0], skin)
    assert albedo[0, 1] == pytest.approx(np.sqrt(skin * hair), rel=1e-5)  # the geometric mean
    assert albedo[0, 2] == pytest.approx(hair, rel=1e-5)
