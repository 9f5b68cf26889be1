from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from scipy.ndimage import convolve, gaussian_filter

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.presets import preset
from lrsr.training.shrinking import bsrgan
from lrsr.training.shrinking.bsrgan import Bsrgan

SHIPPED: Bsrgan = preset("degradation", "bsrgan")


def picture(image: torch.Tensor) -> Any:
    return np.ascontiguousarray(image.permute(1, 2, 0).numpy())


def drawn(seed: int = 0) -> np.random.Generator:
    return np.random.default_rng(seed)


@pytest.mark.parametrize(
    ("scale", "widest", "longest"), [(2, 2.4, 6.0), (4, 2.8, 8.0)], ids=["2x", "4x"]
)
def test_blurs_reach_as_far_as_in_the_paper(scale: int, widest: float, longest: float) -> None:
    """Section 3.1: widths up to 2.4 and 2.8 px, axes up to 6 and 8, at 2x and 4x."""
    assert SHIPPED.iso_width[0] + SHIPPED.iso_width[1] * scale == pytest.approx(widest)
    assert SHIPPED.aniso_variance[0] + SHIPPED.aniso_variance[1] * scale == longest
    assert (SHIPPED.noise_level, SHIPPED.jpeg_quality) == ((2, 25), (30, 95))


def test_an_anisotropic_kernel_has_its_variances_along_its_axes() -> None:
    kernel = bsrgan._gaussian(41, 3.0, 1.5, np.pi / 6)
    y, x = np.mgrid[-20:21, -20:21]
    found = [[(kernel * a * b).sum() for a in (x, y)] for b in (x, y)]
    cosine, sine = np.cos(np.pi / 6), np.sin(np.pi / 6)
    turn = np.array([[cosine, -sine], [sine, cosine]])
    assert np.array(found) == pytest.approx(turn @ np.diag([9.0, 2.25]) @ turn.T, abs=1e-3)
    assert kernel.sum() == pytest.approx(1)


def test_filters_are_scipys_with_a_mirror(pictures: torch.Tensor) -> None:
    given, kernel = picture(pictures[0]), bsrgan._gaussian(9, 2.0, 1.0, 0.4)
    wanted = convolve(given, kernel[..., None], mode="mirror")
    assert np.abs(bsrgan._filtered(given, kernel) - wanted).max() < 1e-5
    apart = bsrgan._filtered_apart(given, bsrgan._line(25, 1.5))
    wanted = gaussian_filter(given, (1.5, 1.5, 0), mode="mirror", radius=(12, 12, 0))
    assert np.abs(apart - wanted).max() < 1e-5


def test_a_sampled_picture_is_seen_amid_each_small_pixel() -> None:
    """A ramp keeps its values at the centres, 0.5 px right of each second pixel."""
    line = np.arange(32, dtype=np.float32)[None, :, None] / np.float32(40)
    ramp: Any = np.tile(line, (32, 1, 3))
    only = replace(SHIPPED, resize_prob=0.0, sampled_width=(0.8, 0.4))
    small = only._resized(ramp, 2, drawn())
    assert small.shape == (16, 16, 3)
    assert small[8, 4:12, 0] == pytest.approx((np.arange(4, 12) * 2 + 0.5) / 40, abs=1e-3)


def test_noise_is_grey_coloured_or_correlated_as_often_as_it_says() -> None:
    grey = np.full((32, 32, 3), 0.5, np.float32)
    loose, even = [], 0
    for seed in range(200):
        noise = SHIPPED._noisy(grey, 2, drawn(seed)) - grey
        correlation = np.corrcoef(noise.reshape(-1, 3).T)[np.triu_indices(3, 1)]
        if correlation.min() > 0.99:
            even += 1
        else:
            loose.append(float(np.abs(correlation).max()))
        assert noise.std() < 26 / 255
    assert even / 200 == pytest.approx(0.4, abs=0.1)
    assert np.mean([one > 0.12 for one in loose]) == pytest.approx(0.2 / 0.6, abs=0.12)


def test_the_last_resizing_comes_after_the_other(
    pictures: torch.Tensor, monkeypatch: pytest.MonkeyPatch
) -> None:
    sizes: list[int] = []
    for name in ("_resized", "_noisy"):
        step = getattr(Bsrgan, name)

        def noting(self: Bsrgan, given: Any, *more: Any, _step: Any = step) -> Any:
            sizes.append(given.shape[0])
            return _step(self, given, *more)

        monkeypatch.setattr(Bsrgan, name, noting)
    for seed in range(20):
        small = SHIPPED._degrade(picture(pictures[0]), 2, drawn(seed))
        assert small.shape == (24, 24, 3)
    assert max(sizes) == 48
    assert len(set(sizes)) > 5


def test_each_pictures_degradation_is_its_own(pictures: torch.Tensor) -> None:
    ((few, _),) = SHIPPED(pictures, 2, [5, 6, 7, 8], Camera())
    ((alone, _),) = SHIPPED(pictures[2:3], 2, [7], Camera())
    assert torch.equal(few[2:3], alone)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"jpeg_prob": 1.5}, "degradation.jpeg_prob=1.5: wanted 0 to 1"),
        ({"noise_level": (25, 2)}, r"degradation.noise_level=\[25,2\]: .* the least first"),
        ({"iso_width": (-1, 0)}, r"degradation.iso_width=\[-1,0\]: wanted 0 to 50"),
    ],
)
def test_what_cannot_be_drawn_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(SHIPPED, **wrong)
