"""Tiles change nothing, whatever the network; depth, grey and hidden colours come out right."""

import inspect
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.sr import Bicubic, Upscaler, load_upscaler
from lrsr.sr.large import enlarge, spread_colours
from lrsr.sr.networks import NETWORKS
from lrsr.sr.upscaler import Luminance, Repeated, Rgb
from lrsr.sr.weights import ENLARGED_BY, Card, write_weights

Pixels = np.ndarray


def noise(height: int, width: int, channels: int = 3, depth: type = np.uint16) -> Pixels:
    rng = np.random.default_rng(4)
    most = np.iinfo(depth).max
    return rng.integers(0, most, (height, width, channels), depth, endpoint=True)


def untiled(upscaler: Upscaler, pixels: Pixels) -> Pixels:
    return enlarge(upscaler, pixels, tile_px=None)


def ours(name: str, scale: int) -> Upscaler:
    """A small network of every kind that there is, with random weights."""
    kind = NETWORKS[name]
    known = inspect.signature(kind).parameters
    small = {"scale": scale, "blocks": 2, "features": 8}
    arguments = {key: value for key, value in small.items() if key in known}
    torch.manual_seed(3)
    network = kind(**arguments, **kind.in_use).eval()
    by = ENLARGED_BY if "scale" not in known else ""
    card = Card(name, arguments, scale, kind.input, lr_made_by="test", enlarged_by=by)
    return (Luminance if kind.input == "luminance" else Rgb)(network, card)


SEES_ALL = ("imdn", "sparnet")


@pytest.mark.parametrize("scale", [2, 4])
@pytest.mark.parametrize("name", sorted(NETWORKS.keys() - {*SEES_ALL, "fusion"}))
def test_a_networks_reach_is_where_tiles_change_nothing(name: str, scale: int) -> None:
    upscaler, pixels = ours(name, scale), noise(37, 50)
    assert upscaler.reach_px is not None
    tiled = enlarge(upscaler, pixels, tile_px=16).astype(int)
    assert np.abs(tiled - untiled(upscaler, pixels)).max() <= 1  # of 65535: float32's rounding


@pytest.mark.parametrize("name", SEES_ALL)
def test_a_network_that_sees_the_whole_picture_has_no_reach(name: str) -> None:
    network = NETWORKS[name](scale=2, blocks=2, features=16)
    assert network.reach_px is None
    pixels = torch.rand(1, 3, 96, 8, generator=torch.Generator().manual_seed(0))
    pixels.requires_grad_()
    network(pixels)[..., 0, :].sum().backward()
    assert pixels.grad is not None
    assert pixels.grad[..., 20:, :].abs().max() > 0


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_bicubic_tiles_change_nothing(scale: int) -> None:
    pixels = noise(29, 23)
    tiled = enlarge(Bicubic(scale), pixels, tile_px=16).astype(int)
    assert np.abs(tiled - untiled(Bicubic(scale), pixels)).max() <= 1


def test_what_ships_has_the_reach_of_the_paper_and_needs_all_of_it() -> None:
    """9-1-5 looks 6 enlarged pixels far, 3 of the small picture, and bicubic 2."""
    upscaler = load_upscaler(Path("weights/srcnn2x.safetensors"))
    assert upscaler.reach_px == 3 + 2
    assert Repeated(upscaler, 2).reach_px == 5 + 3
    pixels = noise(40, 40)
    short = enlarge(upscaler, pixels, tile_px=16, around_px=2).astype(int)
    assert np.abs(short - untiled(upscaler, pixels)).max() > 1


def test_a_repeated_step_is_tiled_without_seams() -> None:
    twice, pixels = Repeated(Bicubic(2), 2), noise(40, 33)
    tiled = enlarge(twice, pixels, tile_px=16).astype(int)
    assert np.abs(tiled - untiled(twice, pixels)).max() <= 1


def test_a_network_on_groups_of_pixels_sees_the_same_groups() -> None:
    class Groups(Bicubic):
        """Each 4 x 4 pixels become their mean: it matters where a tile begins."""

        multiple_of = 4
        reach_px: int | None = 3

        def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
            means = torch.nn.functional.avg_pool2d(srgb, 4)
            return means.repeat_interleave(4, -1).repeat_interleave(4, -2)

    pixels = noise(40, 36)
    upscaler = Groups(1)
    np.testing.assert_array_equal(enlarge(upscaler, pixels, tile_px=18), untiled(upscaler, pixels))


@pytest.mark.parametrize("depth", [np.uint8, np.uint16])
@pytest.mark.parametrize("channels", [1, 3])
def test_a_scale_of_one_returns_every_level(depth: type, channels: int) -> None:
    pixels = noise(20, 20, channels, depth)
    np.testing.assert_array_equal(enlarge(Bicubic(1), pixels, tile_px=16), pixels)


def test_grey_is_enlarged_as_grey_colours_are() -> None:
    grey = noise(12, 9, 1, np.uint8)
    coloured = enlarge(Bicubic(2), np.repeat(grey, 3, axis=2))
    assert np.abs(enlarge(Bicubic(2), grey) - coloured[..., :1].astype(int)).max() == 0


def test_a_tile_at_a_time_is_told_and_seen(edsr_file: Callable[..., Path]) -> None:
    seen: list[int] = []

    class Watched(Bicubic):
        def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
            seen.append(srgb.shape[-2] * srgb.shape[-1])
            return super()._enlarge(srgb)

    told: list[int] = []
    enlarge(Watched(2), noise(64, 64), tile_px=16, done=told.append)
    assert told == [256] * 16
    assert max(seen) == (16 + 2 + 2) ** 2


def test_a_network_that_fails_is_an_error(edsr_file: Callable[..., Path]) -> None:
    upscaler = load_upscaler(edsr_file(2))
    upscaler._network.tail.bias.fill_(float("nan"))  # type: ignore[attr-defined]
    with pytest.raises(InputError, match=r"\.safetensors\) makes no numbers"):
        enlarge(upscaler, noise(8, 8))


def test_hidden_colours_take_that_of_the_nearest_seen() -> None:
    pixels, opacity = noise(6, 9, 3, np.uint8), np.zeros((6, 9, 1), np.uint8)
    opacity[2, 3], opacity[2, 8] = 255, 1
    spread = spread_colours(pixels, opacity)
    assert (spread[:, :5] == pixels[2, 3]).all()
    assert (spread[:, 7:] == pixels[2, 8]).all()


@pytest.mark.parametrize("level", [0, 7])
def test_where_all_or_nothing_is_hidden_nothing_changes(level: int) -> None:
    pixels = noise(3, 4, 3, np.uint8)
    assert spread_colours(pixels, np.full((3, 4, 1), level, np.uint8)) is pixels


def test_weights_of_ours_carry_their_reach(tmp_path: Path) -> None:
    card = Card("edsr", {"scale": 2, "blocks": 3, "features": 8}, 2, "rgb", lr_made_by="test")
    network = NETWORKS["edsr"](**card.arguments)
    write_weights(tmp_path / "w.safetensors", network, card)
    # head, two of each block, after, enlarge, tail: 3 x 3 each
    assert load_upscaler(tmp_path / "w.safetensors").reach_px == 1 + 2 * 3 + 1 + 1 + 1
