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
    """

    image: torch.Tensor
    identity_id: str
    landmarks_px: torch.Tensor | None
    source: str
    scale: int = 1
    traits: Traits | None = None


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
