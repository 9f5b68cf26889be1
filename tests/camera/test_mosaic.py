"""Filters and interpolation as one part of the camera, which knows where its crop lies."""

import pytest
import torch

from lrsr.camera.bayer import PATTERNS, mosaic, shifted
from lrsr.camera.demosaic import METHODS, demosaic
from lrsr.camera.mosaic import Mosaic
from lrsr.errors import ImageContractError, InputError

pytestmark = pytest.mark.usefixtures("one_thread")

LIGHT = torch.rand(2, 3, 30, 30, generator=torch.Generator().manual_seed(0))
# How far from its border a crop differs from the whole: what a colour is made of lies so near.
REACH_PX = {"bilinear": 1, "malvar": 2, "edge_aware": 8}


@pytest.mark.parametrize("method", METHODS)
def test_it_filters_and_interpolates_by_its_settings(method: str) -> None:
    module, pattern = Mosaic("BGGR", method), shifted("BGGR", (3, 4))
    raw = module.filter(LIGHT, (3, 4))
    assert torch.equal(raw, mosaic(LIGHT, pattern))
    assert torch.equal(module(raw, (3, 4)), demosaic(raw, pattern, method))


@pytest.mark.parametrize("origin_px", [(1, 0), (0, 1), (3, 5), (2, 4)], ids=str)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_crop_is_interpolated_as_in_its_place(
    pattern: str, method: str, origin_px: tuple[int, int]
) -> None:
    (x, y), near, module = origin_px, REACH_PX[method], Mosaic(pattern, method)
    crop = module(module.filter(LIGHT[..., y:, x:], origin_px), origin_px)
    whole = module(module.filter(LIGHT))[..., y:, x:]
    inner = slice(near, -near)
    assert torch.equal(crop[..., inner, inner], whole[..., inner, inner])


def test_it_says_how_it_is_set() -> None:
    assert repr(Mosaic("GRBG", "edge_aware")) == "Mosaic(pattern='GRBG', method='edge_aware')"


def test_unknown_settings_and_broken_images_are_refused() -> None:
    with pytest.raises(InputError, match="pattern=RGBG: wanted one of RGGB"):
        Mosaic("RGBG")
    with pytest.raises(InputError, match="method=nearest: wanted one of bilinear, malvar, edge_a"):
        Mosaic(method="nearest")
    with pytest.raises(ImageContractError, match="light: got shape"):
        Mosaic().filter(torch.zeros(1, 1, 4, 4))
    with pytest.raises(ImageContractError, match="raw: got shape"):
        Mosaic()(torch.zeros(1, 3, 4, 4))
