"""How strongly does a glass bend light of each colour? Sellmeier's formula and the catalogues.

n² = 1 + Σ Bᵢ λ² / (λ² - Cᵢ), λ in µm (Sellmeier 1871), against air at 20 °C. The coefficients are
those of the makers' catalogues as the public-domain database of refractiveindex.info (CC0) carries
them: Schott 2017-01-20; K-LaK11 is the three-term form that fits Sumita's own formula (catalogue
2017-02-02) within 1e-6 from 400 to 700 nm.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import InputError

D_LINE_NM = 587.5618
"""Of helium: where a glass has its index n_d and a lens its focal length."""

AIR = "air"

_SELLMEIER: dict[str, tuple[float, float, float, float, float, float]] = {
    AIR: (0.0, 0.0, 0.0, 0.01, 0.01, 0.01),
    "N-BK7": (1.03961212, 0.231792344, 1.01046945, 0.00600069867, 0.0200179144, 103.560653),
    "N-SK16": (1.34317774, 0.241144399, 0.994317969, 0.00704687339, 0.0229005, 92.7508526),
    "N-BAF10": (1.5851495, 0.143559385, 1.08521269, 0.00926681282, 0.0424489805, 105.613573),
    "K-LaK11": (1.54208323, 0.159091256, 0.121088214, 0.00843703426, 0.0271013148, 12.6650855),
    "N-LAF3": (1.73155854, 0.150874455, 1.06586596, 0.00953833914, 0.0407887211, 98.0758545),
    "F2": (1.34533359, 0.209073176, 0.937357162, 0.00997743871, 0.0470450767, 111.886764),
    "F5": (1.3104463, 0.19603426, 0.96612977, 0.00958633048, 0.0457627627, 115.011883),
    "N-SF11": (1.73759695, 0.313747346, 1.89878101, 0.013188707, 0.0623068142, 155.23629),
    "N-SF15": (1.57055634, 0.218987094, 1.50824017, 0.0116507014, 0.0597856897, 132.709339),
}
"""B₁, B₂, B₃ and C₁, C₂, C₃ (µm²) of each glass."""


def coefficients(glass: str) -> tuple[float, float, float, float, float, float]:
    """Return B₁, B₂, B₃, C₁, C₂, C₃ (µm²) of a glass.

    Raises:
        InputError: The glass is not in ``_SELLMEIER``.
    """
    if glass not in _SELLMEIER:
        raise InputError(f"glass {glass!r} is not known; choose one of {', '.join(_SELLMEIER)}")
    return _SELLMEIER[glass]


def refractive_index(glass: str, wavelength_nm: ArrayLike = D_LINE_NM) -> NDArray[np.float64]:
    """Return the index of refraction against air.

    Args:
        glass: Name in ``_SELLMEIER``.
        wavelength_nm: Any shape, nm; the catalogues vouch for 370 to 1500.

    Raises:
        InputError: The glass is not known.

    Example:
        >>> round(float(refractive_index("N-BK7")), 4)
        1.5168
    """
    micrometres = np.asarray(wavelength_nm, dtype=np.float64) / 1000
    return np.asarray(index_of_ray(coefficients(glass), micrometres, np.sqrt))


def index_of_ray(rows: Any, wavelength_um: Any, root: Any) -> Any:
    """Return Sellmeier's index of numbers of any kind, Dr.Jit's included.

    Args:
        rows: B₁, B₂, B₃, C₁, C₂, C₃ (µm²).
        wavelength_um: µm.
        root: The square root of those numbers.
    """
    squared = wavelength_um * wavelength_um
    terms = (b * squared / (squared - c) for b, c in zip(rows[:3], rows[3:], strict=True))
    return root(1 + sum(terms))
