"""How does light spread over pixels? Our Gaussian, as a description for Mitsuba and as a draw.

The filter is a Gaussian with a standard deviation of half a pixel **of the film itself**, cut at
two pixels. A film twice as fine has a filter twice as narrow: it is another camera's picture of the
same scene, and its 2 × 2 means are slightly sharper than the ×1 film.
"""

import math
from typing import Any

from lrsr.rendering.backend import dr

_STDDEV_PX = 0.5

_CUT = 4.0
"""Where the filter ends, in standard deviations."""

REACH_PX = _CUT * _STDDEV_PX
"""How far beyond its own pixel's middle a ray may start."""


def describe_film(side: int, samples: int) -> dict[str, Any]:
    """Describe Mitsuba's film with our filter, and its sampler, for ``mi.load_dict``."""
    return {
        "film": {
            "type": "hdrfilm",
            "width": side,
            "height": side,
            "component_format": "float32",
            "rfilter": {"type": "gaussian", "stddev": _STDDEV_PX},
        },
        "sampler": {"type": "multijitter", "sample_count": samples},
    }


def draw_offset(uniform: Any) -> Any:
    """Return how far from its pixel's middle a ray starts, px, for two numbers in [0, 1)."""
    cut = math.erf(_CUT / math.sqrt(2))
    return _STDDEV_PX * math.sqrt(2) * dr.erfinv((2 * uniform - 1) * cut)
