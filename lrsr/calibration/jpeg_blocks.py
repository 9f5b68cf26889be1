"""How hard was a picture squeezed, and where did its blocks fall? From the pixels.

In a decoded JPEG the DCT coefficients of luminance, taken on the grid of its blocks, lie near
multiples of the steps of its quantisation table; on any other grid they lie anywhere (Z. Fan,
R. de Queiroz, IEEE Trans. Image Processing 12(2), 2003, doi:10.1109/TIP.2002.807361, sec. III).
Every grid and every table of the Independent JPEG Group's scale is tried, and the likeliest taken.
Told apart are: the grid modulo 8 (of a 4:2:0 file's 16 pixels the colours alone know the rest) and
the last compression of several. Not told: chroma sub-sampling, and qualities from about 96 on,
whose steps drown in the rounding of the decoded levels. H.264 leaves no such table.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera.checks import check_light
from lrsr.camera.jpeg_tables import BLOCK_PX, luminance_table
from lrsr.camera.processing import luminance
from lrsr.camera.soft_jpeg import cosine_transform
from lrsr.errors import ImageContractError

_ROUNDING = 0.4
"""Standard deviation of a coefficient after decoding: luminance and three colours are rounded."""
_LEAST = 1.5
"""Smaller coefficients may be rounded zeros, which say nothing about the step."""
_OUTLIERS = 0.02
"""Share of coefficients that clipping has moved away from any multiple."""
_EVIDENCE = 0.05
"""Mean log-likelihood ratio a coefficient, against no table at all, that a table has to reach."""
_ENOUGH = 50
"""Coefficients at least; fewer prove nothing."""
_GRIDS = tuple((x, y) for y in range(BLOCK_PX) for x in range(BLOCK_PX))
"""Places of the first pixel within its block."""
_SAMPLE = 64
"""Coefficients of each frequency that a grid is chosen by; the quality is found with all."""
_AT_ONCE = 1024
"""Coefficients that are compared with all steps at once: what a cache holds."""

_Floats = NDArray[np.float64]


@dataclass(frozen=True)
class JpegEstimate:
    """What was found.

    Attributes:
        quality: Of the Independent JPEG Group's scale, 1-100.
        origin_px: ``(x, y)`` of the first pixel within its block, 0..7 each.
        evidence: Mean log-likelihood ratio a coefficient, nats, against pictures without blocks.
    """

    quality: int
    origin_px: tuple[int, int]
    evidence: float


def estimate_jpeg(
    srgb: torch.Tensor, *, grids: Sequence[tuple[int, int]] = _GRIDS
) -> JpegEstimate | None:
    """Find quality and grid of pictures that went through the same JPEG.

    Args:
        srgb: ``(B, 3, H, W)``, [0, 1], multiples of 1/255, H and W >= 16; 20 pictures are plenty.
        grids: Which ``(x, y)`` are tried.

    Returns:
        The likeliest; None if the pictures show no blocks.

    Raises:
        ImageContractError: The images break the contract or are smaller than 16 × 16.
    """
    check_light(srgb, name="srgb")
    if min(srgb.shape[-2:]) < 2 * BLOCK_PX:
        raise ImageContractError(f"srgb: got {tuple(srgb.shape)}, wanted H and W >= 16")
    clipped = ((srgb <= 0) | (srgb >= 1)).any(1).numpy()
    levels = luminance(srgb)[:, 0].double().mul(255).numpy() - 128
    _, chances = _likeliest((_coefficients(levels, clipped, grid) for grid in grids), _SAMPLE)
    grid = grids[int(np.argmax(chances))]
    (quality,), (evidence,) = _likeliest([_coefficients(levels, clipped, grid)])
    return JpegEstimate(int(quality), grid, float(evidence)) if evidence > _EVIDENCE else None


def _coefficients(levels: _Floats, clipped: NDArray[np.bool_], grid: tuple[int, int]) -> _Floats:
    """Return the DCT ``(n, 8, 8)`` of every whole block without clipping, which moves them all."""
    blocks, spoilt = _blocks(levels, *grid), _blocks(clipped, *grid)
    return np.asarray(_DCT @ blocks[~spoilt.any((1, 2))] @ _DCT.T)


def _blocks(planes: NDArray[Any], x: int, y: int) -> NDArray[Any]:
    """Cut ``(B, H, W)`` into the whole blocks of a grid that begins ``(x, y)`` before it."""
    cut = planes[:, -y % BLOCK_PX :, -x % BLOCK_PX :]
    rows, columns = (side // BLOCK_PX for side in cut.shape[1:])
    cut = cut[:, : rows * BLOCK_PX, : columns * BLOCK_PX]
    blocks = cut.reshape(len(cut), rows, BLOCK_PX, columns, BLOCK_PX).transpose(0, 1, 3, 2, 4)
    return np.asarray(blocks.reshape(-1, BLOCK_PX, BLOCK_PX))


def _likeliest(
    grids: Iterable[_Floats], most: int | None = None
) -> tuple[NDArray[np.int64], _Floats]:
    """Return each grid's best quality ``(G,)`` and its mean log-likelihood ratio ``(G,)``.

    Args:
        grids: Of each, coefficients ``(n, 8, 8)``; only those that tell are kept.
        most: Of each frequency of a grid, that many at most are looked at.
    """
    kept, told = zip(*(_telling(coefficients, most) for coefficients in grids), strict=True)
    seen, counts = np.concatenate(kept), np.stack(told)
    owner, frequency = (
        index.repeat(counts.ravel()) for index in np.indices(counts.shape).reshape(2, -1)
    )
    order, ends = frequency.argsort(kind="stable"), counts.sum(axis=0).cumsum()
    total = np.zeros((len(counts), len(_STEPS)))
    for part, (steps, which) in zip(np.split(order, ends[:-1]), _UNEQUAL_STEPS, strict=True):
        total += _log_ratios(seen[part], owner[part], steps, len(counts))[:, which]
    in_all = counts.sum(axis=1)
    enough = in_all >= _ENOUGH
    evidence = np.where(enough, total.max(axis=1) / np.maximum(in_all, 1), 0.0)
    return np.where(enough, 1 + total.argmax(axis=1), 100), evidence


def _telling(coefficients: _Floats, most: int | None) -> tuple[_Floats, NDArray[np.int64]]:
    """Return the sizes that tell of the step, by frequency, and how many of each: ``(64,)``."""
    sizes = np.abs(coefficients).reshape(-1, BLOCK_PX**2).T
    told = sizes > _LEAST
    told[0] = False  # sums of clipped pixels, and no zeros to compare with
    if most is not None:
        told &= told.cumsum(axis=1, dtype=np.int32) <= most
    return sizes[told], told.sum(axis=1)


def _log_ratios(seen: _Floats, owner: NDArray[np.int64], steps: _Floats, grids: int) -> _Floats:
    """Return for each grid and step how much likelier it makes what is seen than smoothness does.

    A coefficient that is not zero lies at a multiple of the step, the first or a later one, blurred
    by rounding; the smooth density, spread over a step, cancels. A step that is much larger than
    all of them explains nothing.

    Args:
        seen: ``(n,)`` coefficients of one frequency.
        owner: ``(n,)``, rising: whose each is, 0 to ``grids`` - 1.
        steps: ``(S,)``.
        grids: How many there are.

    Returns:
        ``(grids, S)``.
    """
    each = np.bincount(owner, minlength=grids) * math.log(_OUTLIERS)
    ratios = np.repeat(each[:, None], len(steps), axis=1)
    near = steps <= 2 * seen.max(initial=0.0) + 8
    step, summed = steps[near, None].astype(np.float32), np.zeros((grids, int(near.sum())))
    for start in range(0, len(seen), _AT_ONCE):
        part = slice(start, start + _AT_ONCE)
        times = seen[part].astype(np.float32) / step
        miss = (times - np.maximum(np.rint(times), 1)) * (step / _ROUNDING)
        likely = np.exp(-0.5 * (miss * miss)) * (step / (_ROUNDING * math.sqrt(2 * math.pi)))
        logs = np.log((1 - _OUTLIERS) * likely + _OUTLIERS)
        whose, first = np.unique(owner[part], return_index=True)
        summed[whose] += np.add.reduceat(logs, first, axis=1).T
    ratios[:, near] = summed
    return ratios


_DCT: _Floats = cosine_transform().numpy()
_STEPS = np.stack([luminance_table(quality).ravel() for quality in range(1, 101)])
_UNEQUAL_STEPS = [np.unique(steps, return_inverse=True) for steps in _STEPS.T]
"""Of each frequency, the steps that there are, and which of them each quality has."""
