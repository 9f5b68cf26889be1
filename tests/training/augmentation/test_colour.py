import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.training.augmentation.colour import Colour, _colour_matrices

LUMA = torch.tensor([0.213, 0.715, 0.072])


def luma(faces: torch.Tensor) -> torch.Tensor:
    return torch.einsum("c,bchw->bhw", LUMA, faces)


def test_saturation_and_hue_are_those_of_the_w3c() -> None:
    """Filter Effects Module Level 1, 9.6: the matrices of saturate 0.5 and of hueRotate 180."""
    half, turned = _colour_matrices(np.array([0.5, 1.0]), np.array([0.0, 180.0]))
    assert half[0] == pytest.approx([0.6065, 0.3575, 0.036])
    assert turned[1] == pytest.approx([0.426, 0.43, 0.144])


def test_nothing_asked_nothing_changed(faces: torch.Tensor, rng: np.random.Generator) -> None:
    assert torch.allclose(Colour()(faces, rng), faces, atol=1e-6)


def test_hue_and_saturation_keep_the_luma(faces: torch.Tensor, rng: np.random.Generator) -> None:
    changed = Colour(saturation=0.4, hue_deg=30)(faces, rng)
    assert float((changed - faces).abs().max()) > 0.05
    assert torch.allclose(luma(changed), luma(faces), atol=2e-3)  # the standard rounds its numbers


def test_grey_faces_have_three_equal_channels_whatever_the_tint(
    faces: torch.Tensor, rng: np.random.Generator
) -> None:
    grey = Colour(tint=0.2, gain=0.2, grey_share=1.0)(faces, rng)
    assert torch.allclose(grey[:, 0], grey[:, 1], atol=1e-6)
    assert torch.allclose(grey[:, 0], grey[:, 2], atol=1e-6)


def test_gamma_keeps_black_and_white_and_the_order(rng: np.random.Generator) -> None:
    ramp = torch.linspace(0, 1, 16).expand(4, 3, 16, 16)
    toned = Colour(gamma=0.5)(ramp, rng)
    assert torch.allclose(toned[..., [0, -1]], ramp[..., [0, -1]], atol=1e-5)
    assert bool((toned[..., 1:] > toned[..., :-1]).all())


@pytest.mark.parametrize(
    ("setting", "times"),
    [("gain", 1.0), ("tint", 2**0.5), ("contrast", 1.0)],
)
def test_a_width_is_a_standard_deviation(setting: str, times: float) -> None:
    """Of 4000 faces of a dark and a bright half: the standard error of one is 1.1 %."""
    halves = torch.tensor([0.25, 0.75]).expand(4000, 3, 1, 2)
    changed = Colour(**{setting: 0.1})(halves, np.random.default_rng(0))
    measured = {
        "gain": changed.mean(dim=(1, 2, 3)),
        "tint": changed[:, 0].mean((1, 2)) / changed[:, 1].mean((1, 2)),
        "contrast": changed[:, 0, 0, 1] - changed[:, 0, 0, 0],
    }[setting]
    assert float(measured.log().std()) == pytest.approx(0.1 * times, rel=0.045)


def test_negative_widths_are_refused() -> None:
    with pytest.raises(InputError, match=r"degradation.colour.tint=-0.1: wanted 0 to 1"):
        Colour(tint=-0.1)
