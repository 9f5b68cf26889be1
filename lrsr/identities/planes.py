"""How are many vectors multiplied fast? As planes ``(3, ...)`` of their x, y and z."""

from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

T = TypeVar("T", np.float32, np.float64)


def cross(a: NDArray[T], b: NDArray[T]) -> NDArray[T]:
    """Return the vector products of two sets of vectors ``(3, ...)``: ``(3, ...)``.

    Example:
        >>> cross(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])).tolist()
        [0.0, 0.0, 1.0]
    """
    return np.stack([a[k - 2] * b[k - 1] - a[k - 1] * b[k - 2] for k in range(3)])


def dot(a: NDArray[T], b: NDArray[T]) -> NDArray[T]:
    """Return the scalar products of two sets of vectors ``(3, ...)``: ``(...)``."""
    product: NDArray[T] = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product
