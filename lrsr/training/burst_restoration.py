"""How does a network learn to fuse? From bursts of any length; judged beside their mean."""

from collections.abc import Callable
from types import MappingProxyType

import torch

from lrsr.pictures.recipe import derived_seed
from lrsr.sr.fusion import Mean
from lrsr.sr.learned_fusion import Learned
from lrsr.sr.networks.network import Network
from lrsr.training.restoration import Restoration


class BurstRestoration(Restoration):
    """A network of the input "burst"; each step shows it another number of frames.

    A training batch is what :class:`lrsr.training.bursts.LaidOver` cuts; a validation batch is
    srgb, ``(1, N, 3, H, W)`` small and ``(1, 3, scale H, scale W)`` true. Arguments and errors are
    the base's; nothing is turned, as a turned frame's points lie in another order.
    """

    lessons = ("bursts",)
    inputs = ("burst",)
    free = MappingProxyType({0: "B", 1: "N", 3: "H", 4: "W"})

    def restore(self, inputs: torch.Tensor) -> torch.Tensor:
        """Fuse the first few frames, from one to all, as the seed and the step say."""
        few = 1 + derived_seed(self.seed, "frames", self.global_step) % inputs.shape[1]
        fused: torch.Tensor = self.network(inputs[:, :few])
        return fused

    def in_use(self, network: Network) -> Callable[[torch.Tensor], torch.Tensor]:
        """Return what fuses bursts by a network."""
        return Learned(network, self.card)

    def rivals(self, small: torch.Tensor) -> dict[str, torch.Tensor]:
        """Return the bicubic of the first frame, and the mean of all."""
        mean = Mean(self.card.scale)
        return {"bicubic": mean(small[:, :1]), "mean": mean(small)}
