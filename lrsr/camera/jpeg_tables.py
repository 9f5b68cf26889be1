"""Which steps does JPEG quantise with?

The tables are those of annex K of ITU-T T.81, K.1 and K.2, on the scale of the Independent JPEG
Group, as libjpeg writes them.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK_PX = 8
Floats = NDArray[np.float64]

# Luminance, row by row.
_ROWS = """16 11 10 16 24 40 51 61 12 12 14 19 26 58 60 55 14 13 16 24 40 57 69 56 14 17 22 29 51
87 80 62 18 22 37 56 68 109 103 77 24 35 55 64 81 104 113 92 49 64 78 87 103 121 120 101 72 92 95 98
112 100 103 99"""
_LUMINANCE = np.array(_ROWS.split(), dtype=np.int64).reshape(BLOCK_PX, BLOCK_PX)
_CHROMINANCE = np.full((BLOCK_PX, BLOCK_PX), 99)
_CHROMINANCE[:4, :4] = [[17, 18, 24, 47], [18, 21, 26, 66], [24, 26, 56, 99], [47, 66, 99, 99]]


def luminance_table(quality: int) -> Floats:
    """Return the steps ``(8, 8)`` (down, right) of luminance that libjpeg uses at a quality.

    Args:
        quality: 1-100.

    Example:
        >>> luminance_table(75)[0, :4].tolist()
        [8.0, 6.0, 5.0, 8.0]
    """
    return _scaled(_LUMINANCE, quality)


def chrominance_table(quality: int) -> Floats:
    """Return the steps ``(8, 8)`` of both colours' coefficients.

    Args:
        quality: 1-100.

    Example:
        >>> chrominance_table(75)[0, :5].tolist()
        [9.0, 9.0, 12.0, 24.0, 50.0]
    """
    return _scaled(_CHROMINANCE, quality)


def _scaled(table: NDArray[Any], quality: int) -> Floats:
    scale = 5000 // quality if quality < 50 else 200 - 2 * quality
    return np.asarray(((table * scale + 50) // 100).clip(1, 255), dtype=np.float64)
