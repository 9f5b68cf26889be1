import numpy as np
import pytest

from lrsr.identities.face.expression import Expression
from lrsr.identities.face.mouth import _MUCOSA, _THROAT, build_mouth, cavity, lining
from lrsr.identities.face.teeth import build_jaws
from lrsr.identities.face.template import template
from lrsr.identities.morphable import sample_head
from lrsr.identities.shape.basis import load_basis


def test_the_cavity_is_behind_the_lips_and_nowhere_else() -> None:
    skin = template().skin
    away = np.linalg.norm(cavity().hollow(skin) - skin, axis=1)
    moved = skin[away > 0]
    assert len(moved) > 100
    assert away.max() == pytest.approx(55.0)
    assert (np.abs(moved[:, 0]) < 32).all()
    assert ((moved[:, 1] > -86) & (moved[:, 1] < -54)).all()


def test_the_cavity_stays_inside_the_head() -> None:
    hollow = cavity().hollow(template().skin)
    assert hollow[cavity().vertices, 2].min() > -75
    assert hollow[:, 2].min() == template().skin[:, 2].min()


def test_lips_keep_their_colour_and_the_throat_is_dark() -> None:
    albedo = np.full((256, 256, 3), 0.5, np.float32)
    lining(256).paint(albedo)
    rows, columns = np.nonzero((albedo != 0.5).any(axis=-1))
    assert rows.min() > 0.9 * 256  # the tile of the mouth lies in the lower right corner
    assert columns.min() > 0.8 * 256
    painted = albedo[rows, columns]
    np.testing.assert_allclose(painted.min(axis=0), _THROAT, atol=0.02)
    assert (np.abs(painted - _MUCOSA).max(axis=1) < 0.02).sum() > 20


def test_nothing_grows_inside_the_mouth() -> None:
    surface = load_basis().surface
    outside = cavity().outside
    assert (outside[surface.landmarks] == 1).all()
    assert outside[cavity().vertices].max() < 1e-6


@pytest.mark.parametrize("seed", [2, 7, 11])
def test_closed_lips_hide_the_teeth(seed: int) -> None:
    """Each front tooth lies behind the skin before it: no tooth is nearer than the lips."""
    head = sample_head(seed, texture_size=64)
    skin, mouth = head.part("skin").vertices, head.part("mouth").vertices
    for point in mouth[np.abs(mouth[:, 0]) < 15]:
        beside = np.hypot(skin[:, 0] - point[0], skin[:, 1] - point[1]) < 2.5
        assert skin[beside, 2].max() > point[2] + 2


def test_the_jaw_carries_lower_teeth_and_tongue() -> None:
    lower = build_jaws().lower
    shut, opened = (
        sample_head(2, texture_size=64, expression=Expression("open", {"jawOpen": strength}))
        .part("mouth")
        .vertices
        for strength in (0.0, 0.5)
    )
    np.testing.assert_array_equal(shut[~lower], opened[~lower])
    # MakeHuman's own lower teeth move down by 8 to 27 mm when jawOpen is 1.
    down = (shut - opened)[lower, 1]
    assert 1 < down.min() < down.max() < 14


def test_old_teeth_are_darker_and_yellower() -> None:
    rest = load_basis().shape(load_basis().neutral)
    young, old = (build_mouth(rest, {}, age=age).albedo[30, 16] for age in (0.0, 1.0))
    assert (old < young).all()
    assert old[2] / old[0] < young[2] / young[0]
