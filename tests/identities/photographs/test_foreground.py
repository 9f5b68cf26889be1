import numpy as np
import pytest

from lrsr.identities.photographs.foreground import find_person
from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.photographs.shot import Shot

SIZE = 240
IPD_PX = 40.0
ROWS, COLUMNS = np.mgrid[:SIZE, :SIZE]
RIGHT = np.hypot((COLUMNS - 120) / 55, (ROWS - 120) / 80) < 1
FITTED = np.hypot((COLUMNS - 120) / 55, (ROWS - 110) / 90) < 1
"""The head as it is on the picture, and as it was fitted: its crown is too high."""
FACE = np.hypot((COLUMNS - 120) / 45, (ROWS - 140) / 50) < 1


def shot(crown: tuple[float, float, float]) -> Shot:
    rng = np.random.default_rng(0)
    picture = np.full((SIZE, SIZE, 3), (0.1, 0.25, 0.5))
    picture[RIGHT] = (0.5, 0.3, 0.2)
    picture[RIGHT & (ROWS < 90)] = crown
    picture += rng.normal(0, 0.01, picture.shape)
    nowhere = Perspective(np.eye(3), 1.0, np.zeros(2), 1e-3, np.zeros(3))
    return Shot(picture.clip(0, 1).astype(np.float32), nowhere, np.zeros((1, 2)), IPD_PX)


@pytest.mark.parametrize("crown", [(0.5, 0.3, 0.2), (0.03, 0.02, 0.02)], ids=["bald", "dark hair"])
def test_background_over_the_crown_is_no_person(crown: tuple[float, float, float]) -> None:
    person = find_person(shot(crown), FITTED, FACE)
    assert person[RIGHT & FITTED].mean() > 0.95
    assert person[FITTED & ~RIGHT & (ROWS < 40)].mean() < 0.2


def test_long_hair_around_the_fitted_head_is_no_background() -> None:
    picture = shot((0.5, 0.3, 0.2))
    fitted = np.hypot((COLUMNS - 120) / 48, (ROWS - 130) / 62) < 1
    hair = (np.hypot((COLUMNS - 120) / 66, (ROWS - 120) / 90) < 1) & ~FACE & (ROWS < 190)
    picture.linear[hair] = (0.03, 0.02, 0.02)
    person = find_person(picture, fitted, FACE)
    assert person[hair].mean() > 0.95
    assert person[~hair & ~RIGHT & (ROWS < 190)].mean() < 0.1


def test_a_head_that_fills_the_picture_is_all_person() -> None:
    everywhere = np.ones((SIZE, SIZE), bool)
    assert find_person(shot((0.5, 0.3, 0.2)), everywhere, FACE).all()
