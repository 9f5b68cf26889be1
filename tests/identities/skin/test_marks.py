import json

import numpy as np
import pytest

from lrsr.identities.skin.canvas import Canvas
from lrsr.identities.skin.marks import draw_marks, sample_marks

FACE = Canvas(left_mm=-84.0, top_mm=100.0, width_mm=168.0, height_mm=230.0, pixel_mm=0.4)
CLEAR = {
    "moles": 0,
    "freckles": 0,
    "freckle_depth": 0.5,
    "freckle_spread": 1.0,
    "age_spots": 0,
    "places_seed": 1,
}


def test_clear_skin_has_no_marks() -> None:
    assert not draw_marks(CLEAR, FACE).any()


@pytest.mark.parametrize("kind", ["moles", "freckles", "age_spots"])
def test_more_marks_cover_more_skin(kind: str) -> None:
    few, many = ((draw_marks(CLEAR | {kind: n}, FACE) > 8).sum() for n in (10, 60))
    assert 0 < 2 * few < many


def test_moles_are_darker_than_freckles() -> None:
    mole = draw_marks(CLEAR | {"moles": 20}, FACE).max()
    freckle = draw_marks(CLEAR | {"freckles": 400}, FACE).max()
    assert mole > freckle + 30


def test_freckles_gather_around_nose_and_cheeks() -> None:
    sheet = draw_marks(CLEAR | {"freckles": 500}, FACE)
    rows, _ = np.nonzero(sheet > 10)
    heights = FACE.top_mm - rows * FACE.pixel_mm
    assert -35 < np.median(heights) < -10


def test_marks_stay_where_they_are() -> None:
    marks = CLEAR | {"moles": 5, "freckles": 100}
    np.testing.assert_array_equal(draw_marks(marks, FACE), draw_marks(marks, FACE))


def test_freckles_come_with_fair_skin_and_spots_with_age() -> None:
    rng = np.random.default_rng(0)

    def mean(name: str, **person: float) -> float:
        return np.mean([sample_marks(rng, **person)[name] > 0 for _ in range(300)])

    assert 0.25 < mean("freckles", melanin=0.015, age=0.2) < 0.45
    assert mean("freckles", melanin=0.2, age=0.2) == 0
    assert mean("age_spots", melanin=0.02, age=0.2) == 0
    assert mean("age_spots", melanin=0.02, age=0.95) > 0.9


def test_moles_have_the_recipes_mean_of_two_and_a_bit() -> None:
    rng = np.random.default_rng(0)
    moles = [sample_marks(rng, melanin=0.05, age=0.3)["moles"] for _ in range(2000)]
    assert np.mean(moles) == pytest.approx(2.2, abs=4 * np.sqrt(2.2 / 2000))
    assert json.loads(json.dumps(sample_marks(rng, melanin=0.02, age=0.9)))
