"""How were pictures of one camera squeezed, whole frames or faces that were cut out of them?

Faces lie anywhere in their frames, so the blocks of each may fall elsewhere. One face of 32 pixels
shows its own grid: of 80 such pictures at qualities of 40 to 90, all did.
"""

from collections import Counter
from dataclasses import dataclass
from statistics import median_low

import torch

from lrsr.camera.chroma_estimate import estimate_chroma
from lrsr.camera.jpeg_estimate import JpegEstimate, estimate_jpeg

AGREEING = 0.8
"""Share of the pictures that show the common grid at least, or each is asked for its own."""


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
    if showing < AGREEING * len(srgb):
        each = [(one[None], estimate_jpeg(one[None])) for one in srgb]
        seen = [(picture, found) for picture, found in each if found is not None]
        if len(seen) > max(showing, len(srgb) / 2):
            return _of_each(seen)
    if common is None:
        return None
    chroma, origin_px = estimate_chroma(srgb, common.quality, common.origin_px)
    return CompressionEstimate(common.quality, chroma, (origin_px,))


def _count(srgb: torch.Tensor, grids: list[tuple[int, int]]) -> int:
    return sum(estimate_jpeg(one[None], grids=grids) is not None for one in srgb)


def _of_each(seen: list[tuple[torch.Tensor, JpegEstimate]]) -> CompressionEstimate:
    quality = median_low(found.quality for _, found in seen)
    settings = [estimate_chroma(picture, found.quality, found.origin_px) for picture, found in seen]
    chroma = Counter(kind for kind, _ in settings).most_common(1)[0][0]
    origins = tuple(origin_px for kind, origin_px in settings if kind == chroma)
    return CompressionEstimate(quality, chroma, origins)
