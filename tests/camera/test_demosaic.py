"""What interpolation makes of a mosaic, whatever the method, and what each of them promises."""

import math

import cv2
import numpy as np
import pytest
import torch

from lrsr.camera.bayer import PATTERNS, mosaic
from lrsr.camera.demosaic import METHODS, demosaic
from lrsr.errors import ImageContractError, InputError

pytestmark = pytest.mark.usefixtures("one_thread")


def light(height: int = 12, width: int = 14, batch: int = 2) -> torch.Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(0))


def cpsnr_db(image: torch.Tensor, method: str, pattern: str = "RGGB") -> float:
    """Return the PSNR of all three colours together, without four pixels of border, peak 1."""
    miss = demosaic(mosaic(image, pattern), pattern, method) - image
    return float(-10 * torch.log10(miss[..., 4:-4, 4:-4].square().mean()))


def zone_plate(side: int = 128) -> torch.Tensor:
    """Grey rings that get finer from the top left corner on: to 0.35 periods a pixel at a side."""
    places = torch.arange(side, dtype=torch.float64)
    square = places**2 + places[:, None] ** 2
    return (0.5 + 0.5 * torch.cos(math.pi * 0.35 * square / side)).expand(1, 3, side, side)


@pytest.mark.parametrize("size", [(7, 5), (3, 3), (4, 9)], ids=str)
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_a_flat_field_comes_back_exactly_also_at_the_border(
    pattern: str, method: str, size: tuple[int, int]
) -> None:
    colour = torch.tensor([100.0, 333.0, 4095.0])[None, :, None, None].expand(1, 3, *size)
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
    x, y = torch.meshgrid(torch.arange(20.0), torch.arange(18.0), indexing="xy")
    ramp, inner = (3 * x + 5 * y).expand(1, 3, 18, 20), slice(6, -6)
    back = demosaic(mosaic(ramp), method=method)
    assert torch.allclose(back[..., inner, inner], ramp[..., inner, inner], atol=1e-4)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_what_a_photosite_has_seen_is_kept(pattern: str, method: str) -> None:
    raw = mosaic(light(), pattern)
    assert torch.equal(mosaic(demosaic(raw, pattern, method), pattern), raw)


@pytest.mark.parametrize("method", METHODS)
def test_twice_the_light_is_twice_the_picture(method: str) -> None:
    raw = mosaic(light())
    assert torch.equal(demosaic(2 * raw, method=method), 2 * demosaic(raw, method=method))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("axis", [-1, -2], ids=["left-right", "top-bottom"])
def test_a_mirrored_mosaic_gives_the_mirrored_picture(method: str, axis: int) -> None:
    # A side of odd length keeps its pattern; sums may come in another order.
    raw = mosaic(light(13, 15)).double()
    mirrored = demosaic(raw.flip(axis), method=method)
    assert torch.allclose(mirrored, demosaic(raw, method=method).flip(axis), atol=1e-12)


def test_malvar_is_closer_to_a_grey_edge_than_bilinear() -> None:
    edge = (torch.arange(16) > 7).float().expand(1, 3, 16, 16)
    loss = {m: float((demosaic(mosaic(edge), method=m) - edge).square().mean()) for m in METHODS}
    assert loss["malvar"] < 0.5 * loss["bilinear"]


def test_adapting_to_edges_restores_a_zone_plate_best() -> None:
    # Measured 12.7, 22.0 and 35.1 dB.
    bilinear, malvar, adaptive = (cpsnr_db(zone_plate(), method) for method in METHODS)
    assert bilinear + 8 < malvar
    assert malvar + 12 < adaptive


@pytest.mark.parametrize("pattern", PATTERNS)
def test_adapting_to_edges_restores_faces_best(pattern: str, faces: torch.Tensor) -> None:
    # Measured over four rendered faces of 13 pixels between the eyes: 31.1, 33.4 and 33.9 to
    # 34.3 dB, by pattern; of single faces 0.0 to 1.9 dB above Malvar.
    bilinear, malvar, adaptive = (cpsnr_db(faces, method, pattern) for method in METHODS)
    assert bilinear + 2 < malvar
    assert malvar + 0.45 < adaptive
    for face in faces.split(1):
        assert cpsnr_db(face, "edge_aware", pattern) > cpsnr_db(face, "malvar", pattern) - 0.1


@pytest.mark.parametrize("method", METHODS)
def test_no_image_sees_the_others_of_its_batch(method: str) -> None:
    raw = mosaic(light(batch=5))
    alone = torch.cat([demosaic(raw[i : i + 1], method=method) for i in range(5)])
    assert torch.equal(demosaic(raw, method=method), alone)


def test_unknown_settings_and_broken_images_are_refused() -> None:
    with pytest.raises(InputError, match="pattern=XXXX"):
        demosaic(torch.zeros(1, 1, 4, 4), "XXXX")
    with pytest.raises(InputError, match="method=nearest: wanted one of bilinear"):
        demosaic(torch.zeros(1, 1, 4, 4), method="nearest")
    with pytest.raises(ImageContractError, match="raw: got 2 x 9 photosites"):
        demosaic(torch.zeros(1, 1, 2, 9))
    with pytest.raises(ImageContractError, match="raw: got shape"):
        demosaic(torch.zeros(1, 3, 9, 9))
