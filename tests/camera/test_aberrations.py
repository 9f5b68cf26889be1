"""Wavefronts by hand."""

import pytest
import torch

from lrsr.camera.aberrations import Seidel, defocus_waves
from lrsr.errors import InputError

AXIS, EDGE = torch.zeros(1, 2, dtype=torch.float64), torch.tensor([[1.0, 0.0]]).double()


@pytest.mark.parametrize(
    ("name", "x", "y", "expected"),
    [
        ("defocus", 0.5, 0.5, 0.5),
        ("spherical", 0.5, 0.5, 0.25),
        ("coma", 0.5, 0.5, 0.25),
        ("astigmatism", 0.5, 0.5, 0.25),
        ("curvature", 0.5, 0.5, 0.5),
        ("coma", 0.0, 0.5, 0.0),
        ("astigmatism", 0.0, 0.5, 0.0),
    ],
)
def test_terms_have_hopkins_form(name: str, x: float, y: float, expected: float) -> None:
    # Five samples across lie at -0.8, -0.4, 0, 0.4, 0.8; scale (x, y) = 0.5 to 0.8.
    waves = Seidel(**{name: 1.0}).waves(EDGE, 5)[0, 0]
    column, row = 2 + round(x * 4), 2 + round(y * 4)
    powers = {"defocus": 2, "spherical": 4, "coma": 3, "astigmatism": 2, "curvature": 2}
    assert float(waves[row, column]) == pytest.approx(expected * 1.6 ** powers[name])


@pytest.mark.parametrize("name", ["coma", "astigmatism", "curvature"])
def test_field_aberrations_vanish_on_the_axis(name: str) -> None:
    assert not Seidel(**{name: 3.0}).waves(AXIS, 8).any()


@pytest.mark.parametrize(("name", "ratio"), [("coma", 2), ("astigmatism", 4), ("curvature", 4)])
def test_field_aberrations_grow_as_seidel_says(name: str, ratio: int) -> None:
    term = Seidel(**{name: 1.0})
    assert torch.allclose(term.waves(EDGE, 8), ratio * term.waves(EDGE / 2, 8))


def test_the_slope_is_bounded() -> None:
    seidel = Seidel(1.0, -0.5, 0.7, 0.3, -0.2)
    size = 201
    waves = seidel.waves(EDGE, size)[0, 0]
    down, right = torch.gradient(waves, spacing=2 / size)
    rim = (torch.arange(size) * 2 + 1 - size) / size
    inside = torch.hypot(rim[:, None], rim) <= 1
    steepest = float(torch.hypot(down, right)[inside].max())
    assert steepest <= float(seidel.steepest()) + 1e-6
    assert float(Seidel(1.0).steepest()) == 2.0


def test_each_place_and_colour_has_its_wavefront() -> None:
    waves = Seidel(defocus=torch.tensor([[1.0, 2.0, 3.0], [0.0, 0.0, 0.0]])).waves(EDGE, 4)
    assert waves.shape == (2, 3, 4, 4)
    assert torch.allclose(waves[0, 1], 2 * waves[0, 0])


def test_slow_lenses_have_the_text_books_defocus() -> None:
    # W020 = δ / (8 N² λ)
    assert defocus_waves(100.0, 16.0, 500) == pytest.approx(100 / (8 * 256 * 0.5), rel=1e-3)


def test_an_impossible_f_number_is_refused() -> None:
    with pytest.raises(InputError, match="f_number"):
        defocus_waves(1.0, 0.0, 550)
