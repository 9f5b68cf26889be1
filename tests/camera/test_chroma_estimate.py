"""Checked against OpenCV's codec, whose sub-sampling is what has to be found."""

import pytest
import torch

from lrsr.camera.chroma_estimate import estimate_chroma
from lrsr.camera.codec import jpeg
from lrsr.errors import ImageContractError, InputError


def pictures(count: int = 20) -> torch.Tensor:
    """Smooth random pictures with some noise, as cameras make."""
    generator = torch.Generator().manual_seed(5)
    coarse = torch.rand(count, 3, 5, 5, generator=generator)
    smooth = torch.nn.functional.interpolate(coarse, size=(32, 32), mode="bicubic")
    noise = 0.02 * torch.randn(smooth.shape, generator=generator)
    return (smooth + noise).clamp(0, 1).mul(255).round() / 255


@pytest.mark.parametrize("quality", [30, 60, 85])
@pytest.mark.parametrize(
    ("chroma", "origin"),
    [
        ("4:2:0", (0, 0)),
        ("4:2:0", (11, 2)),
        ("4:2:0", (3, 13)),
        ("4:2:2", (9, 3)),
        ("4:2:2", (1, 3)),
        ("4:4:4", (2, 4)),
    ],
)
def test_sub_sampling_and_place_are_found(
    quality: int, chroma: str, origin: tuple[int, int]
) -> None:
    squeezed = jpeg(pictures(), quality, chroma=chroma, origin_px=origin)
    found = estimate_chroma(squeezed, quality, (origin[0] % 8, origin[1] % 8))
    assert found == (chroma, origin)


def test_rows_of_colour_blocks_repeat_every_eight_pixels_at_half_width() -> None:
    once = jpeg(pictures(), 60, chroma="4:2:2", origin_px=(2, 5))
    again = jpeg(pictures(), 60, chroma="4:2:2", origin_px=(2, 13))
    assert estimate_chroma(once, 60, (2, 5)) == estimate_chroma(again, 60, (2, 5))


def test_grey_pictures_lose_nothing_by_any_sub_sampling() -> None:
    grey = pictures()[:, :1].expand(-1, 3, -1, -1)
    assert estimate_chroma(jpeg(grey, 50), 50, (0, 0))[0] == "4:4:4"


def test_a_quality_out_of_range_is_refused() -> None:
    with pytest.raises(InputError, match="quality=0"):
        estimate_chroma(pictures(2), 0, (0, 0))


def test_pictures_of_one_channel_are_refused() -> None:
    with pytest.raises(ImageContractError, match="srgb"):
        estimate_chroma(pictures(2)[:, :1], 50, (0, 0))
