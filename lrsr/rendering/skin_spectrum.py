"""Which spectrum has skin of a colour, where Mitsuba traces wavelengths?

Smooth spectra, as Mitsuba gives to colours, are not skin's: haemoglobin leaves two dips at 545 and
575 nm and a steep rise behind them, and sensors see that otherwise than eyes. Spectra of skin need
three numbers, though (F. H. Imai, N. Tsumura, H. Haneishi and Y. Miyake, "Principal component
analysis of skin color and its application to colorimetric color reproduction", J. Imaging Science
and Technology 40, 1996). So a spectrum here is the sum of three curves, one times red, one times
green, one times blue of the texture: those that come nearest to the spectra of
:mod:`lrsr.identities.skin.tone`, which follow from measured pigments, while under D65 the standard
observer sees the texture's colour exactly. Their error is 0.005 (root mean square); smooth spectra
are 0.09 off.
"""

from functools import cache, lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.skin.tone import WAVELENGTHS_NM, skin_reflectance
from lrsr.rendering.backend import dr, mi
from lrsr.spectra import srgb_curves, table

_FloatArray = NDArray[np.float64]

_MELANIN, _BLOOD = (0.008, 0.35), (0.008, 0.08)
"""Volume fractions of the skins that the curves are fitted to."""


def _skins(nm: _FloatArray) -> _FloatArray:
    """Return reflectances of fair to dark skin, pale to flushed, ``(50, M)``.

    Args:
        nm: ``(M,)``; beyond 400 to 700 nm, where the pigments are not tabulated, nothing changes.
    """
    melanin, blood = np.geomspace(*_MELANIN, 10)[:, None], np.geomspace(*_BLOOD, 5)
    spectra = skin_reflectance(melanin, blood).reshape(-1, len(WAVELENGTHS_NM))
    return np.stack([np.interp(nm, WAVELENGTHS_NM, spectrum) for spectrum in spectra])


@lru_cache(maxsize=1)
def _skin_curves() -> tuple[_FloatArray, _FloatArray]:
    """Return the three curves.

    Returns:
        nm: ``(M,)``, evenly spaced.
        curves: ``(3, M)``; reflectance is linear sRGB ``(3,)`` times these. They may be < 0.
    """
    nm = table("cie_1931")[0]
    seen = srgb_curves()  # (3, M): linear sRGB of a reflectance under D65
    spectra = _skins(nm)
    nearest, *_ = np.linalg.lstsq(spectra @ seen.T, spectra, rcond=None)
    # The smallest change after which sRGB of each curve is one primary.
    missing = np.eye(3) - nearest @ seen.T
    return nm, np.asarray(nearest + missing @ np.linalg.solve(seen @ seen.T, seen))


def skin_albedo(bitmap: Any) -> Any:
    """Make the ``mi.Texture`` of an albedo of skin from one of raw linear sRGB.

    ``mi.traverse`` lists its values as :data:`VALUES`.
    """
    return _texture_class()(mi.Properties(), bitmap)


VALUES = "colour.data"


@cache
def _texture_class() -> Any:
    nm, curves = _skin_curves()
    entries = mi.Float(curves.T.astype(np.float32).ravel())
    first, step, last = float(nm[0]), float(nm[1] - nm[0]), len(nm) - 1.001

    class SkinAlbedo(mi.Texture):  # type: ignore[misc]
        """See the module."""

        def __init__(self, properties: Any, colour: Any) -> None:
            super().__init__(properties)
            self.colour = colour

        def eval(self, si: Any, active: Any = True) -> Any:
            """Return the reflectance at each of the wavelengths of ``si``."""
            rgb = self.colour.eval_3(si, active)
            result = mi.Spectrum(0.0)
            for number, own in enumerate(si.wavelengths):
                place = dr.clip((own - first) / step, 0.0, last)
                below = mi.UInt32(place)
                low = dr.gather(mi.Color3f, entries, below, active)
                high = dr.gather(mi.Color3f, entries, below + 1, active)
                curve = dr.lerp(low, high, place - mi.Float(below))
                result[number] = dr.clip(dr.dot(curve, rgb), 0.0, 1.0)
            return result

        def is_spatially_varying(self) -> bool:
            """Tell that the colour is a texture."""
            return True

        def traverse(self, callback: Any) -> None:
            """Show the colour."""
            callback.put("colour", self.colour, mi.ParamFlags.Differentiable)

    return SkinAlbedo
