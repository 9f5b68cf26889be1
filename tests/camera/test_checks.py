"""What every stage of the camera refuses."""

import pytest
import torch

from lrsr.camera.checks import check_light, check_origin, check_setting, check_srgb
from lrsr.errors import ImageContractError, InputError


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_light_of_either_precision_passes_unchanged(dtype: torch.dtype) -> None:
    light = torch.zeros(1, 3, 2, 2, dtype=dtype)
    assert check_light(light) is light


@pytest.mark.parametrize("shape", [(3, 2, 2), (1, 2, 2, 2), (0, 3, 2, 2), (1, 3, 0, 2)], ids=str)
def test_what_is_no_batch_of_images_is_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match=r"raw: got shape .*, wanted \(B, 1 or 3, H, W\)"):
        check_light(torch.zeros(shape), channels=(1, 3), name="raw")


def test_whole_numbers_are_no_light() -> None:
    with pytest.raises(ImageContractError, match=r"linear: got torch.uint8, wanted floating point"):
        check_light(torch.zeros(1, 3, 2, 2, dtype=torch.uint8))


def test_a_setting_that_breaks_its_rule_is_named_with_the_remedy() -> None:
    check_setting("bits", 10, True, "8 to 16")
    with pytest.raises(InputError, match=r"^bits=7: wanted 8 to 16$"):
        check_setting("bits", 7, False, "8 to 16")


@pytest.mark.parametrize("origin_px", [(1,), (1, 2, 3), (0, -1), (0.5, 0)], ids=str)
def test_an_origin_is_two_whole_numbers(origin_px: tuple[int, int]) -> None:
    assert check_origin((3.0, 0)) == (3, 0)  # as configurations may write it
    with pytest.raises(InputError, match=r"origin_px=.*: wanted two whole numbers"):
        check_origin(origin_px)


def test_pictures_of_another_range_are_refused_with_the_wanted_one() -> None:
    srgb = torch.rand(1, 3, 4, 4)
    assert check_srgb(srgb) is srgb
    for wrong in (255 * srgb + 2, srgb - 1.5, srgb / 0):
        with pytest.raises(ImageContractError, match=r"srgb: got values from .*, wanted \[0, 1\]"):
            check_srgb(wrong)


@pytest.mark.parametrize("dtype", [torch.float16, torch.bfloat16])
def test_half_precision_is_refused(dtype: torch.dtype) -> None:
    with pytest.raises(ImageContractError, match=f"linear: got {dtype}, wanted floating point of"):
        check_light(torch.zeros(1, 3, 2, 2, dtype=dtype))
