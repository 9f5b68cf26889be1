import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.gate.blotches import measure_paint
from lrsr.identities.morphable import position_map

SIZE = 256


def fair() -> NDArray[np.float32]:
    return np.full((SIZE, SIZE, 3), 0.4, np.float32)


def blackened(x: float, y: float, radius_mm: float) -> NDArray[np.float32]:
    """Skin with a black disc around a point of the template's front, mm."""
    albedo, points = fair(), position_map(SIZE).points
    near = (np.hypot(points[..., 0] - x, points[..., 1] - y) < radius_mm) & (points[..., 2] > -40)
    albedo[near] = 0.01
    return albedo


def test_an_even_skin_has_no_dark_patch() -> None:
    paint = measure_paint(fair())
    assert (paint.lowest, paint.highest) == pytest.approx((0.4, 0.4))
    assert paint[2:] == (0.0, 0.0, 0.0)


def test_darkness_is_relative_to_the_face() -> None:
    assert measure_paint(fair() * np.float32(0.1))[2:] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("place", "name"),
    [
        ((34.0, -30.0), "dark_cheeks"),
        ((0.0, -24.0), "dark_nose"),
        ((0.0, 36.0), "dark_forehead"),
    ],
    ids=["cheek", "nose", "forehead"],
)
def test_a_black_patch_is_found_where_it_is(place: tuple[float, float], name: str) -> None:
    paint = measure_paint(blackened(*place, 12.0))
    assert getattr(paint, name) > 0.2
    others = {"dark_cheeks", "dark_nose", "dark_forehead"} - {name}
    assert all(getattr(paint, other) < 0.1 for other in others)


def test_a_mole_is_no_patch() -> None:
    assert max(measure_paint(blackened(34.0, -30.0, 1.5))[2:]) < 0.06


def test_a_larger_patch_has_the_larger_share() -> None:
    small, large = (measure_paint(blackened(34.0, -30.0, r)).dark_cheeks for r in (5.0, 10.0))
    assert 0.0 < small < large <= 0.5  # of both cheeks


def test_a_colour_that_is_not_finite_is_told() -> None:
    albedo = fair()
    albedo[0, 0] = np.nan
    assert np.isnan(measure_paint(albedo).lowest)
