"""Bursts of a scene that is known by formula: what fusing gains, and what it withstands."""

import json
from typing import Any

import pytest
import torch
from oracles.waves import picture, shifted
from torch.nn import functional as F

from lrsr.errors import ImageContractError, InputError
from lrsr.images import scale_points
from lrsr.resampling import sample_bicubic
from lrsr.sr import Bicubic, Mean, ShiftAndAdd
from lrsr.sr.fusion import lay_over, pixels_through

SIDE, SCALE = 16, 2
STEPS = [(0.0, 0.0), (0.5, 0.1), (-0.1, 0.5), (0.45, -0.5), (-0.5, -0.2), (0.2, 0.3)]
MOTIONS = torch.stack([shifted(*step) for step in STEPS]).float()[None]


class Told:
    """Registration by motions that are known."""

    def __init__(self, motions: torch.Tensor) -> None:
        self.motions = motions

    def __call__(
        self, srgb: torch.Tensor, landmarks_px: torch.Tensor | None = None
    ) -> torch.Tensor:
        few: torch.Tensor = self.motions[:, : srgb.shape[1]]
        return few.expand(len(srgb), -1, -1, -1)

    def describe(self) -> dict[str, object]:
        return {"by": "a test"}


STILL = Told(torch.eye(2, 3).repeat(1, 64, 1, 1))
KNOWN = Told(MOTIONS)


@pytest.fixture(scope="module")
def frames() -> torch.Tensor:
    return torch.stack([picture(SIDE, one) for one in MOTIONS[0]])[None]


@pytest.fixture(scope="module")
def true() -> torch.Tensor:
    return picture(SIDE, finer=SCALE, blur_px=0.5 / SCALE)[None]


def psnr_db(picture: torch.Tensor, true: torch.Tensor) -> float:
    """Within six pixels of the border."""
    return float(-10 * torch.log10((picture - true)[..., 6:-6, 6:-6].square().mean()))


def test_the_mean_of_one_frame_is_its_bicubic(frames: torch.Tensor) -> None:
    for scale in (1, 2, 4):
        torch.testing.assert_close(
            Mean(scale)(frames[:, :1]), Bicubic(scale)(frames[:, 0]), atol=1e-5, rtol=0
        )


def test_the_mean_of_n_frames_has_noise_lower_by_the_root_of_n() -> None:
    noise = torch.randn(2, 16, 3, 24, 24, generator=torch.Generator().manual_seed(0))
    noisy = 0.5 + 0.02 * noise
    deviations = {n: float(Mean(1, STILL)(noisy[:, :n]).std()) for n in (1, 4, 16)}
    assert deviations[1] == pytest.approx(0.02, rel=0.05)
    assert deviations[1] / deviations[4] == pytest.approx(2, rel=0.05)
    assert deviations[1] / deviations[16] == pytest.approx(4, rel=0.05)


def test_shift_and_add_recovers_what_no_single_frame_holds(
    frames: torch.Tensor, true: torch.Tensor
) -> None:
    enlarged = psnr_db(Bicubic(SCALE)(frames[:, 0]), true)
    alone = psnr_db(ShiftAndAdd(SCALE)(frames[:, :1]), true)
    fused = psnr_db(ShiftAndAdd(SCALE)(frames), true)  # registered by itself
    assert psnr_db(Mean(SCALE, KNOWN)(frames), true) < enlarged + 1
    assert alone > enlarged + 1
    assert fused > alone + 3


def test_one_bad_frame_harms_the_mean_and_hardly_the_sum_of_deviations(
    frames: torch.Tensor, true: torch.Tensor
) -> None:
    spoilt = frames.clone()
    spoilt[:, 3] = 1 - spoilt[:, 3]
    bicubic = psnr_db(Bicubic(SCALE)(frames[:, 0]), true)
    assert psnr_db(Mean(SCALE, KNOWN)(spoilt), true) < bicubic - 2
    assert psnr_db(ShiftAndAdd(SCALE, KNOWN)(spoilt), true) > bicubic + 1


def test_the_same_frame_again_tells_nothing_new(frames: torch.Tensor) -> None:
    fuse = ShiftAndAdd(SCALE, STILL, iterations=10)
    again = frames[:, :1].repeat(1, 3, 1, 1, 1)
    torch.testing.assert_close(fuse(again), fuse(frames[:, :1]), atol=1e-4, rtol=0)


@pytest.mark.parametrize("kind", [Mean, ShiftAndAdd])
def test_a_frame_that_could_not_be_registered_counts_nowhere(
    kind: type[Mean | ShiftAndAdd], frames: torch.Tensor
) -> None:
    lost = MOTIONS.clone()
    lost[:, 2] = torch.nan
    rest = [0, 1, 3, 4, 5]
    torch.testing.assert_close(
        kind(SCALE, Told(lost))(frames),
        kind(SCALE, Told(MOTIONS[:, rest]))(frames[:, rest]),
        atol=1e-4,
        rtol=0,
    )


