"""What do strands of hair look like? A strip of them: columns are strands, rows run root to tip."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

TEXTURE_SHAPE = (128, 1024)
"""Rows root to tip, columns around the head."""

GREY_STRAND = (0.44, 0.43, 0.41)
"""Linear reflectance of a strand without pigment, in the shade of its neighbours."""


def mean_colour(parameters: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return the mean linear RGB of the hair, grey strands included; for roots painted on skin."""
    pigment = np.asarray(parameters["hair_colour"], dtype=np.float64)
    grey = np.asarray(GREY_STRAND)
    return (1.0 - parameters["grey"]) * pigment + parameters["grey"] * grey


def hair_texture(parameters: Mapping[str, Any], seed: int = 0) -> NDArray[np.float32]:
    """Paint the strands of one head of hair.

    Roots are darker than tips, neighbouring strands share a clump's shade, and a strand is either
    pigmented or grey (grey strands come in streaks).

    Args:
        parameters: Of one head of hair: ``hair_colour``, ``grey``.
        seed: Of the strands.

    Returns:
        ``(128, 1024, 3)`` float32, linear reflectance, 0..1; wraps around in the columns.
    """
    rng = np.random.default_rng([seed, 11])
    rows, columns = TEXTURE_SHAPE
    strand = rng.normal(size=columns)
    clump = _unit(gaussian_filter1d(rng.normal(size=columns), 6.0, mode="wrap"))
    broad = _unit(gaussian_filter1d(rng.normal(size=columns), 28.0, mode="wrap"))
    drift = gaussian_filter1d(rng.normal(size=(rows, columns)), 14.0, axis=0, mode="reflect")
    drift = _unit(gaussian_filter1d(drift, 0.7, axis=1, mode="wrap"))
    down = np.linspace(0.0, 1.0, rows)[:, None]
    log_shade = 0.20 * strand + 0.22 * clump + 0.10 * broad + 0.16 * drift
    log_shade = log_shade + 0.30 * (down - 0.55) - 0.35 * np.exp(-down / 0.05)
    share = float(parameters["grey"])
    uneven = 0.9 * rng.normal(size=columns) + 0.5 * np.roll(clump, 37) + 0.4 * np.roll(broad, 90)
    grey = np.clip(share + 0.9 * share * (1.0 - share) * uneven, 0.0, 1.0)
    pigment = np.asarray(parameters["hair_colour"], dtype=np.float64)
    white = np.asarray(GREY_STRAND)
    base = pigment + grey[:, None] * (white - pigment)
    texture = base[None] * np.exp(log_shade)[..., None]
    return np.clip(texture, 0.0, 0.9).astype(np.float32)


def _unit(values: NDArray[np.float64]) -> NDArray[np.float64]:
    return values / max(float(values.std()), 1e-12)
