"""Pictures cut from frames at one place or at many, by OpenCV's codec, and its sub-sampling."""

import pytest
import torch

from lrsr.calibration.compression import _estimate_chroma, estimate_compression
from lrsr.camera.codec import jpeg
from lrsr.errors import ImageContractError, InputError

COUNT = 12
PLACES = tuple(((5 * k + 3) % 16, (7 * k) % 16) for k in range(COUNT))


def smooth(count: int) -> torch.Tensor:
    """Smooth random pictures with some noise, as cameras make."""
    generator = torch.Generator().manual_seed(5)
    coarse = torch.rand(count, 3, 5, 5, generator=generator)
    smooth = torch.nn.functional.interpolate(coarse, size=(32, 32), mode="bicubic")
    noise = 0.02 * torch.randn(smooth.shape, generator=generator)
    return (smooth + noise).clamp(0, 1).mul(255).round() / 255


def twenty() -> torch.Tensor:
    return smooth(20)


@pytest.fixture(scope="module")
def pictures() -> torch.Tensor:
    return smooth(COUNT)


def cut(pictures: torch.Tensor, quality: int, chroma: str = "4:2:0") -> torch.Tensor:
    """Compress each as if it lay elsewhere in its frame."""
    each = zip(pictures.split(1), PLACES, strict=True)
    return torch.cat([jpeg(one, quality, chroma=chroma, origin_px=place) for one, place in each])


def test_one_place_is_found_for_all(pictures: torch.Tensor) -> None:
    found = estimate_compression(jpeg(pictures, 70, origin_px=(11, 2)))
    assert found is not None
    assert (found.quality, found.chroma, found.origins_px) == (70, "4:2:0", ((11, 2),))


@pytest.mark.parametrize(("quality", "chroma"), [(50, "4:2:0"), (75, "4:2:2"), (90, "4:4:4")])
def test_each_picture_may_lie_elsewhere(quality: int, chroma: str, pictures: torch.Tensor) -> None:
    found = estimate_compression(cut(pictures, quality, chroma))
    assert found is not None
    assert found.quality == pytest.approx(quality, abs=1)
    assert found.chroma == chroma
    luminance = [(x % 8, y % 8) for x, y in found.origins_px]
    expected = [(x % 8, y % 8) for x, y in PLACES]
    # Of a single picture the colours now and then seem sub-sampled otherwise; it is left out then.
    assert len(luminance) > COUNT / 2
    assert set(luminance) <= set(expected)


def test_where_one_place_is_not_everybody_s_each_tells_its_own(pictures: torch.Tensor) -> None:
    half = COUNT // 2
    mixed = torch.cat([jpeg(pictures[:half], 60), cut(pictures, 60)[half:]])
    found = estimate_compression(mixed)
    assert found is not None
    assert found.quality == 60
    assert len(found.origins_px) > half


def test_walls_among_the_pictures_do_not_undo_what_the_others_show(pictures: torch.Tensor) -> None:
    walls = torch.full((2 * COUNT, 3, 32, 32), 0.5)
    found = estimate_compression(jpeg(torch.cat([pictures, walls]), 70, origin_px=(3, 4)))
    assert found is not None
    assert (found.quality, [(x % 8, y % 8) for x, y in found.origins_px]) == (70, [(3, 4)])


def test_pictures_without_blocks_have_none(pictures: torch.Tensor) -> None:
    assert estimate_compression(pictures) is None


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
    squeezed = jpeg(twenty(), quality, chroma=chroma, origin_px=origin)
    found = _estimate_chroma(squeezed, quality, (origin[0] % 8, origin[1] % 8))
    assert found == (chroma, origin)


def test_rows_of_colour_blocks_repeat_every_eight_pixels_at_half_width() -> None:
    once = jpeg(twenty(), 60, chroma="4:2:2", origin_px=(2, 5))
    again = jpeg(twenty(), 60, chroma="4:2:2", origin_px=(2, 13))
    assert _estimate_chroma(once, 60, (2, 5)) == _estimate_chroma(again, 60, (2, 5))


def test_grey_pictures_lose_nothing_by_any_sub_sampling() -> None:
    grey = twenty()[:, :1].expand(-1, 3, -1, -1)
    assert _estimate_chroma(jpeg(grey, 50), 50, (0, 0))[0] == "4:4:4"


def test_a_quality_out_of_range_is_refused() -> None:
    with pytest.raises(InputError, match="quality=0"):
        _estimate_chroma(twenty()[:2], 0, (0, 0))


def test_pictures_of_one_channel_are_refused() -> None:
    with pytest.raises(ImageContractError, match="srgb"):
        _estimate_chroma(twenty()[:2][:, :1], 50, (0, 0))
