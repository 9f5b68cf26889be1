"""How does one thing pass into another? By a ramp without corners."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def smoothstep(low: float, high: float, value: NDArray[Any]) -> NDArray[Any]:
    """Rise smoothly from 0 at ``low`` to 1 at ``high`` (falls when ``low > high``).

    Args:
        low: Value at which the result is 0.
        high: Value at which the result is 1, other than ``low``.
        value: Any shape.

    Returns:
        Same shape and type, [0, 1].

    Example:
        >>> smoothstep(0.0, 2.0, np.array([-1.0, 1.0, 5.0]))
        array([0. , 0.5, 1. ])
    """
    share = np.asarray((value - low) / (high - low))
    np.clip(share, 0, 1, out=share)
    square = share * share
    share *= -2
    share += 3
    return np.asarray(square * share, dtype=value.dtype)
