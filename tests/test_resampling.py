"""Keys' cubic between pixels against the project's enlargement."""

import pytest
import torch

from lrsr.camera.image_plane import pixel_grid
from lrsr.images import resize_bicubic
from lrsr.resampling import _cubic_weights, bicubic_matrix, sample_bicubic

RANDOM = torch.Generator().manual_seed(0)


@pytest.mark.parametrize("scale", [2, 3])
def test_on_a_finer_grid_it_is_the_projects_enlargement(scale: int) -> None:
    images = torch.rand(2, 3, 5, 6, generator=RANDOM)
    places = (pixel_grid((5 * scale, 6 * scale), images) + 0.5) / scale - 0.5
    enlarged = sample_bicubic(images, places[None, None])
    assert torch.allclose(enlarged, resize_bicubic(images, scale), atol=1e-5)


def test_at_pixels_it_is_the_picture() -> None:
    images = torch.rand(2, 3, 5, 6, generator=RANDOM)
    assert torch.equal(sample_bicubic(images, pixel_grid((5, 6), images)[None, None]), images)


def test_a_flat_picture_is_flat_everywhere() -> None:
    places = torch.rand(1, 1, 4, 4, 2, generator=RANDOM) * 40 - 20
    assert torch.allclose(sample_bicubic(torch.ones(1, 3, 5, 5), places), torch.ones(1))


def test_a_parabola_is_reproduced() -> None:
    # Keys' kernel is exact up to second order (1981, section V), away from the border.
    x = torch.arange(9.0, dtype=torch.float64)
    images = ((x - 3) ** 2 + 2 * x[:, None] ** 2).expand(1, 1, 9, 9)
    place = torch.tensor([4.3, 3.8], dtype=torch.float64)
    wanted = (4.3 - 3) ** 2 + 2 * 3.8**2
    assert float(sample_bicubic(images, place.reshape(1, 1, 1, 1, 2))) == pytest.approx(wanted)


def test_every_image_and_channel_has_its_places() -> None:
    images = torch.arange(8.0).expand(2, 3, 8, 8)
    places = torch.full((2, 3, 1, 1, 2), 3.0)
    places[..., 0, 0, 0] = torch.tensor([[2.0, 3.0, 4.0], [3.5, 4.5, 5.5]])
    assert sample_bicubic(images, places).flatten().tolist() == [2.0, 3.0, 4.0, 3.5, 4.5, 5.5]


@pytest.mark.parametrize("channels", [1, 3])
def test_places_alike_or_given_to_each_show_the_same(channels: int) -> None:
    images = torch.rand(70, 3, 4, 5, generator=RANDOM)
    places = torch.rand(1, channels, 3, 2, 2, generator=RANDOM) * 6 - 1
    alike = sample_bicubic(images, places)
    each = sample_bicubic(images, places.expand(70, -1, -1, -1, -1))
    assert alike.shape == (70, 3, 3, 2)
    assert torch.allclose(alike, each, atol=1e-6)


def test_a_matrix_sees_the_same_beyond_the_border_too() -> None:
    image = torch.rand(1, 2, 4, 5, generator=RANDOM)
    places = torch.rand(30, 2, generator=RANDOM) * 8 - 2
    seen = bicubic_matrix(places, 4, 5) @ image[0].flatten(1).T.numpy()
    wanted = sample_bicubic(image, places.reshape(1, 1, 1, 30, 2))[0, :, 0]
    assert torch.allclose(torch.from_numpy(seen).T, wanted, atol=1e-6)


def test_one_pixel_is_seen_everywhere() -> None:
    places = torch.tensor([[-3.3, 0.2], [8.0, 1.7]]).reshape(1, 1, 1, 2, 2)
    assert sample_bicubic(
        torch.full((1, 1, 1, 1), 0.5), places
    ).flatten().tolist() == pytest.approx([0.5, 0.5])


def test_weights_sum_to_one() -> None:
    weights = torch.stack(_cubic_weights(torch.linspace(0, 0.999, 11)))
    assert torch.allclose(weights.sum(0), torch.ones(11))
