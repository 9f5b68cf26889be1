"""What does a room look like from where the head is? A panorama from a file, as a small map."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.rendering.backend import mi


def load_map(file: str | Path, turned_deg: float, height_px: int) -> NDArray[np.float64]:
    """Read a latitude-longitude map and average it down to a map of ``height_px`` rows.

    Light is kept: a pixel of the small map is the mean over its solid angle. Rows of the file lie
    between latitudes; those of the small map are on them, the first and last at the poles.

    Args:
        file: ``.exr``, ``.hdr`` or whatever else Mitsuba's ``Bitmap`` reads; RGB or one channel,
            linear, twice as wide as high.
        turned_deg: About the vertical; 90 brings the middle to the image's right.
        height_px: Rows.

    Returns:
        ``(height_px, 2 height_px, 3)``, >= 0, in the units of the file.

    Raises:
        InputError: The file cannot be read, is not 2:1, or holds a NaN, an infinity or a negative
            value.
    """
    values = _read(Path(file))
    height, width = values.shape[:2]
    if width != 2 * height or height < 2:
        raise InputError(f"map {file} is {width} x {height} px: give one twice as wide as high")
    if not np.isfinite(values).all():
        count = int((~np.isfinite(values).all(axis=2)).sum())
        raise InputError(f"map {file} has {count} pixels that are NaN or infinite: mend them")
    if values.min() < 0:
        raise InputError(f"map {file} has a value of {values.min():.3g}: light cannot be negative")
    edges = np.linspace(0, np.pi, height + 1)
    lines = np.linspace(0, np.pi, height_px)
    cuts = np.concatenate([[0.0], (lines[1:] + lines[:-1]) / 2, [np.pi]])
    # How much of a row's area lies in each new row: equal steps of cos θ are equal areas.
    share = _overlap(np.cos(edges)[::-1], np.cos(cuts)[::-1])[::-1, ::-1]
    rows = np.tensordot((share / share.sum(axis=0)).T, values, axes=1)
    # The face's left, the image's right, is on the left of the map, as a panorama shows it.
    shift = (-turned_deg / 360 * width) % width
    thrice = np.arange(-width, 2 * width + 1, dtype=np.float64) + shift
    spread = _overlap(thrice, np.linspace(0, width, 2 * height_px + 1))
    spread = spread.reshape(3, width, -1).sum(axis=0)
    averaged = np.einsum("kwc,wn->knc", rows, spread) / spread.sum(axis=0)[:, None]
    return np.asarray(averaged, dtype=np.float64)


def _read(file: Path) -> NDArray[np.float64]:
    """Return the pixels ``(H, W, 3)``.

    Raises:
        InputError: It cannot be read.
    """
    try:
        bitmap = mi.Bitmap(str(file))
        raw = np.array(bitmap, dtype=np.float64)
    except (RuntimeError, OSError) as error:
        reason = str(error).strip().splitlines()[-1][:200]
        raise InputError(f"map {file} cannot be read ({reason}): give an .exr or .hdr") from error
    if raw.ndim == 2:
        raw = raw[..., None]
    if bitmap.srgb_gamma() or raw.shape[2] not in (1, 3, 4):
        raise InputError(f"map {file} is no linear RGB image: give an .exr or .hdr")
    colours: NDArray[np.float64] = np.broadcast_to(raw[..., :3], (*raw.shape[:2], 3))
    return colours


def _overlap(old: NDArray[np.float64], new: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return how long each old interval ``(N + 1,)`` overlaps each new one, ``(N, M)``."""
    low = np.maximum(old[:-1, None], new[None, :-1])
    high = np.minimum(old[1:, None], new[None, 1:])
    return np.asarray(np.clip(high - low, 0, None))
