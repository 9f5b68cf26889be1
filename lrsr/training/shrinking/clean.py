"""What is small and nothing else? The clean film of a scene, or a picture shrunk bicubically.

The latter is the field's protocol: MATLAB's ``imresize`` (:func:`lrsr.images.resize_bicubic`),
stored in 8 bits as the benchmarks' files are.
"""

from collections.abc import Iterator, Sequence

import torch

from lrsr.camera import Camera
from lrsr.camera.encoding import quantise
from lrsr.images import resize_bicubic
from lrsr.training.patches import Pair
from lrsr.training.shrinking.shrinking import Shrinking


class Clean(Shrinking):
    """Nothing is done but to make it small.

    Example:
        >>> small, true = next(Clean()(torch.ones(1, 3, 8, 6), 2, [0], Camera()))
        >>> small.shape, small.min().item()
        (torch.Size([1, 3, 4, 3]), 1.0)
    """

    redrawn = False

    def cameras(self, camera: Camera) -> list[Camera]:
        """Return the configured camera without its flaws, of the same exposure."""
        return [camera.clean()]

    def __call__(
        self, true: torch.Tensor, scale: int, seeds: Sequence[int], camera: Camera
    ) -> Iterator[Pair]:
        """Shrink pictures bicubically; see the base."""
        yield quantise(resize_bicubic(true, 1 / scale).clamp(0, 1)), true

    def in_words(self, camera: Camera, *, of_films: bool) -> str:
        """Say how the small pictures are made."""
        if of_films:
            return "the same scene rendered through a film of 1/scale the pixels, no down-sampling"
        return "pictures shrunk bicubically, a = -0.5, antialiased, 8 bits"
