"""Where points and pictures come to lie, in each colour."""

import pytest
import torch

from lrsr.camera.distortion import Distortion
from lrsr.camera.warp import Warp

pytestmark = pytest.mark.usefixtures("one_thread")

RANDOM = torch.Generator().manual_seed(0)
BARREL = Distortion(0.1, 0.4, radius_mm=2.5)
PITCH_MM = 0.00265 / 2
FIELD = torch.tensor([[1.5, 2.0]])  # 2.5 mm out, at the edge


def spot(side: int, x: float, y: float, sigma: float = 2.0) -> torch.Tensor:
    places = torch.arange(float(side))
    square = (places - x) ** 2 + (places[:, None] - y) ** 2
    return torch.exp(-square / (2 * sigma**2)).expand(1, 3, side, side)


def centres(light: torch.Tensor) -> list[list[float]]:
    """Return (x, y) of each colour's centre, px."""
    share = light[0] / light[0].sum((-2, -1), keepdim=True)
    places = torch.arange(float(light.shape[-1]))
    return torch.stack([share.sum(-2) @ places, share.sum(-1) @ places], 1).tolist()


def test_lateral_colour_moves_colours_along_the_radius() -> None:
    lens = Warp(Distortion(radius_mm=2.5), (2.65, 0.0, -5.3))
    # 2 and -4 film pixels at the edge, of which 0.6 lie to the right and 0.8 down.
    red, green, blue = centres(lens.draw(spot(41, 20, 20), FIELD, PITCH_MM))
    assert red == pytest.approx([20 + 2 * 0.6, 20 + 2 * 0.8], abs=0.03)
    assert green == pytest.approx([20, 20], abs=0.03)
    assert blue == pytest.approx([20 - 4 * 0.6, 20 - 4 * 0.8], abs=0.03)


@pytest.mark.parametrize("facing", [True, False], ids=["facing", "planar"])
def test_pictures_and_points_move_alike(facing: bool) -> None:
    lens = Warp(Distortion(0.1, 0.4, radius_mm=2.5, facing=facing))
    (moved,) = lens.move_points(torch.tensor([[24.0, 60.0]]), (81, 81), FIELD, PITCH_MM).tolist()
    place = centres(lens.draw(spot(81, 24, 60), FIELD, PITCH_MM))[1]
    assert place == pytest.approx(moved, abs=0.1)
    assert abs(moved[0] - 24) + abs(moved[1] - 60) > 2


def test_a_flat_picture_stays_flat() -> None:
    flat = torch.full((1, 3, 9, 7), 0.6)
    assert torch.allclose(Warp(BARREL, (2.0, 0.0, -2.0)).draw(flat, FIELD, PITCH_MM), flat)


def test_a_lens_that_bends_nothing_returns_the_film_itself() -> None:
    film, lens = spot(9, 4, 4), Warp(Distortion())
    assert lens.is_off
    assert lens.draw(film, FIELD, PITCH_MM) is film
    assert not Warp(BARREL).is_off
    assert not Warp(Distortion(), (1.0, 0.0, 0.0)).is_off
