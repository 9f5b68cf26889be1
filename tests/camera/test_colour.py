"""Filters that overlap, white that is balanced, and colours that come back."""

from typing import Any

import pytest
import torch
from torch.autograd import gradcheck

from lrsr.camera.colour import _IDENTITY, Colour, _mix
from lrsr.errors import ImageContractError, InputError

OVERLAP = ((0.45, 0.12, 0.02), (0.15, 0.75, 0.10), (0.03, 0.15, 0.50))


def light(batch: int = 2, height: int = 4, width: int = 5) -> torch.Tensor:
    return torch.rand(batch, 3, height, width, generator=torch.Generator().manual_seed(0))


def pixel(*rgb: float) -> torch.Tensor:
    return torch.tensor(rgb)[None, :, None, None]


def test_a_matrix_mixes_as_einsum_does() -> None:
    wanted = torch.einsum("dc,bchw->bdhw", torch.tensor(OVERLAP), light())
    assert torch.allclose(_mix(light(), OVERLAP), wanted)


def test_colours_come_back_when_the_matrix_fits_the_filters() -> None:
    colour = Colour(OVERLAP)
    assert torch.allclose(colour(colour.filter(light())), light(), atol=1e-6)


def test_the_rows_of_the_matrix_sum_to_one_so_that_grey_stays_grey() -> None:
    assert torch.tensor(Colour(OVERLAP).matrix).sum(1).tolist() == pytest.approx([1, 1, 1])


def test_a_cast_tints_grey_by_its_gains() -> None:
    colour = Colour(cast=(1.1, 1.0, 0.8))
    assert colour(pixel(0.5, 0.5, 0.5)).flatten().tolist() == pytest.approx([0.55, 0.5, 0.4])


def test_gains_and_matrix_that_are_given_are_used_as_they_are() -> None:
    colour = Colour(OVERLAP, cast=(9, 9, 9), white_balance=(2, 1, 1), matrix=_IDENTITY)
    assert colour(pixel(0.2, 0.3, 0.4)).flatten().tolist() == pytest.approx([0.4, 0.3, 0.4])


def test_what_is_brighter_than_white_in_all_channels_becomes_white() -> None:
    colour = Colour(OVERLAP)
    assert colour(colour.filter(pixel(3.0, 2.0, 1.5))).flatten().tolist() == pytest.approx([1] * 3)


def test_more_overlap_means_more_noise() -> None:
    noise = 0.5 + 0.01 * torch.randn(1, 3, 64, 64, generator=torch.Generator().manual_seed(1))
    # Independent noise grows by the root of the sum of squares of each row of matrix times gains.
    colour = Colour(OVERLAP)
    gains = torch.tensor(colour.matrix) * torch.tensor(colour.white_balance)
    raw = noise / torch.tensor(colour.white_balance)[:, None, None] * 0.5
    raw = (
        raw + (noise - 0.5) - (noise - 0.5) / 2 / torch.tensor(colour.white_balance)[:, None, None]
    )
    wanted = 0.01 * gains.square().sum(1).sqrt()
    assert torch.allclose(colour(raw).std(dim=(0, 2, 3)), wanted, rtol=0.05)


def test_finite_differences_agree_with_the_gradient() -> None:
    colour = Colour(OVERLAP, cast=(1.05, 1, 0.9))
    image = (0.6 * light(1, 3, 2)).double().requires_grad_()
    assert gradcheck(lambda x: colour(colour.filter(x)), image)


@pytest.mark.parametrize(
    ("what", "message"),
    [
        ({"responses": ((1, 0, 0), (1, 0, 0), (0, 0, 1))}, "responses=.*: wanted independent rows"),
        ({"responses": ((1, 0), (0, 1))}, "responses=.*: wanted three rows of three numbers"),
        ({"responses": ((-1, 0, 0), (0, 1, 0), (0, 0, 1))}, "responses=.*sums > 0"),
        ({"cast": (1, 0, 1)}, "cast=.*: wanted three gains > 0"),
        ({"white_balance": (1, 1)}, "white_balance=.*: wanted three gains > 0"),
        ({"matrix": ((1,),)}, "matrix=.*: wanted three rows"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_settings_out_of_range_are_refused(what: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Colour(**what)


def test_broken_light_is_refused() -> None:
    for function in (Colour(), Colour().filter, lambda x: _mix(x, _IDENTITY)):
        with pytest.raises(ImageContractError, match="got shape"):
            function(torch.zeros(1, 1, 2, 2))
