"""ΔE00 against its authors' table and scikit-image."""

import json
from pathlib import Path

import numpy as np
import pytest
from skimage.color import deltaE_ciede2000, rgb2lab

from lrsr.camera.colour_difference import ciede2000, lab

PAIRS = json.loads((Path(__file__).parents[1] / "data" / "ciede2000.json").read_text())["pairs"]


@pytest.mark.parametrize("pair", PAIRS, ids=lambda pair: f"{pair[-1]:g}")
def test_the_authors_pairs(pair: list[float]) -> None:
    first, second = np.array(pair[:3]), np.array(pair[3:6])
    assert ciede2000(first, second) == pytest.approx(pair[6], abs=6e-5)
    assert ciede2000(second, first) == pytest.approx(pair[6], abs=6e-5)


def test_any_pair_is_as_far_apart_as_elsewhere() -> None:
    rng = np.random.default_rng(0)
    first, second = rng.uniform((0, -100, -100), (100, 100, 100), (2, 2000, 3))
    np.testing.assert_allclose(ciede2000(first, second), deltaE_ciede2000(first, second), atol=1e-9)


def test_equal_colours_do_not_differ() -> None:
    colours = np.array([[0.0, 0.0, 0.0], [50.0, 20.0, -30.0]])
    assert ciede2000(colours, colours).tolist() == [0.0, 0.0]


def test_lab_of_linear_light() -> None:
    srgb = np.random.default_rng(1).uniform(0, 1, (1, 50, 3))
    linear = np.where(srgb <= 0.04045, srgb / 12.92, ((srgb + 0.055) / 1.055) ** 2.4)
    np.testing.assert_allclose(lab(linear), rgb2lab(srgb), atol=0.02)
    assert lab(np.zeros(3)).tolist() == pytest.approx([0, 0, 0], abs=1e-9)
