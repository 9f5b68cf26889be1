"""Bicubic resizing as MATLAB does it, written out: a weighted sum a sample, edges repeated."""

import numpy as np
from numpy.typing import NDArray


def cubic(x: float) -> float:
    """Keys 1981, eq. 15, a = -0.5."""
    x = abs(x)
    if x <= 1:
        return 1.5 * x**3 - 2.5 * x**2 + 1
    if x < 2:
        return -0.5 * x**3 + 2.5 * x**2 - 4 * x + 2
    return 0.0


def resize_line(line: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    kernel_scale = min(scale, 1.0)
    result = []
    for i in range(round(len(line) * scale)):
        centre = (i + 0.5) / scale - 0.5
        total = weights = 0.0
        reach = int(np.ceil(2 / kernel_scale)) + 1
        for j in range(int(centre) - reach, int(centre) + reach + 2):
            weight = cubic((centre - j) * kernel_scale)
            total += weight * line[min(max(j, 0), len(line) - 1)]
            weights += weight
        result.append(total / weights)
    return np.array(result)


def resize(image: NDArray[np.float64], scale: float) -> NDArray[np.float64]:
    rows = np.stack([resize_line(row, scale) for row in image])
    return np.stack([resize_line(column, scale) for column in rows.T]).T
