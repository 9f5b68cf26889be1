"""What a network that fuses is shown of a burst, and how it is read and refused."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from oracles.waves import picture, shifted

from lrsr.errors import InputError
from lrsr.sr import Mean, load_fusion, load_upscaler
from lrsr.sr.learned_fusion import laid_over

Write = Callable[..., Path]


def burst(*steps: tuple[float, float]) -> tuple[torch.Tensor, torch.Tensor]:
    motions = torch.stack([shifted(*step) for step in steps]).float()[None]
    return torch.stack([picture(12, one) for one in motions[0]])[None], motions


def test_near_is_one_at_the_centre_of_a_pixel_and_a_quarter_amid_four() -> None:
    frames, motions = burst((0, 0), (0.5, 0.5), (0.5, 0))
    near = laid_over(frames, motions, 1)[0, :, 3, 4, 4]
    torch.testing.assert_close(near, torch.tensor([1.0, 0.25, 0.5]))


def test_colours_are_those_that_the_mean_is_made_of() -> None:
    frames, motions = burst((0, 0), (0.3, -0.4))
    laid = torch.nn.functional.pixel_shuffle(laid_over(frames, motions, 2), 2)
    reaches = laid[:, :, 3:] > 0
    mean = (laid[:, :, :3] * reaches).sum(1) / reaches.sum(1)
    told = type("Told", (), {"__call__": lambda *_: motions, "describe": lambda _: {}})()
    torch.testing.assert_close(Mean(2, told)(frames), mean.clamp(0, 1))


def test_where_a_frame_does_not_reach_all_is_zero() -> None:
    frames, motions = burst((0, 0), (3, 0), (0, 0))
    motions[:, 2] = torch.nan
    laid = laid_over(frames, motions, 1)[0]
    assert (laid[0, 3] > 0).all()
    assert (laid[1, 3, :, :9] > 0).all()
    assert not laid[1, :, :, 9:].any()
    assert not laid[2].any()


def test_a_file_of_training_fuses_and_says_what_it_is(network_file: Write) -> None:
    fuse = load_fusion(network_file("fusion", 2), label="Ours")
    frames, _ = burst((0, 0), (0.2, 0.1), (-0.3, 0.2))
    fused = fuse(frames)
    assert fused.shape == (1, 3, 24, 24)
    assert float((fused - Mean(2)(frames)).abs().max()) < 0.05  # begins there
    told = fuse.describe()
    assert (told["label"], told["scale"], told["kind"], fuse.learned) == ("Ours", 2, "fusion", True)
    assert told["file"] == "fusion2x.safetensors"


def test_a_burst_and_a_single_picture_are_not_mistaken_for_each_other(network_file: Write) -> None:
    with pytest.raises(InputError, match="edsr takes rgb, not a burst: give it to sr="):
        load_fusion(network_file("edsr", 2))
    with pytest.raises(InputError, match="fusion takes burst"):
        load_upscaler(network_file("fusion", 2))
