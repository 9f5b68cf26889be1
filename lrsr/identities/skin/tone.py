"""Which colour has skin that holds so much melanin and so much blood?

Two layers (Jacques, "Optical properties of biological tissues: a review", Phys. Med. Biol. 58,
2013; Krishnaswamy and Baranoski, "A biophysically-based spectral model of light interaction with
human skin", 2004): the epidermis is a filter that light crosses twice, the dermis a semi-infinite
scatterer whose diffuse reflectance follows from its reduced albedo. The spectrum is integrated
under CIE D65 for the 1931 observer and turned into linear sRGB.
"""

from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import ArrayLike, NDArray

_FloatArray = NDArray[np.float64]

_MELANIN_RANGE = (0.002, 0.6)
"""Volume fraction of melanosomes in the epidermis that the table covers."""

_BLOOD_RANGE = (0.002, 0.4)
"""Volume fraction of whole blood in the dermis that the table covers."""

_TABLE_SIZE = 48
_CHROMA = (0.82, 0.70, 0.55, 0.46)
"""Share of the model's saturation that is kept at these melanin fractions (constant beyond): bare,
it is too orange, the more so the darker the skin. Measured skin is most colourful at L* of about 55
(C* 22 to 24) and less so both above and below: C* 17 to 20 at L* 38 to 42, 14 to 16 at L* 30, hue
angles of 45° to 60° (Wang et al. 2015, "Measuring human skin colour"; Xiao et al. 2017).
"""
_CHROMA_MELANIN = (0.03, 0.1, 0.2, 0.32)
_GAIN = 1.12
"""The bare model is too dark."""

_EPIDERMIS_MM = 0.06
_OXYGENATION = 0.75
_REFRACTIVE_INDEX = 1.4

WAVELENGTHS_NM = np.arange(400.0, 701.0, 10.0)

# Molar extinction, cm⁻¹/(mol/l), 400-700 nm in steps of 10: S. Prahl, "Tabulated molar extinction
# coefficient for hemoglobin in water" (data of Gratzer and Kollias), omlc.org/spectra/hemoglobin.
_OXYHAEMOGLOBIN = """266232 466840 480360 246072 102580 62816 44480 33209.2 26629.2 23684.4 20932.8
    20035.2 24202.4 39956.8 53236 43016 32613.2 44496 50104 14400.8 3200 1506 942 610 442 368 319.6
    294 277.6 276 290"""
_HAEMOGLOBIN = """223296 303956 407560 528600 413280 103292 23388.8 16156.4 14550 16684 20862
    25773.6 31589.6 39036.4 46592 53412 53788 45072 37020 28324.4 14677.2 9443.6 6509.6 5148.8
    4345.2 3750.12 3226.56 2795.12 2407.92 2051.96 1794.28"""

# CIE 1931 2° observer and illuminant D65 at the same wavelengths (CIE 15:2004, tables T.4 and T.1).
_X_BAR = """.01431 .04351 .13438 .2839 .34828 .3362 .2908 .19536 .09564 .03201 .0049 .0093 .06327
    .1655 .2904 .43345 .5945 .7621 .9163 1.0263 1.0622 1.0026 .85445 .6424 .4479 .2835 .1649 .0874
    .04677 .0227 .011359"""
_Y_BAR = """.000396 .00121 .004 .0116 .023 .038 .06 .09098 .13902 .20802 .323 .503 .71 .862 .954
    .99495 .995 .952 .87 .757 .631 .503 .381 .265 .175 .107 .061 .032 .017 .00821 .004102"""
_Z_BAR = """.06785 .2074 .6456 1.3856 1.74706 1.77211 1.6692 1.28764 .81295 .46518 .272 .1582
    .07825 .04216 .0203 .00875 .0039 .0021 .00165 .0011 .0008 .00034 .00019 .00005 .00002 0 0 0 0
    0 0"""
_D65 = """82.7549 91.486 93.4318 86.6823 104.865 117.008 117.812 114.861 115.923 108.811 109.354
    107.802 104.79 107.689 104.405 104.046 100 96.3342 95.788 88.6856 90.0062 89.5991 87.6987
    83.2886 83.6992 80.0268 80.2146 82.2778 78.2842 69.7213 71.6091"""