def test_a_frame_does_not_count_where_it_does_not_reach() -> None:
    ramp = torch.linspace(0, 1, 8).expand(1, 1, 3, 8, 8)
    laid = lay_over(
        ramp.repeat(1, 2, 1, 1, 1), torch.stack([shifted(0, 0), shifted(3, 0)])[None].float(), 1
    )
    assert torch.equal(laid[0, 0], ramp[0, 0])
    torch.testing.assert_close(laid[0, 1, 0, 0, :5], ramp[0, 0, 0, 0, 3:], atol=1e-6, rtol=0)
    assert laid[0, 1, :, :, 5:].isnan().all()


def test_a_step_goes_down_the_slope_that_autograd_finds() -> None:
    generator = torch.Generator().manual_seed(0)
    bursts = 0.3 + 0.4 * torch.rand(1, 2, 3, 6, 5, generator=generator)
    motions = torch.stack([shifted(0, 0), shifted(0.3, -0.6)])[None].float()
    given = lay_over(bursts, motions, 2).nanquantile(0.5, dim=1).requires_grad_()
    kernel = torch.exp(-0.5 * (torch.arange(-4, 5) / 1.0) ** 2)
    kernel = (kernel / kernel.sum()).expand(3, 1, 1, -1)
    padded = F.pad(given, (4,) * 4, mode="replicate")
    blurred = F.conv2d(F.conv2d(padded, kernel, groups=3), kernel.mT, groups=3)
    back = torch.stack([shifted(0, 0), shifted(-0.3, 0.6)])[None].float()
    places = scale_points(pixels_through(back, (6, 5)), 2)[0]
    seen = sample_bicubic(blurred.expand(2, -1, -1, -1), places[:, None])
    total = 4 * (seen - bursts[0]).abs().sum() / 2
    for right, down in ((1, 0), (0, 1), (1, 1), (-1, 1)):
        here = given[..., down:, max(0, right) : 10 + min(0, right)]
        there = given[..., : 12 - down, max(0, -right) : 10 - max(0, right)]
        total = total + 0.05 * 0.6 ** (abs(right) + down) * (here - there).abs().sum()
    (slope,) = torch.autograd.grad(total, given)
    fused = ShiftAndAdd(2, Told(motions), reach=1, iterations=1, step=0.01)(bursts)
    torch.testing.assert_close(fused, given.detach() - 0.01 * slope, atol=1e-6, rtol=0)


def test_every_burst_of_a_batch_is_fused_by_itself(frames: torch.Tensor) -> None:
    fuse = ShiftAndAdd(SCALE, KNOWN, iterations=3)
    both = torch.cat([frames, frames.flip(-1)])
    torch.testing.assert_close(fuse(both)[:1], fuse(frames), atol=1e-5, rtol=0)


@pytest.mark.parametrize("kind", [Mean, ShiftAndAdd])
def test_what_is_no_burst_is_refused(kind: type[Mean | ShiftAndAdd]) -> None:
    fuse = kind(2, STILL)
    with pytest.raises(ImageContractError, match=r"got Tensor \(2, 3, 8, 8\), wanted a torch"):
        fuse(torch.zeros(2, 3, 8, 8))
    with pytest.raises(ImageContractError, match=r"got Tensor \(1, 0, 3, 8, 8\), wanted"):
        fuse(torch.zeros(1, 0, 3, 8, 8))
    with pytest.raises(ImageContractError, match="bursts: got values 2 to 2"):
        fuse(torch.full((1, 2, 3, 8, 8), 2.0))


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"scale": 0}, "scale=0: wanted 1 to 16"),
        ({"blur_px": 0}, "blur_px=0: wanted above 0"),
        ({"weight": -1}, "weight=-1: wanted 0 or more"),
        ({"decay": 2}, "decay=2: wanted 0 to 1"),
        ({"step": 0}, "step=0: wanted above 0"),
        ({"reach": 5}, "reach=5: wanted 1 to 4"),
        ({"iterations": 0}, "iterations=0: wanted at least 1"),
    ],
    ids=str,
)
def test_numbers_out_of_range_are_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        ShiftAndAdd(**{"scale": 2, **wrong})


def test_a_fusion_says_all_that_a_report_must() -> None:
    told = json.loads(json.dumps(ShiftAndAdd(4, weight=0.1).describe()))
    assert (told["scale"], told["weight"], told["registration"]["motion"]) == (4, 0.1, "rigid")
    assert Mean(2, STILL).describe()["registration"] == {"by": "a test"}
