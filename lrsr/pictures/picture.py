"""What is a picture, wherever it comes from? A rendered probe and a photograph are one type."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from lrsr.errors import InputError
from lrsr.identities.person import Traits


@dataclass(frozen=True)
class Picture:
    """One picture as a camera stored it, and what is known of it.

    Attributes:
        image: ``(3, H, W)`` float32, srgb, [0, 1].
        identity_id: Who it shows; the same id is the same person.
        landmarks_px: ``(5, 2)`` float32, (x, y) in pixels of ``image``, the order of
            :data:`lrsr.identities.head.LANDMARK_NAMES`; None: a detector must find them.
        source: Where it came from: a file, or "rendered" with the names of pose and light.
        scale: How many times finer than the ×1 film.
        traits: What is recorded of who it shows, where it is known.
        later: The other frames of the burst that it is the first of, as large as it.
    """

    image: torch.Tensor
    identity_id: str
    landmarks_px: torch.Tensor | None
    source: str
    scale: int = 1
    traits: Traits | None = None
    later: Sequence["Picture"] = ()


def stack(pictures: Sequence[Picture]) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the images ``(B, 3, H, W)`` and landmarks ``(B, 5, 2)`` of pictures of one size.

    Unknown landmarks are NaN: a failure to acquire, unless a detector finds them.

    Raises:
        InputError: The sizes differ, or there are none.
    """
    sizes = sorted({tuple(picture.image.shape[1:]) for picture in pictures})
    if len(sizes) != 1:
        raise InputError(f"pictures of sizes {sizes} make no batch: wanted one size")
    nowhere = torch.full((5, 2), torch.nan)
    points = [nowhere if one.landmarks_px is None else one.landmarks_px for one in pictures]
    return torch.stack([picture.image for picture in pictures]), torch.stack(points)


def stack_bursts(pictures: Sequence[Picture], frames: int) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the first frames of bursts, ``(B, N, 3, H, W)``, and landmarks ``(B, N, 5, 2)``.

    Args:
        pictures: Of one size; each the first frame of its burst.
        frames: How many of each, N.

    Raises:
        InputError: The sizes differ, there are none, or a burst has fewer frames.
    """
    for picture in pictures:
        if len(picture.later) < frames - 1:
            raise InputError(
                f"{picture.source} ({picture.identity_id}) has {1 + len(picture.later)} frames:"
                f" wanted {frames}"
            )
    several = [one for first in pictures for one in (first, *first.later[: frames - 1])]
    images, points = stack(several)
    images = images.reshape(-1, frames, *images.shape[1:])
    return images, points.reshape(-1, frames, 5, 2)