_XYZ_TO_LINEAR_SRGB = np.array(
    [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
)  # IEC 61966-2-1
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])


def _numbers(table: str) -> _FloatArray:
    return np.array(table.split(), dtype=np.float64)


def _melanin_absorption(wavelength_nm: ArrayLike) -> _FloatArray:
    """Absorption of melanosomes, 93 % eumelanin and 7 % pheomelanin.

    Args:
        wavelength_nm: Any shape, nm, 400 to 700.

    Returns:
        Same shape, mm⁻¹.

    Example:
        >>> _melanin_absorption(500.0).round(1)
        np.float64(66.2)
    """
    wavelength = np.asarray(wavelength_nm, dtype=np.float64)
    return np.asarray(0.93 * 6.6e10 * wavelength**-3.33 + 0.07 * 2.9e14 * wavelength**-4.75)


def _baseline_absorption(wavelength_nm: ArrayLike) -> _FloatArray:
    """Absorption of bloodless, melanin-free skin (Jacques 2013, eq. 11, in mm⁻¹).

    Args:
        wavelength_nm: Any shape, nm, 400 to 700.

    Returns:
        Same shape, mm⁻¹.
    """
    wavelength = np.asarray(wavelength_nm, dtype=np.float64)
    return np.asarray(0.0244 + 8.53 * np.exp(-(wavelength - 154.0) / 66.2))


def _blood_absorption() -> _FloatArray:
    """Absorption of whole blood (150 g/l haemoglobin, 75 % oxygenated) at ``WAVELENGTHS_NM``.

    Returns:
        ``(31,)``, mm⁻¹.
    """
    extinction = _OXYGENATION * _numbers(_OXYHAEMOGLOBIN) + (1 - _OXYGENATION) * _numbers(
        _HAEMOGLOBIN
    )
    return np.asarray(np.log(10.0) * extinction * 150.0 / 64500.0 / 10.0)


def _diffuse_reflectance(reduced_albedo: ArrayLike) -> _FloatArray:
    """Diffuse reflectance of a semi-infinite scatterer, index 1.4 (Jensen et al. 2001, eq. 15).

    Args:
        reduced_albedo: Any shape, µs' / (µa + µs'), [0, 1].

    Returns:
        Same shape, [0, 1].

    Example:
        >>> _diffuse_reflectance([0.0, 1.0])
        array([0., 1.])
    """
    albedo = np.asarray(reduced_albedo, dtype=np.float64)
    eta = _REFRACTIVE_INDEX
    fresnel = -1.440 / eta**2 + 0.710 / eta + 0.668 + 0.0636 * eta
    mismatch = (1 + fresnel) / (1 - fresnel)
    root = np.sqrt(3 * (1 - albedo))
    return np.asarray(0.5 * albedo * (1 + np.exp(-4 / 3 * mismatch * root)) * np.exp(-root))


def skin_reflectance(melanin: ArrayLike, blood: ArrayLike) -> _FloatArray:
    """Reflectance spectrum of the two layers.

    Args:
        melanin: ``(...)``, volume fraction of melanosomes in the epidermis, [0, 1].
        blood: ``(...)``, volume fraction of blood in the dermis, [0, 1].

    Returns:
        ``(..., 31)`` at ``WAVELENGTHS_NM``, [0, 1].
    """
    fraction_m = np.asarray(melanin, dtype=np.float64)[..., None]
    fraction_b = np.asarray(blood, dtype=np.float64)[..., None]
    base = _baseline_absorption(WAVELENGTHS_NM)
    epidermis = fraction_m * _melanin_absorption(WAVELENGTHS_NM) + (1 - fraction_m) * base
    dermis = fraction_b * _blood_absorption() + (1 - fraction_b) * base
    scattering = 4.6 * (WAVELENGTHS_NM / 500.0) ** -1.42
    twice = np.exp(-2 * _EPIDERMIS_MM * epidermis)
    return np.asarray(twice * _diffuse_reflectance(scattering / (scattering + dermis)))


