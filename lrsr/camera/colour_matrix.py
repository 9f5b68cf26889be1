"""Which colour matrix takes a sensor's colours to sRGB, and how far off does it leave them?

No matrix undoes real filters: they are not sums of the eye's curves (R. Luther 1927; H. E. Ives
1915), so colours that the eye tells apart may be one to the sensor and the other way round. What
makers do is least squares over reflectances in one light, here with white kept exactly white (G. D.
Finlayson and M. S. Drew, "White-point preserving color correction", CIC 1997).
"""

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.spectra import srgb_weights

_FloatArray = NDArray[np.float64]


def fit_matrix(balanced: _FloatArray, wanted: _FloatArray) -> _FloatArray:
    """Return the matrix that takes sensor colours nearest to wanted ones and white to white.

    Args:
        balanced: ``(K, 3)``, of reflectances, divided by what white gives.
        wanted: ``(K, 3)``, linear sRGB of the same reflectances, white being (1, 1, 1).

    Returns:
        ``(3, 3)``, rows sum to 1; least squares of the rest.

    Raises:
        InputError: The colours are all grey, or too few, so that no matrix follows.

    Example:
        >>> primaries, dull = np.eye(3), np.full((3, 3), 0.1) + 0.7 * np.eye(3)
        >>> fit_matrix(dull, primaries)[0].round(4).tolist()
        [1.2857, -0.1429, -0.1429]
    """
    differences = balanced[:, :2] - balanced[:, 2:]
    if np.linalg.matrix_rank(differences, tol=1e-6) < 2:
        raise InputError("a colour matrix needs reflectances of at least two hues")
    two, *_ = np.linalg.lstsq(differences, wanted - balanced[:, 2:], rcond=None)
    return np.column_stack([two.T, 1 - two.sum(axis=0)])


def observed(
    edges_nm: tuple[float, ...], white: _FloatArray, reflectances: _FloatArray
) -> _FloatArray:
    """Return linear sRGB ``(K, 3)`` as the standard observer, adapted to the light, sees it.

    Args:
        edges_nm: Of N bands.
        white: ``(N,)`` bands of the light, which becomes (1, 1, 1).
        reflectances: ``(K, N)``.
    """
    weights = srgb_weights(edges_nm, tuple(white.tolist()))
    return np.asarray((reflectances * white) @ weights.T / (weights @ white))
