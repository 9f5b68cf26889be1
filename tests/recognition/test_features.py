"""Features that were not learned: against their definitions, written out slowly."""

import cmath
import math

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from lrsr.errors import ImageContractError
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.recognition.features import (
    FEATURES,
    Features,
    _gabor_spectra,
    gabor_magnitudes,
    local_binary_patterns,
    local_phase_quantisation,
    oriented_gradients,
)
from lrsr.recognition.recognisers import find_recognisers, load_recognisers

LANDMARKS = TEMPLATE_PX[None]


def picture(seed: int) -> np.ndarray:
    noise = gaussian_filter(np.random.default_rng(seed).normal(size=(112, 112)), 3)
    return np.clip(128 + 400 * noise, 0, 255).astype(np.uint8)


def faces(*seeds: int) -> torch.Tensor:
    levels = np.stack([picture(seed) for seed in seeds]) / 255
    return torch.from_numpy(np.repeat(levels[:, None], 3, axis=1).astype(np.float32))


def test_a_flat_face_has_one_pattern_of_each_kind() -> None:
    flat = np.full((112, 112), 90, dtype=np.uint8)
    for describe, bins in ((local_binary_patterns, 59), (local_phase_quantisation, 256)):
        found = describe(flat).reshape(49, bins)
        assert found.sum() == pytest.approx(1)
        inner = found.reshape(7, 7, bins)[1:-1, 1:-1]
        assert (inner.max(axis=-1) > 0.5 / 49).all()
    assert not oriented_gradients(flat).any()


def test_local_binary_patterns_are_bright_neighbours_on_a_circle() -> None:
    levels = np.full((112, 112), 100, dtype=np.uint8)
    levels[:, 56:] = 200  # all right of it is brighter
    found = local_binary_patterns(levels).reshape(7, 7, 59)
    region = found[3, 3]  # columns 48 to 63: 54 and 55 see the edge
    assert np.count_nonzero(region) in (2, 3)
    assert region.max() == pytest.approx(14 / 16 / 49)  # the 14 columns that see none


def test_phase_quantisation_is_that_of_the_definition() -> None:
    levels = picture(3)
    counts = np.zeros((7, 7, 256))
    frequencies = [(0, 1 / 7), (1 / 7, 0), (1 / 7, 1 / 7), (1 / 7, -1 / 7)]  # down, across
    for y in range(16, 32):
        for x in range(16, 32):
            code, bit = 0, 0
            for down, across in frequencies:
                total = sum(
                    int(levels[y - i, x - j]) * cmath.exp(-2j * math.pi * (down * i + across * j))
                    for i in range(-3, 4)
                    for j in range(-3, 4)
                )
                for part in (total.real, total.imag):
                    code |= (part >= 0) << bit
                    bit += 1
            counts[1, 1, code] += 1
    found = local_phase_quantisation(levels).reshape(7, 7, 256)
    np.testing.assert_allclose(found[1, 1], counts[1, 1] / 112**2)


def test_wavelets_answer_to_their_own_wave() -> None:
    x = np.arange(112)
    grating = np.round(127 + 100 * np.sin(2 * np.pi * 0.125 * x)) * np.ones((112, 1))
    plain = grating.astype(np.uint8)
    for levels, turn in ((plain, 0), (np.ascontiguousarray(plain.T), 4)):
        image = np.fft.fft2(levels / 255.0, (224, 224))
        energy = [
            np.abs(np.fft.ifft2(image * spectrum))[
                top + 40 : top + 72, left + 40 : left + 72
            ].mean()
            for spectrum, (top, left) in _gabor_spectra()
        ]
        assert int(np.argmax(energy)) == 2 * 8 + turn  # 0.25 / √2² = 0.125 cycles per px


def test_brightness_and_contrast_change_no_wavelets_face() -> None:
    levels = picture(2)
    np.testing.assert_allclose(
        gabor_magnitudes(levels // 2 * 2), gabor_magnitudes(levels // 2), atol=0.05
    )


@pytest.mark.parametrize("name", FEATURES)
def test_a_face_is_most_like_itself_and_no_face_has_no_score(name: str) -> None:
    recogniser = load_recognisers(find_recognisers([name]))[name]
    rows = recogniser.embed(faces(1, 2, 3), np.concatenate([LANDMARKS] * 2 + [LANDMARKS * np.nan]))
    assert np.isnan(rows).all(axis=1).tolist() == [False, False, True]
    scores = recogniser.compare(rows.astype(np.float64), rows[:2].astype(np.float64), "abc", "ab")
    (tile,) = scores.tiles()
    np.testing.assert_allclose(np.diag(tile.scores[:2]), 1, atol=1e-4)
    assert (tile.scores[[0, 1], [1, 0]] < 0.95).all()
    assert np.isnan(tile.scores[2]).all()
    assert recogniser.describe()["features"] == name


def test_broken_pictures_are_refused() -> None:
    with pytest.raises(ImageContractError, match="srgb"):
        Features("lbp").embed(faces(1) * 2, LANDMARKS)