def _spectrum_to_linear_srgb(reflectance: ArrayLike) -> _FloatArray:
    """Colour of a surface under D65; a white one gives (1, 1, 1) to within 0.5 %.

    Args:
        reflectance: ``(..., 31)`` at ``WAVELENGTHS_NM``, [0, 1].

    Returns:
        ``(..., 3)``, linear sRGB, not clipped.
    """
    light = _numbers(_D65)
    observer = np.stack([_numbers(_X_BAR), _numbers(_Y_BAR), _numbers(_Z_BAR)], axis=-1)
    weights = light[:, None] * observer / (light @ observer[:, 1])
    return np.asarray(np.asarray(reflectance) @ weights @ _XYZ_TO_LINEAR_SRGB.T, dtype=np.float64)


def _tone(melanin: ArrayLike, blood: ArrayLike) -> _FloatArray:
    """Skin colour, computed exactly; :func:`tone_map` is the fast form for textures.

    Args:
        melanin: ``(...)``, volume fraction, [0, 1]; 0.01 is very fair, 0.3 very dark.
        blood: ``(...)``, volume fraction, [0, 1]; 0.02 is usual, 0.1 is flushed.

    Returns:
        ``(..., 3)`` linear sRGB reflectance, [0.001, 0.95].
    """
    colour = _spectrum_to_linear_srgb(skin_reflectance(melanin, blood))
    grey = (colour @ _LUMINANCE)[..., None]
    share = np.interp(np.log(np.maximum(melanin, 1e-6)), np.log(_CHROMA_MELANIN), _CHROMA)
    return np.asarray(np.clip(_GAIN * (grey + share[..., None] * (colour - grey)), 0.001, 0.95))


@lru_cache(maxsize=1)
def _tone_table() -> NDArray[np.float32]:
    """Tabulate :func:`_tone` over the logarithms of its two arguments.

    Returns:
        ``(48, 48, 3)`` float32, linear sRGB; rows run over melanin, columns over blood.
    """
    melanin = np.geomspace(*_MELANIN_RANGE, _TABLE_SIZE)
    blood = np.geomspace(*_BLOOD_RANGE, _TABLE_SIZE)
    table = _tone(melanin[:, None], blood[None, :]).astype(np.float32)
    table.flags.writeable = False
    return table


def _carotene_filter(depth: float) -> NDArray[np.float32]:
    """What yellow pigment (carotene, bilirubin) leaves of each channel's light.

    Both absorb between 400 and 500 nm: blue, hardly green, no red (Alaluf et al. 2002, "Dietary
    carotenoids contribute to normal human skin color and UV photosensitivity").

    Args:
        depth: Optical depth in the blue channel; below 0 there is less than usual.

    Returns:
        ``(3,)`` float32, factors.

    Example:
        >>> _carotene_filter(0.0)
        array([1., 1., 1.], dtype=float32)
    """
    return np.exp(-depth * np.array([0.0, 0.18, 1.0])).astype(np.float32)


def tone_map(
    log_melanin: NDArray[np.float32], log_blood: NDArray[np.float32], *, carotene: float = 0.0
) -> NDArray[np.float32]:
    """Look the colour of every texel up, bilinear in the logarithms (within 1 % of :func:`_tone`).

    Args:
        log_melanin: ``(H, W)``, natural logarithm of the fraction; clamped to ``MELANIN_RANGE``.
        log_blood: ``(H, W)``, natural logarithm of the fraction; clamped to ``_BLOOD_RANGE``.
        carotene: Optical depth of yellow pigment; see :func:`_carotene_filter`.

    Returns:
        ``(H, W, 3)`` float32, linear sRGB reflectance.
    """
    table = _tone_table() * _carotene_filter(carotene)
    row = _table_position(log_melanin, _MELANIN_RANGE)
    column = _table_position(log_blood, _BLOOD_RANGE)
    colour = cv2.remap(table, column, row, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return np.asarray(colour, dtype=np.float32)


def _table_position(
    logarithm: NDArray[np.float32], limits: tuple[float, float]
) -> NDArray[np.float32]:
    low, high = np.log(limits)
    scale = (_TABLE_SIZE - 1) / (high - low)
    position = logarithm - np.float32(low)
    position *= np.float32(scale)
    return position  # the look-up clamps
