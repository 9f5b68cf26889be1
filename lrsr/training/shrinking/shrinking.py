"""How does a sharp picture become the small one that a network is given? The protocol."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from typing import ClassVar

import torch

from lrsr.camera import Camera
from lrsr.training.patches import Pair


class Shrinking(ABC):
    """A value of the group ``degradation`` for super-resolution.

    Whatever is drawn for a picture follows from its seed, or from that of the first of a few
    pictures that share it: shrunk again from the same seeds, all are the same, bit for bit.

    Attributes:
        redrawn: Pictures are shrunk anew for every epoch, with other seeds.
        reads_camera: The configured camera makes the small pictures.
    """

    redrawn: ClassVar[bool] = True
    reads_camera: ClassVar[bool] = False

    def cameras(self, camera: Camera) -> list[Camera]:
        """Return which cameras take a rendered scene on its small film.

        None: the small picture is made of the sharp one, by a call.

        Args:
            camera: The configured one.
        """
        return []

    @abstractmethod
    def __call__(
        self, true: torch.Tensor, scale: int, seeds: Sequence[int], camera: Camera
    ) -> Iterator[Pair]:
        """Shrink pictures, and yield them with those that they should become again, in order.

        Args:
            true: ``(B, 3, scale H, scale W)`` srgb, multiples of 1/255.
            scale: How many times smaller they become.
            seeds: One for each picture.
            camera: The configured one.

        Yields:
            ``(b, 3, H, W)`` and ``(b, 3, scale H, scale W)`` srgb, multiples of 1/255.
        """

    @abstractmethod
    def in_words(self, camera: Camera, *, of_films: bool) -> str:
        """Say how the small pictures are made, for the card that goes with the weights.

        Args:
            camera: The configured one.
            of_films: The sharp ones are rendered, and so may be the small ones.
        """
