"""What do strands of hair look like? A strip of them: columns are strands, rows run root to tip."""

from collections.abc import Mapping
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d

SHELL_COLUMNS = 1024
RIBBON_COLUMNS = 512
TEXTURE_SHAPE = (128, SHELL_COLUMNS + RIBBON_COLUMNS)
"""Rows root to tip; columns around the head, of the shell and then of the ribbons over it."""

_GREY_STRAND = (0.44, 0.43, 0.41)
"""Linear reflectance of a strand without pigment, in the shade of its neighbours."""

_SHADE = 0.3


def mean_colour(parameters: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return the mean linear RGB of the hair, grey strands included; for roots painted on skin."""
    pigment = np.asarray(parameters["hair_colour"], dtype=np.float64)
    grey = np.asarray(_GREY_STRAND)
    return np.asarray((1.0 - parameters["grey"]) * pigment + parameters["grey"] * grey)


def hair_texture(parameters: Mapping[str, Any], seed: int) -> NDArray[np.float32]:
    """Paint the strands of one head of hair.

    Roots are darker than tips, neighbouring strands share a clump's shade, and a strand is either
    pigmented or grey (grey strands come in streaks). The shell lies in the shade of its ribbons.

    Args:
        parameters: Of one head of hair: ``hair_colour``, ``grey``, ``curl_mm``.
        seed: Of the strands.

    Returns:
        ``(128, 1536, 3)`` float32, linear reflectance, 0..1; the first 1024 columns are the
        shell's and wrap around, the others the ribbons'.
    """
    rng = np.random.default_rng([seed, 11])
    rows, columns = TEXTURE_SHAPE
    strand = rng.normal(size=columns)
    clump, broad = _bands(rng, 6.0), _bands(rng, 28.0)
    curly = float(np.clip(parameters["curl_mm"] / 3.0, 0.0, 1.0))
    drift = np.float32(0.14 + 0.2 * curly) * _drift(rng, 8 + round(24 * curly))
    down = np.linspace(0.0, 1.0, rows)
    across = (1.0 - 0.5 * curly) * (0.27 * strand + 0.15 * clump) + 0.10 * broad
    across[:SHELL_COLUMNS] -= _SHADE
    depth = 0.40 * (down - 0.55) - 0.35 * np.exp(-down / 0.05)
    shade = np.exp(drift + across.astype(np.float32) + depth[:, None].astype(np.float32))
    share = float(parameters["grey"])
    uneven = 0.9 * rng.normal(size=columns) + 0.5 * np.roll(clump, 37) + 0.4 * np.roll(broad, 90)
    grey = np.clip(share + 0.9 * share * (1.0 - share) * uneven, 0.0, 1.0)
    pigment = np.asarray(parameters["hair_colour"], dtype=np.float64)
    base = pigment + grey[:, None] * (np.asarray(_GREY_STRAND) - pigment)
    texture = cv2.merge([shade * channel for channel in base.T.astype(np.float32)])
    return np.asarray(np.minimum(texture, np.float32(0.9), out=texture))


def _bands(rng: np.random.Generator, width: float) -> NDArray[np.float64]:
    """Shades of unit deviation around the head, the same for the shell and the ribbons on it."""
    shell = gaussian_filter1d(rng.normal(size=SHELL_COLUMNS), width, mode="wrap")
    shell = shell / shell.std()
    return np.concatenate([shell, shell[:: SHELL_COLUMNS // RIBBON_COLUMNS]])


def _drift(rng: np.random.Generator, knots: int) -> NDArray[np.float32]:
    """Noise of unit deviation that changes from strand to strand and, slowly, along each."""
    rows, columns = TEXTURE_SHAPE
    place = np.linspace(0.0, knots - 1.001, rows)
    first = place.astype(np.intp)
    share = (place - first).astype(np.float32)[:, None]
    noise = rng.standard_normal((knots, columns), dtype=np.float32)
    values = gaussian_filter1d(noise, 0.8, axis=1, mode="wrap")
    values /= values.std()
    step = values[first + 1] - values[first]
    return np.asarray(values[first] + share * step, dtype=np.float32)
