import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.color import rgb2lab

from lrsr.identities.skin import tone


def _lab(colour: NDArray[np.float64]) -> NDArray[np.float64]:
    encoded = np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1 / 2.4) - 0.055)
    return rgb2lab(encoded)


def test_blood_absorbs_as_worked_by_hand_at_540_nm() -> None:
    # 0.75 * 53236 + 0.25 * 46592 = 51575 per molar and cm; times ln 10 * 150 / 64500, per mm
    at_540 = tone._blood_absorption()[14]
    assert at_540 == pytest.approx(51575 * 2.302585 * 150 / 64500 / 10, rel=1e-6)
    assert at_540 == pytest.approx(27.62, abs=0.01)


def test_melanin_absorbs_as_worked_by_hand_at_500_nm() -> None:
    # eumelanin 6.6e10 * 500^-3.33 = 67.94, pheomelanin 2.9e14 * 500^-4.75 = 43.89, 93 : 7
    assert tone._melanin_absorption(500.0) == pytest.approx(0.93 * 67.94 + 0.07 * 43.89, rel=1e-3)


def test_baseline_absorbs_as_worked_by_hand_at_500_nm() -> None:
    assert tone._baseline_absorption(500.0) == pytest.approx(
        0.0244 + 8.53 * np.exp(-5.2266), rel=1e-4
    )


def test_diffuse_reflectance_is_jensens_formula_worked_by_hand() -> None:
    # albedo 0.99: root sqrt(0.03); index 1.4: Fdr 0.52949, A 3.2507
    assert tone._diffuse_reflectance(0.99) == pytest.approx(0.6128, abs=2e-4)


def test_a_white_surface_is_white_under_d65() -> None:
    np.testing.assert_allclose(tone._spectrum_to_linear_srgb(np.ones(31)), 1.0, atol=5e-3)


def test_a_red_filter_is_red() -> None:
    red, green, blue = tone._spectrum_to_linear_srgb((tone.WAVELENGTHS_NM > 600).astype(float))
    assert red > 0.5
    assert abs(green) < 0.1
    assert abs(blue) < 0.05


@pytest.mark.parametrize("blood", [0.013, 0.022, 0.05])
def test_more_melanin_is_darker_in_every_channel(blood: float) -> None:
    colours = tone._tone(np.geomspace(0.009, 0.32, 20), blood)
    assert (np.diff(colours, axis=0) < 0).all()


@pytest.mark.parametrize("melanin", [0.009, 0.05, 0.32])
def test_more_blood_is_redder_and_darker(melanin: float) -> None:
    colours = tone._tone(melanin, np.geomspace(0.005, 0.2, 20))
    assert (np.diff(colours[:, 0] / colours[:, 1]) > 0).all()
    assert (np.diff(colours.sum(axis=1)) < 0).all()


def test_reflectance_stays_physical() -> None:
    melanin, blood = np.meshgrid([0.0, 0.01, 0.5, 1.0], [0.0, 0.02, 1.0])
    spectra = tone.skin_reflectance(melanin, blood)
    assert spectra.shape == (3, 4, 31)
    assert spectra.min() >= 0
    assert spectra.max() < 1


@pytest.mark.parametrize(
    ("melanin", "lightness"),
    [(0.009, (60, 72)), (0.022, (58, 70)), (0.045, (52, 66)), (0.22, (28, 45))],
    ids=["very fair", "european mean", "asian mean", "african mean"],
)
def test_tones_lie_in_the_gamut_of_human_skin(melanin: float, lightness: tuple[int, int]) -> None:
    light, a, b = _lab(tone._tone(melanin, 0.022))
    assert lightness[0] < light < lightness[1]
    assert 6 < a < 24
    assert 8 < b < 32


def test_table_agrees_with_the_exact_tone_within_one_percent() -> None:
    rng = np.random.default_rng(0)
    melanin = np.log(np.geomspace(0.0021, 0.59, 64))[rng.permutation(64)].astype(np.float32)
    blood = np.log(np.geomspace(0.0021, 0.39, 50))[rng.permutation(50)].astype(np.float32)
    rows, columns = np.meshgrid(melanin, blood, indexing="ij")
    exact = tone._tone(np.exp(rows), np.exp(columns))
    np.testing.assert_allclose(tone.tone_map(rows, columns), exact, rtol=0.012)


def test_table_clamps_what_lies_beyond_it() -> None:
    low, high = tone._MELANIN_RANGE
    beyond = np.log(np.array([[low / 100, high * 100]], dtype=np.float32))
    blood = np.full((1, 2), np.log(0.02), dtype=np.float32)
    ends = np.log(np.array([[low, high]], dtype=np.float32))
    np.testing.assert_array_equal(tone.tone_map(beyond, blood), tone.tone_map(ends, blood))


def test_carotene_takes_blue_and_leaves_red() -> None:
    melanin, blood = (np.full((1, 1), np.log(0.022), dtype=np.float32) for _ in range(2))
    plain, golden = (tone.tone_map(melanin, blood, carotene=depth) for depth in (0.0, 0.3))
    ratio = (golden / plain)[0, 0]
    assert ratio[0] == 1
    assert ratio[2] == pytest.approx(np.exp(-0.3), rel=1e-5)
    assert ratio[2] < ratio[1] < 1


def test_table_cannot_be_overwritten() -> None:
    with pytest.raises(ValueError, match="read-only"):
        tone._tone_table()[0, 0] = 0
