import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter, uniform_filter1d

from lrsr.errors import InputError
from lrsr.recognition.alignment import TEMPLATE_IPD_PX
from lrsr.training.augmentation.blur import Blur


def test_defocus_is_scipys_gaussian(faces: torch.Tensor, rng: np.random.Generator) -> None:
    sigma = 0.05
    blurred = Blur(1.0, sigma=(sigma, sigma))(faces, rng)[0, 0].numpy()
    wanted = gaussian_filter(
        faces[0, 0].numpy().astype(float), sigma * TEMPLATE_IPD_PX, mode="nearest", truncate=3.4
    )
    assert np.abs(blurred - wanted).max() < 1e-3


def test_motion_spreads_as_a_path_does(rng: np.random.Generator) -> None:
    """A point that moves by 9 px: SciPy's running mean has the same variance, in any direction."""
    point = torch.zeros(1, 1, 112, 112)
    point[..., 56, 56] = 1
    length = 9 / TEMPLATE_IPD_PX
    moved = Blur(1.0, motion_share=1.0, motion=(length, length))(point, rng)[0, 0].numpy()
    y, x = np.mgrid[:112, :112] - 56
    line = np.zeros(41)
    line[20] = 1
    path = uniform_filter1d(line, 9)
    assert (moved * (x**2 + y**2)).sum() == pytest.approx(
        (path * (np.arange(41) - 20) ** 2).sum(), rel=0.05
    )


def test_an_even_picture_stays(rng: np.random.Generator) -> None:
    even = torch.full((4, 3, 112, 112), 0.3)
    blurred = Blur(1.0, sigma=(0.01, 0.1), motion_share=0.5, motion=(0.1, 0.3))(even, rng)
    assert torch.allclose(blurred, even, atol=1e-6)


@pytest.mark.parametrize("settings", [{}, {"share": 1.0}], ids=["none", "of no width"])
def test_no_blur_changes_nothing(
    settings: dict[str, float], faces: torch.Tensor, rng: np.random.Generator
) -> None:
    assert torch.allclose(Blur(**settings)(faces, rng), faces, atol=1e-6)


def test_the_share_is_that_of_the_blurred(rng: np.random.Generator) -> None:
    noise = torch.rand(400, 1, 112, 112, generator=torch.Generator().manual_seed(0))
    blurred = Blur(0.25, sigma=(0.02, 0.02))(noise, rng)
    share = float((blurred != noise).flatten(1).any(1).float().mean())
    assert share == pytest.approx(0.25, abs=3 * (0.25 * 0.75 / 400) ** 0.5)


def test_a_span_upside_down_is_refused() -> None:
    with pytest.raises(InputError, match=r"degradation.blur.sigma=\[0.1,0\]: .* the least first"):
        Blur(sigma=(0.1, 0.0))
