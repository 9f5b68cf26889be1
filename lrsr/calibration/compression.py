"""How were pictures of one camera squeezed, whole frames or faces that were cut out of them?

Faces lie anywhere in their frames, so the blocks of each may fall elsewhere. One face of 32 pixels
shows its own grid: of 80 such pictures at qualities of 40 to 90, all did.

How many samples of colour were kept, and where their blocks begin, a second compression tells: by
the settings that a decoded picture had it hardly changes it, as all its cosines lie on steps of the
table already (this is how Z. Fan, R. de Queiroz, IEEE Trans. Image Processing 12(2), 2003,
doi:10.1109/TIP.2002.807361, and many since tell a compressed picture). Every sub-sampling and every
place of its blocks is tried. At 4:4:4 only rounding is left, 0.2 levels²; interpolated colours do
not come back as exactly, so that 4:4:4 has to prove itself. On 50 pictures of 32 × 32 px all is
right from quality 30 to 90; beyond, 4:2:0 and 4:2:2 may be mistaken for each other.
"""

from collections import Counter
from dataclasses import dataclass
from statistics import median_low

import torch

from lrsr.calibration.jpeg_blocks import JpegEstimate, estimate_jpeg
from lrsr.camera.checks import check_light
from lrsr.camera.codec import jpeg
from lrsr.camera.jpeg_tables import BLOCK_PX
from lrsr.camera.soft_jpeg import SHARING

_AGREEING = 0.8
"""Share of the pictures that show the common grid at least, or each is asked for its own."""
_MARGIN_PX = 4
"""At the border, where blocks are cut off, a picture never comes back."""
_ROUNDED = 0.6
"""Mean square change, levels² of 255, that rounding does not exceed."""
_PLACES = {
    chroma: [(BLOCK_PX * x, BLOCK_PX * y) for y in range(rows) for x in range(columns)]
    for chroma, (rows, columns) in SHARING.items()
}


@dataclass(frozen=True)
class CompressionEstimate:
    """What was found.

    Attributes:
        quality: Of the Independent JPEG Group's scale, 1-100; the middle one if they differ.
        chroma: Sub-sampling, e.g. "4:2:0".
        origins_px: ``(x, y)`` of the first pixel within its block of colour; one for all pictures,
            or one for each that tells, in their order.
    """

    quality: int
    chroma: str
    origins_px: tuple[tuple[int, int], ...]


def estimate_compression(srgb: torch.Tensor) -> CompressionEstimate | None:
    """Find quality, sub-sampling and grids of pictures that went through JPEG.

    Args:
        srgb: ``(B, 3, H, W)``, [0, 1], multiples of 1/255, H and W >= 16.

    Returns:
        The likeliest; None if the pictures show no blocks.

    Raises:
        ImageContractError: The images break the contract or are smaller than 16 × 16.
    """
    common = estimate_jpeg(srgb)
    showing = 0 if common is None else _count(srgb, [common.origin_px])
    if showing < _AGREEING * len(srgb):
        each = [(one[None], estimate_jpeg(one[None])) for one in srgb]
        seen = [(picture, found) for picture, found in each if found is not None]
        if len(seen) > max(showing, len(srgb) / 2):
            return _of_each(seen)
    if common is None:
        return None
    chroma, origin_px = _estimate_chroma(srgb, common.quality, common.origin_px)
    return CompressionEstimate(common.quality, chroma, (origin_px,))


def _count(srgb: torch.Tensor, grids: list[tuple[int, int]]) -> int:
    return sum(estimate_jpeg(one[None], grids=grids) is not None for one in srgb)


def _of_each(seen: list[tuple[torch.Tensor, JpegEstimate]]) -> CompressionEstimate:
    quality = median_low(found.quality for _, found in seen)
    settings = [
        _estimate_chroma(picture, found.quality, found.origin_px) for picture, found in seen
    ]
    chroma = Counter(kind for kind, _ in settings).most_common(1)[0][0]
    origins = tuple(origin_px for kind, origin_px in settings if kind == chroma)
    return CompressionEstimate(quality, chroma, origins)


def _estimate_chroma(
    srgb: torch.Tensor, quality: int, origin_px: tuple[int, int]
) -> tuple[str, tuple[int, int]]:
    """Find the sub-sampling of pictures, and their first pixel's place in the blocks of colour.

    Args:
        srgb: ``(B, 3, H, W)``, [0, 1], multiples of 1/255, H and W >= 16; 20 pictures are plenty.
        quality: 1-100, of their compression.
        origin_px: ``(x, y)`` of the first pixel within a block of luminance, 0..7 each; see
            :func:`lrsr.calibration.jpeg_blocks.estimate_jpeg`.

    Returns:
        "4:4:4", "4:2:2" or "4:2:0", and ``(x, y)``, 0..15 where the blocks of colour are that
        large, else 0..7.

    Raises:
        ImageContractError: The images break the contract.
        InputError: The place or the quality is out of range.
    """
    check_light(srgb, name="srgb")
    x, y = origin_px
    changes = {
        (chroma, (x + right, y + down)): _change(srgb, quality, chroma, (x + right, y + down))
        for chroma, places in _PLACES.items()
        for right, down in places
    }
    full = "4:4:4", (x, y)
    if changes.pop(full) < _ROUNDED:
        return full
    return min(changes, key=lambda setting: changes[setting])


def _change(srgb: torch.Tensor, quality: int, chroma: str, origin_px: tuple[int, int]) -> float:
    """Return by how much another compression changes pictures, levels²."""
    inner = slice(_MARGIN_PX, -_MARGIN_PX)
    again = jpeg(srgb, quality, chroma=chroma, origin_px=origin_px)
    return float((255 * (again - srgb)[..., inner, inner]).square().mean())
