"""Bayer's mosaic, and what interpolation makes of it."""

import cv2
import numpy as np
import pytest
import torch
from torch.autograd import gradcheck

from lrsr.camera.mosaic import METHODS, PATTERNS, Mosaic, demosaic, mosaic, shifted
from lrsr.errors import ImageContractError, InputError


def light(height: int = 12, width: int = 14, batch: int = 2) -> torch.Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_flat_field_comes_back_exactly_also_at_the_border(pattern: str, method: str) -> None:
    colour = torch.tensor([100.0, 333.0, 4095.0])[None, :, None, None].expand(1, 3, 7, 5)
    assert torch.equal(demosaic(mosaic(colour, pattern), pattern, method), colour)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_bilinear_is_that_of_opencv_away_from_the_border(pattern: str) -> None:
    raw = np.random.default_rng(0).integers(0, 4096, (16, 18)).astype(np.uint16)
    code = getattr(cv2, f"COLOR_Bayer{pattern}2RGB")
    theirs = cv2.demosaicing(raw, code).astype(np.float32)[2:-2, 2:-2]
    ours = demosaic(torch.from_numpy(raw.astype(np.float32))[None, None], pattern, "bilinear")
    ours_rows = ours[0].permute(1, 2, 0).numpy()[2:-2, 2:-2]
    assert np.abs(ours_rows - theirs).max() <= 0.5  # they round


@pytest.mark.parametrize(
    ("pattern", "at", "wanted"),
    # Malvar, He, Cutler 2004, fig. 2, by hand, for a single bright photosite of 16 at (4, 4): red
    # in RGGB, green in a row of red in GRBG.
    [
        ("RGGB", (4, 4), [16, 8, 12]),
        ("RGGB", (5, 4), [8, 0, 0]),
        ("RGGB", (5, 5), [4, 0, 0]),
        ("RGGB", (6, 4), [0, -2, -3]),
        ("GRBG", (4, 4), [10, 16, 10]),
        ("GRBG", (5, 4), [0, 4, 0]),
        ("GRBG", (5, 5), [-2, 0, -2]),
        ("GRBG", (6, 4), [-2, 0, 1]),
        ("GRBG", (4, 6), [1, 0, -2]),
    ],
)
def test_malvar_spreads_one_photosite_as_the_paper_says(
    pattern: str, at: tuple[int, int], wanted: list[float]
) -> None:
    raw = torch.zeros(1, 1, 9, 9)
    raw[0, 0, 4, 4] = 16.0
    x, y = at
    assert demosaic(raw, pattern, "malvar")[0, :, y, x].tolist() == wanted


@pytest.mark.parametrize("method", METHODS)
def test_a_grey_ramp_comes_back_exactly_away_from_the_border(method: str) -> None:
    x, y = torch.meshgrid(torch.arange(12.0), torch.arange(10.0), indexing="xy")
    ramp = (3 * x + 5 * y).expand(1, 3, 10, 12)
    back = demosaic(mosaic(ramp), method=method)
    assert torch.allclose(back[..., 2:-2, 2:-2], ramp[..., 2:-2, 2:-2], atol=1e-4)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_a_photosite_has_seen_is_kept(pattern: str, method: str) -> None:
    raw = mosaic(light(), pattern)
    assert torch.equal(mosaic(demosaic(raw, pattern, method), pattern), raw)


def test_malvar_is_closer_to_a_grey_edge_than_bilinear() -> None:
    edge = (torch.arange(16) > 7).float().expand(1, 3, 16, 16)
    loss = {m: float((demosaic(mosaic(edge), method=m) - edge).square().mean()) for m in METHODS}
    assert loss["malvar"] < 0.5 * loss["bilinear"]


@pytest.mark.parametrize("origin_px", [(1, 0), (0, 1), (3, 5), (2, 4)], ids=str)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_crop_has_the_colours_of_its_place(pattern: str, origin_px: tuple[int, int]) -> None:
    image, (x, y) = light(20, 20), origin_px
    module = Mosaic(pattern)
    crop = module.filter(image[..., y:, x:], origin_px)
    assert torch.equal(crop, module.filter(image)[..., y:, x:])
    inner = module(crop, origin_px)[..., 2:-2, 2:-2]
    assert torch.equal(inner, module(module.filter(image))[..., y + 2 : -2, x + 2 : -2])


@pytest.mark.parametrize("method", METHODS)
def test_no_image_sees_the_others_of_its_batch(method: str) -> None:
    raw = mosaic(light(batch=5))
    alone = torch.cat([demosaic(raw[i : i + 1], method=method) for i in range(5)])
    assert torch.equal(demosaic(raw, method=method), alone)


@pytest.mark.parametrize("method", METHODS)
def test_finite_differences_agree_with_the_gradient(method: str) -> None:
    image = light(5, 4, batch=1).double().requires_grad_()
    assert gradcheck(lambda x: demosaic(mosaic(x, "GBRG"), "GBRG", method), image)


def test_unknown_settings_and_broken_images_are_refused() -> None:
    with pytest.raises(InputError, match="pattern=RGBG: wanted one of RGGB"):
        Mosaic("RGBG")
    with pytest.raises(InputError, match="method=nearest: wanted one of bilinear, malvar"):
        Mosaic(method="nearest")
    for function in (mosaic, demosaic):
        with pytest.raises(InputError, match="pattern=XXXX"):
            function(torch.zeros(1, 3 if function is mosaic else 1, 4, 4), "XXXX")
    with pytest.raises(InputError, match="pattern=XXXX"):
        shifted("XXXX", (0, 0))
    with pytest.raises(InputError, match="method=nearest"):
        demosaic(torch.zeros(1, 1, 4, 4), method="nearest")
    with pytest.raises(InputError, match="origin_px"):
        shifted("RGGB", (0, -1))
    with pytest.raises(ImageContractError, match="light: got shape"):
        mosaic(torch.zeros(1, 1, 4, 4))
    with pytest.raises(ImageContractError, match="raw: got 2 x 9 photosites"):
        demosaic(torch.zeros(1, 1, 2, 9))
