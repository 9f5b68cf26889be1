"""How strongly does each colour filter of a real sensor answer to each wavelength?

A curve is the response of red, green or blue photosites per radiant energy that falls on the
camera, which is how monochromators and spectroradiometers measure it, with lens and infrared filter
before the sensor. Photosites count quanta, of which a joule of red light has more than one of blue:
a quantum efficiency η(λ) is the curve η(λ) λ / hc per energy, and what a curve per energy sums up
to is a number of electrons already. So either kind gives electrons, whose shot noise then fits.
"""

from dataclasses import dataclass
from functools import cache, lru_cache
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from lrsr.camera.checks import check_setting
from lrsr.errors import InputError
from lrsr.paths import asset
from lrsr.spectra import average, daylight

FloatArray = NDArray[np.float64]
Per = Literal["energy", "quanta"]

_DAYLIGHT_LEVELS = {"nikon_d5100": (0.441, 1.0, 0.821)}
"""What white in daylight D65 gives in red, green and blue, the strongest 1, of cameras by name: the
published curves of the D5100 are each scaled to a peak of 1, so these come from the colour matrix
that Adobe's DNG converter and dcraw hold for it (XYZ of D65 to raw, divided by green)."""


@dataclass(frozen=True, eq=False)
class Sensitivities:
    """The measured colour filters of a camera.

    Attributes:
        name: Of the camera, or of the file.
        nm: ``(M,)`` wavelengths, rising.
        curves: ``(3, M)``, red, green and blue, >= 0, of any common scale.
        per: "energy" or "quanta"; of what the response is.
        daylight_levels: What white in D65 gives, > 0; scales the curves. None: as they are.

    Raises:
        InputError: The curves are none, or do not answer to visible light.
    """

    name: str
    nm: FloatArray
    curves: FloatArray
    per: Per = "energy"
    daylight_levels: tuple[float, float, float] | None = None

    def __post_init__(self) -> None:
        if self.per not in get_args(Per):
            raise InputError(f"per={self.per}: choose one of {', '.join(get_args(Per))}")
        shaped = self.curves.shape == (3, len(self.nm)) and len(self.nm) >= 2
        finite = shaped and bool(np.isfinite(self.curves).all() and np.isfinite(self.nm).all())
        rising = finite and bool((np.diff(self.nm) > 0).all() and self.curves.min() >= 0)
        if not rising or not (self.curves[:, (self.nm >= 400) & (self.nm <= 700)] > 0).any(1).all():
            raise InputError(
                f"sensitivities {self.name}: wanted rising wavelengths in nm and three curves >= 0"
                " that answer to visible light"
            )

    def weights(self, edges_nm: tuple[float, ...]) -> FloatArray:
        """Return what each band adds to raw red, green and blue, ``(3, N)``.

        White in daylight of luminance 1 fills the strongest of them: 1.
        """
        curves = self.curves * self.nm if self.per == "quanta" else self.curves
        weights = average(self.nm, curves, edges_nm)
        white = weights @ daylight(edges_nm)
        levels = white if self.daylight_levels is None else np.array(self.daylight_levels)
        return np.asarray(weights * (levels / white / levels.max())[:, None])


def find_sensitivities(name: str, per: Per = "energy") -> Sensitivities:
    """Return the filters of a camera that ships, or those in a file.

    Args:
        name: "nikon_d5100", or the path of a ``.csv`` file: wavelength in nm, red, green, blue.
        per: "energy" or "quanta", of a file.

    Raises:
        InputError: There is no such camera or file, or it holds something else.

    Example:
        >>> nikon = find_sensitivities("nikon_d5100")
        >>> nikon.nm[nikon.curves.argmax(axis=1)].tolist()
        [595.0, 530.0, 460.0]
    """
    check_setting("sensitivities", name, isinstance(name, str), "a camera's name or a .csv file")
    if name in _DAYLIGHT_LEVELS:
        table = _read(asset(f"spectra/{name}.csv"))
        return Sensitivities(name, table[0], table[1:], "energy", _DAYLIGHT_LEVELS[name])
    file = Path(name).expanduser()
    if not file.is_file():
        known = ", ".join(_DAYLIGHT_LEVELS)
        raise InputError(f"sensitivities={name}: give one of {known}, or a .csv file")
    table = _read(file)
    if len(table) != 4:
        raise InputError(f"sensitivities={name}: wanted four columns: nm, red, green, blue")
    return Sensitivities(file.stem, table[0], table[1:], per)


@lru_cache(maxsize=8)
def colorchecker(edges_nm: tuple[float, ...]) -> FloatArray:
    """Return the reflectances of a ColorChecker's 24 patches in those bands, ``(24, N)``."""
    table = _read(asset("spectra/colorchecker.csv"))
    return average(table[0], table[1:], edges_nm)


@cache
def _read(file: Path) -> FloatArray:
    """Return the columns of a table of numbers.

    Raises:
        InputError: It is none.
    """
    try:
        return np.loadtxt(file, delimiter=",", ndmin=2, dtype=np.float64).T.copy()
    except (OSError, ValueError) as error:
        raise InputError(f"{file} is no table of numbers with commas between: {error}") from error
