from typing import Any

import numpy as np
import pytest
import torch
from fakes.lessons import everything

from lrsr.errors import InputError
from lrsr.training.augmentation.blur import Blur
from lrsr.training.augmentation.occlusion import Occlusion
from lrsr.training.degradation import Degradation

SHARP = torch.ones(6, dtype=torch.bool)


def faces(count: int = 6) -> torch.Tensor:
    smooth = torch.nn.functional.interpolate(
        torch.rand(count, 3, 20, 20, generator=torch.Generator().manual_seed(0)), size=(112, 112)
    )
    return smooth.mul(255).to(torch.uint8)


def detail(images: torch.Tensor) -> float:
    return float((images[..., 1:] - images[..., :-1]).abs().mean())


def test_the_same_numbers_give_the_same_faces() -> None:
    one, two, other = (everything()(faces(), SHARP, np.random.default_rng(s)) for s in (3, 3, 4))
    assert torch.equal(one, two)
    assert not torch.equal(one, other)


def test_training_in_bfloat16_sees_the_same_faces() -> None:
    full = everything()(faces(), SHARP, np.random.default_rng(3))
    with torch.autocast("cpu", dtype=torch.bfloat16):
        assert torch.equal(everything()(faces(), SHARP, np.random.default_rng(3)), full)


def test_the_result_keeps_the_image_contract() -> None:
    result = everything()(faces(), SHARP, np.random.default_rng(0))
    assert (result.shape, result.dtype) == ((6, 3, 112, 112), torch.float32)
    assert float(result.min()) >= 0
    assert float(result.max()) <= 1


def test_switched_off_it_only_mirrors() -> None:
    still = Degradation(small_share=0.0)
    result = still(faces(), SHARP, np.random.default_rng(0))
    original = faces().float() / 255
    for face, source in zip(result, original, strict=True):
        same = float((face - source).abs().max())
        mirrored = float((face - source.flip(-1)).abs().max())
        assert min(same, mirrored) < 1e-4


def test_a_smaller_face_has_less_detail() -> None:
    details = []
    for ipd in (6.0, 12.0, 30.0):
        make = Degradation(ipd_px=(ipd, ipd), small_share=1.0, jpeg_share=0.0, bicubic_share=0.0)
        details.append(detail(make(faces(), SHARP, np.random.default_rng(0))))
    assert details == sorted(details)
    assert details[0] < 0.5 * details[2]


@pytest.mark.parametrize("bicubic_share", [0.0, 1.0], ids=["bilinear", "bicubic"])
def test_a_small_face_stays_where_it_was(bicubic_share: float) -> None:
    """Whatever the pixel grid's phase: the centre of mass of a blob moves by less than 0.3 px."""
    y, x = torch.meshgrid(torch.arange(112.0), torch.arange(112.0), indexing="ij")
    blob = torch.exp(-((x - 55.5) ** 2 + (y - 48) ** 2) / (2 * 9**2))
    crops = blob.expand(6, 3, 112, 112).mul(255).round().to(torch.uint8)
    make = Degradation(ipd_px=(8, 8), small_share=1.0, jpeg_share=0.0, bicubic_share=bicubic_share)
    result = make(crops, SHARP, np.random.default_rng(1))[:, 0]
    mass = result.sum(dim=(1, 2))
    assert float(((result * y).sum(dim=(1, 2)) / mass - 48).abs().max()) < 0.3
    assert float(((result * x).sum(dim=(1, 2)) / mass - 55.5).abs().max()) < 0.3


def test_small_renderings_are_never_made_smaller_hidden_or_blurred() -> None:
    make = Degradation(
        small_share=1.0,
        jpeg_share=1.0,
        occlusion=Occlusion(1.0),
        blur=Blur(1.0, sigma=(0.1, 0.1)),
    )
    result = make(faces(), ~SHARP, np.random.default_rng(0))
    assert detail(result) == pytest.approx(detail(faces().float() / 255), rel=1e-3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"small_share": 1.5}, "degradation.small_share=1.5: wanted 0 to 1"),
        (
            {"ipd_px": (32, 6)},
            r"degradation.ipd_px=\[32,6\]: wanted 1 to 35.2.*, the least first",
        ),
        ({"jpeg_quality": (0, 95)}, r"degradation.jpeg_quality=\[0,95\]: wanted 1 to 100"),
        ({"noise": -0.1}, "degradation.noise=-0.1: wanted 0 to 1"),
        ({"group": 0}, "degradation.group=0: wanted 1 to 4096"),
    ],
    ids=str,
)
def test_an_impossible_degradation_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Degradation(**wrong)
