"""Checked against OpenCV's codec, whose tables and grids are what has to be found."""

import pytest
import torch

from lrsr.calibration.jpeg_blocks import estimate_jpeg
from lrsr.camera.codec import jpeg
from lrsr.errors import ImageContractError


def pictures(count: int = 20, side: int = 32) -> torch.Tensor:
    """Smooth random pictures with some noise, as cameras make."""
    generator = torch.Generator().manual_seed(5)
    coarse = torch.rand(count, 3, 5, 5, generator=generator)
    smooth = torch.nn.functional.interpolate(coarse, size=(side, side), mode="bicubic")
    noise = 0.02 * torch.randn(smooth.shape, generator=generator)
    return (smooth + noise).clamp(0, 1).mul(255).round() / 255


@pytest.mark.parametrize("quality", [10, 50, 75, 90])
@pytest.mark.parametrize(
    ("origin", "chroma"), [((0, 0), "4:2:0"), ((3, 5), "4:2:2"), ((7, 9), "4:4:4")]
)
def test_quality_and_grid_of_pictures_are_found(
    quality: int, origin: tuple[int, int], chroma: str
) -> None:
    found = estimate_jpeg(jpeg(pictures(), quality, chroma=chroma, origin_px=origin))
    assert found is not None
    assert abs(found.quality - quality) <= 1
    assert found.origin_px == (origin[0] % 8, origin[1] % 8)


def test_of_two_compressions_the_last_is_found() -> None:
    found = estimate_jpeg(jpeg(jpeg(pictures(), 90), 60, origin_px=(2, 1)))
    assert found is not None
    assert (found.quality, found.origin_px) == (60, (2, 1))


def test_pictures_without_blocks_have_none() -> None:
    assert estimate_jpeg(pictures()) is None


def test_a_grey_wall_proves_nothing() -> None:
    assert estimate_jpeg(torch.full((3, 3, 32, 32), 128 / 255)) is None


def test_too_small_a_picture_is_refused() -> None:
    with pytest.raises(ImageContractError, match="H and W >= 16"):
        estimate_jpeg(pictures(2, 12))
