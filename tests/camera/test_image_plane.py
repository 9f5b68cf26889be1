"""Places on the sensor, and a camera that turns without rolling."""

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation

from lrsr.camera.image_plane import mm_to_pixels, pixel_grid, pixels_to_mm, read_field, turn
from lrsr.errors import InputError

CENTRE = torch.tensor([1.2, -0.8], dtype=torch.float64)
POINTS = torch.tensor([[0.0, 0.0], [1.2, -0.8], [2.0, 1.0], [-1.0, 0.5]], dtype=torch.float64)


def test_turning_is_scipys_rotation() -> None:
    axis = np.cross([*CENTRE.tolist(), 3.0], [0, 0, 1])
    angle = np.arctan2(np.linalg.norm(CENTRE), 3.0)
    rotation = Rotation.from_rotvec(angle * axis / np.linalg.norm(axis))
    rays = rotation.apply(np.column_stack([POINTS.numpy(), np.full(4, 3.0)]))
    assert np.allclose(turn(POINTS, CENTRE, 3.0).numpy(), 3.0 * rays[:, :2] / rays[:, 2:])


def test_turning_back_undoes_it() -> None:
    turned = turn(POINTS, CENTRE, 3.0)
    assert torch.allclose(turn(turned, CENTRE, 3.0, back=True), POINTS)


def test_a_camera_that_faces_the_axis_does_not_turn() -> None:
    assert torch.allclose(turn(POINTS, torch.zeros_like(CENTRE), 3.0), POINTS)


@pytest.mark.parametrize("back", [False, True])
def test_the_axis_has_a_gradient(back: bool) -> None:
    middle, points = torch.zeros(2, dtype=torch.float64, requires_grad=True), POINTS.clone()
    assert torch.autograd.gradcheck(lambda p, m: turn(p, m, 3.0, back=back), (points, middle))


def test_the_grid_follows_the_image_contract() -> None:
    grid = pixel_grid((2, 3), torch.zeros(1))
    assert grid.shape == (2, 3, 2)
    assert grid[0, 0].tolist() == [0.0, 0.0]
    assert grid[1, 2].tolist() == [2.0, 1.0]


def test_pixels_and_mm_invert_each_other() -> None:
    pixels = torch.tensor([[0.0, 0.0], [7.5, -2.0]], dtype=torch.float64)
    places = pixels_to_mm(pixels, (4, 8), 0.002, CENTRE)
    # The top-left pixel of 8 x 4 lies 3.5 left of and 1.5 above the middle.
    assert places[0].tolist() == pytest.approx([1.2 - 3.5 * 0.002, -0.8 - 1.5 * 0.002])
    assert torch.allclose(mm_to_pixels(places, (4, 8), 0.002, CENTRE), pixels)


def test_one_place_or_one_for_each_image() -> None:
    images = torch.zeros(3, 3, 2, 2)
    assert read_field((0.5, 1.0), images, 2.0).tolist() == [[0.5, 1.0]]
    assert read_field(torch.zeros(3, 2), images, 2.0).shape == (3, 2)


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (torch.zeros(2, 2), r"shape \(2, 2\)"),
        (torch.zeros(3), r"shape \(3,\)"),
        ((2.0, 2.0), "2.828 mm from the optical axis"),
        ((float("nan"), 0.0), "nan mm from the optical axis"),
    ],
    ids=["rows", "numbers", "off the sensor", "nan"],
)
def test_a_place_that_cannot_be_is_refused(
    field: tuple[float, float] | torch.Tensor, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        read_field(field, torch.zeros(3, 3, 2, 2), 2.5)
