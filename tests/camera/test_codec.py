"""The real JPEG, the differentiable one, and how far apart they are."""

import io
from collections.abc import Callable

import numpy as np
import pytest
import torch
from PIL import Image

from lrsr.camera.codec import (
    _CHROMAS,
    COMPRESSIONS,
    Jpeg,
    jpeg,
    jpeg_differentiable,
)
from lrsr.errors import ImageContractError, InputError
from lrsr.images import resize_bicubic

Codec = Callable[..., torch.Tensor]
SIZES = [(32, 32), (33, 47), (128, 128), (7, 9), (1, 1)]
QUALITIES = [quality for quality in COMPRESSIONS.values() if quality is not None]


def smooth(
    batch: int, height: int, width: int, *, grain_px: int = 8, seed: int = 0
) -> torch.Tensor:
    """Random colours every ``grain_px`` pixels, bicubic in between; as smooth as a face."""
    grid = (batch, 3, -(-height // grain_px), -(-width // grain_px))
    colours = torch.rand(grid, generator=torch.Generator().manual_seed(seed))
    large = resize_bicubic(colours * 0.5 + 0.25, grain_px)[..., :height, :width]
    return (large.clamp(0, 1) * 255).round() / 255


def psnr_db(a: torch.Tensor, b: torch.Tensor) -> float:
    return float(-10 * torch.log10((a - b).square().mean()))


def by_pillow(srgb: torch.Tensor, quality: int) -> torch.Tensor:
    pixels = (srgb * 255).round().byte().permute(1, 2, 0).numpy()
    file = io.BytesIO()
    Image.fromarray(pixels).save(file, "JPEG", quality=quality, subsampling="4:2:0")
    decoded = np.asarray(Image.open(file))
    return torch.from_numpy(decoded.copy()).permute(2, 0, 1) / 255


@pytest.mark.parametrize("quality", QUALITIES)
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_the_real_codec_is_the_file_that_pillow_would_write(
    size: tuple[int, int], quality: int
) -> None:
    image = smooth(1, *size)
    difference = (jpeg(image, quality)[0] - by_pillow(image[0], quality)).abs() * 255
    assert float(difference.max()) <= 2.001  # two builds of libjpeg-turbo may round differently


@pytest.mark.parametrize("codec", [jpeg, jpeg_differentiable], ids=["true", "differentiable"])
@pytest.mark.parametrize("size", SIZES, ids=str)
def test_shape_range_and_levels_survive(codec: Codec, size: tuple[int, int]) -> None:
    decoded = codec(smooth(2, *size), 15)
    assert decoded.shape == (2, 3, *size)
    assert decoded.dtype == torch.float32
    assert 0 <= float(decoded.min()) <= float(decoded.max()) <= 1
    assert torch.allclose(decoded * 255, (decoded * 255).round(), atol=1e-4)


@pytest.mark.parametrize("codec", [jpeg, jpeg_differentiable], ids=["true", "differentiable"])
def test_no_image_sees_the_others_of_its_batch(codec: Codec) -> None:
    images = smooth(4, 33, 47)
    alone = torch.cat([codec(image[None], 15) for image in images])
    assert torch.equal(codec(images, 15), alone)


@pytest.mark.parametrize("codec", [jpeg, jpeg_differentiable], ids=["true", "differentiable"])
def test_more_compression_loses_more(codec: Codec) -> None:
    images = smooth(8, 32, 32)
    loss = [psnr_db(codec(images, quality), images) for quality in (95, 75, 40, 15, 5)]
    assert loss == sorted(loss, reverse=True)


@pytest.mark.parametrize(
    ("quality", "grain_px", "apart_db"),
    # Measured 39.0, 37.8, 46.0, 43.3 dB apart; each from the original: 30.8, 28.0, 41.5, 36.4 dB.
    [(15, 16, 38.0), (15, 8, 37.0), (75, 16, 45.0), (75, 8, 42.0)],
)
def test_the_codecs_are_closer_to_each_other_than_to_the_original(
    quality: int, grain_px: int, apart_db: float
) -> None:
    images = smooth(32, 48, 48, grain_px=grain_px)
    true, soft = jpeg(images, quality), jpeg_differentiable(images, quality)
    assert psnr_db(true, soft) > apart_db
    assert psnr_db(true, soft) > psnr_db(true, images) + 4


def test_padding_repeats_the_edge_and_brings_no_dark_border() -> None:
    flat = torch.full((1, 3, 17, 19), 0.6)
    for codec in (jpeg, jpeg_differentiable):
        assert float((codec(flat, 15) - 0.6).abs().max()) < 0.02


def test_only_the_differentiable_codec_has_a_gradient() -> None:
    images = smooth(1, 33, 20).requires_grad_()
    assert not jpeg(images, 15).requires_grad
    assert jpeg_differentiable(images, 15).requires_grad


def test_a_step_along_the_gradient_changes_the_real_file_as_it_says() -> None:
    target = smooth(4, 32, 32, grain_px=16, seed=1)
    images = smooth(4, 32, 32, grain_px=16, seed=2).requires_grad_()
    before = (jpeg(images, 75) - target).square().mean()
    (jpeg_differentiable(images, 75) - target).square().sum().backward()
    assert images.grad is not None
    after = (jpeg(images.detach() - 0.5 * images.grad, 75) - target).square().mean()
    assert float(after) < 0.7 * float(before)


@pytest.mark.parametrize("codec", [jpeg, jpeg_differentiable], ids=["true", "differentiable"])
def test_broken_images_are_refused(codec: Codec) -> None:
    with pytest.raises(ImageContractError, match="srgb: got"):
        codec(torch.zeros(3, 8, 8), 15)


def test_the_presets_squeeze_in_the_order_of_their_names() -> None:
    assert COMPRESSIONS["none"] is None
    small, heavy = COMPRESSIONS["small"], COMPRESSIONS["heavy"]
    assert small is not None
    assert heavy is not None
    assert small > heavy


both = pytest.mark.parametrize("codec", [jpeg, jpeg_differentiable], ids=["true", "differentiable"])


@both
@pytest.mark.parametrize("origin_px", [(0, 0), (3, 5), (16, 8), (1923, 14)], ids=str)
def test_blocks_lie_on_the_grid_of_the_frame(codec: Codec, origin_px: tuple[int, int]) -> None:
    # At quality 1 the blocks of a weak ramp keep little but their mean: it jumps between blocks.
    x, y = torch.meshgrid(torch.arange(45.0), torch.arange(37.0), indexing="xy")
    ramp = (0.2 + 0.004 * x + 0.003 * y).expand(1, 3, 37, 45)
    decoded = codec(ramp, 1, origin_px=origin_px)[0].mean(0)
    for axis, place in ((1, origin_px[0]), (0, origin_px[1])):
        jumps = decoded.diff(dim=axis).abs().amax(1 - axis)
        edges = (jumps > 0.5 * jumps.max()).nonzero().flatten() + 1
        assert {int(edge + place) % 8 for edge in edges} == {0}


@pytest.mark.parametrize("chroma", _CHROMAS)
def test_chroma_is_sampled_as_pillow_samples_it(chroma: str) -> None:
    image = smooth(1, 32, 48)
    file = io.BytesIO()
    pixels = (image[0] * 255).round().byte().permute(1, 2, 0).numpy()
    Image.fromarray(pixels).save(file, "JPEG", quality=60, subsampling=chroma)
    theirs = torch.from_numpy(np.asarray(Image.open(file)).copy()).permute(2, 0, 1) / 255
    assert float((jpeg(image, 60, chroma=chroma)[0] - theirs).abs().max()) * 255 <= 2.001


def test_fewer_samples_of_colour_lose_more() -> None:
    images = smooth(4, 48, 48)
    loss = [psnr_db(jpeg(images, 75, chroma=chroma), images) for chroma in _CHROMAS]
    assert loss == sorted(loss, reverse=True)


@pytest.mark.parametrize("chroma", _CHROMAS)
def test_the_stand_in_has_the_same_sampling(chroma: str) -> None:
    # Colours as detailed as luminance: with another sampling it would be 27 to 32 dB away.
    images = smooth(16, 48, 48)
    soft = jpeg_differentiable(images, 15, chroma=chroma)
    assert psnr_db(jpeg(images, 15, chroma=chroma), soft) > 37


def test_a_file_is_what_its_last_frame_becomes_however_often_it_is_compressed() -> None:
    frames = torch.stack([smooth(2, 24, 24, seed=seed) for seed in (0, 1)])
    assert torch.equal(Jpeg(60)(frames), jpeg(frames[1], 60))
    again = Jpeg([60, 30], "4:2:2")(frames, origin_px=(3, 1))
    once = jpeg(frames[1], 60, chroma="4:2:2", origin_px=(3, 1))
    assert torch.equal(again, jpeg(once, 30, chroma="4:2:2", origin_px=(3, 1)))
    soft = Jpeg([60, 30], "4:2:2")(frames, origin_px=(3, 1), differentiable=True)
    first = jpeg_differentiable(frames[1], 60, chroma="4:2:2", origin_px=(3, 1))
    assert torch.equal(soft, jpeg_differentiable(first, 30, chroma="4:2:2", origin_px=(3, 1)))


def test_settings_of_a_file_out_of_range_are_refused() -> None:
    with pytest.raises(InputError, match=r"qualities=\[\]: wanted at least one"):
        Jpeg([])
    with pytest.raises(InputError, match="qualities=0: wanted 1 to 100"):
        Jpeg([50, 0])
    with pytest.raises(InputError, match="chroma=4:1:1: wanted one of 4:4:4"):
        Jpeg(50, "4:1:1")
    for codec in (jpeg, jpeg_differentiable):
        with pytest.raises(InputError, match="chroma=4:1:1"):
            codec(smooth(1, 8, 8), 50, chroma="4:1:1")
    with pytest.raises(ImageContractError, match="srgb: got"):
        Jpeg(50)(torch.zeros(1, 1, 1, 8, 8))


@both
def test_a_quality_or_a_place_out_of_range_is_refused(codec: Codec) -> None:
    with pytest.raises(InputError, match="quality=101: wanted 1 to 100"):
        codec(smooth(1, 8, 8), 101)
    with pytest.raises(InputError, match="origin_px"):
        codec(smooth(1, 8, 8), 50, origin_px=(-1, 0))
    with pytest.raises(InputError, match="origin_px"):
        Jpeg(50)(smooth(1, 8, 8)[None], origin_px=(-1, 0))
