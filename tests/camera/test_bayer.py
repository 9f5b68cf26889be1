"""Which colour a photosite sees, also in a crop."""

import pytest
import torch

from lrsr.camera.bayer import PATTERNS, colour_of_sites, mosaic, shifted
from lrsr.errors import ImageContractError, InputError

LIGHT = torch.rand(2, 3, 20, 20, generator=torch.Generator().manual_seed(0))


@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_photosite_keeps_the_colour_of_its_letter(pattern: str) -> None:
    raw = mosaic(LIGHT, pattern)
    for index, letter in enumerate(pattern):
        row, column = divmod(index, 2)
        kept = LIGHT[:, "RGB".index(letter), row::2, column::2]
        assert torch.equal(raw[:, 0, row::2, column::2], kept)


@pytest.mark.parametrize("pattern", PATTERNS)
def test_half_of_the_photosites_see_green(pattern: str) -> None:
    seen = colour_of_sites(pattern, (4, 6))
    assert [int((seen == colour).sum()) for colour in range(3)] == [6, 12, 6]


@pytest.mark.parametrize("origin_px", [(1, 0), (0, 1), (3, 5), (2, 4)], ids=str)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_crop_has_the_colours_of_its_place(pattern: str, origin_px: tuple[int, int]) -> None:
    x, y = origin_px
    crop = mosaic(LIGHT[..., y:, x:], shifted(pattern, origin_px))
    assert torch.equal(crop, mosaic(LIGHT, pattern)[..., y:, x:])


def test_unknown_patterns_and_broken_images_are_refused() -> None:
    for ask in (
        lambda p: shifted(p, (0, 0)),
        lambda p: colour_of_sites(p, (2, 2)),
        lambda p: mosaic(LIGHT, p),
    ):
        with pytest.raises(InputError, match="pattern=RGBG: wanted one of RGGB"):
            ask("RGBG")
    with pytest.raises(InputError, match="origin_px"):
        shifted("RGGB", (0, -1))
    with pytest.raises(ImageContractError, match="light: got shape"):
        mosaic(torch.zeros(1, 1, 4, 4))
