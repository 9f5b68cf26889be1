"""Checked against OpenCV's codec, whose tables and grids are what has to be found."""

from itertools import pairwise

import cv2
import numpy as np
import pytest
import torch

from lrsr.camera.codec import jpeg
from lrsr.camera.jpeg_estimate import (
    estimate_jpeg,
    luminance_table,
    nearest_quality,
    read_jpeg_settings,
)
from lrsr.errors import ImageContractError


def pictures(count: int = 20, side: int = 32) -> torch.Tensor:
    """Smooth random pictures with some noise, as cameras make."""
    generator = torch.Generator().manual_seed(5)
    coarse = torch.rand(count, 3, 5, 5, generator=generator)
    smooth = torch.nn.functional.interpolate(coarse, size=(side, side), mode="bicubic")
    noise = 0.02 * torch.randn(smooth.shape, generator=generator)
    return (smooth + noise).clamp(0, 1).mul(255).round() / 255


def encoded(quality: int, factor: int = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420) -> bytes:
    rows = (pictures(1)[0].permute(1, 2, 0) * 255).byte().numpy()
    settings = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, factor]
    return bytes(cv2.imencode(".jpg", rows, settings)[1])


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


@pytest.mark.parametrize("quality", [1, 37, 50, 75, 100])
def test_the_file_tells_its_own_quality(quality: int) -> None:
    assert read_jpeg_settings(encoded(quality)) == (quality, "4:2:0")


@pytest.mark.parametrize(
    ("factor", "chroma"),
    [
        (cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444, "4:4:4"),
        (cv2.IMWRITE_JPEG_SAMPLING_FACTOR_422, "4:2:2"),
    ],
)
def test_the_file_tells_its_sub_sampling(factor: int, chroma: str) -> None:
    assert read_jpeg_settings(encoded(80, factor)) == (80, chroma)


def test_a_grey_file_has_its_colour_at_full_size() -> None:
    _, file = cv2.imencode(".jpg", np.full((16, 16), 90, np.uint8), [cv2.IMWRITE_JPEG_QUALITY, 66])
    assert read_jpeg_settings(bytes(file)) == (66, "4:4:4")


def test_a_file_cut_short_tells_nothing() -> None:
    assert read_jpeg_settings(encoded(75)[:40]) is None


def test_other_files_tell_nothing() -> None:
    assert read_jpeg_settings(bytes(cv2.imencode(".png", np.zeros((8, 8), np.uint8))[1])) is None


def test_steps_fall_as_quality_rises() -> None:
    tables = [luminance_table(quality) for quality in range(1, 101)]
    assert all(bool((a >= b).all()) for a, b in pairwise(tables))
    assert tables[-1].max() == 1


def test_a_foreign_table_has_a_nearest_quality() -> None:
    assert abs(nearest_quality(1.1 * luminance_table(50)) - 50) <= 5
