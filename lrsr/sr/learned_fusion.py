"""How does a network fuse a burst? Frames are laid over the first, and it weighs and restores."""

from math import pi
from pathlib import Path

import torch
from torch.nn import functional as F

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.sr.fusion import Registering, lay_over, pixels_through
from lrsr.sr.loading import find_weights
from lrsr.sr.networks.network import Network
from lrsr.sr.registration import Registration
from lrsr.sr.weights import Card, read_weights


class Learned(Registering):
    """A network of the input "burst", such as :class:`lrsr.sr.networks.fusion.Fusion`.

    Args:
        network: As :func:`lrsr.sr.weights.read_weights` gives it.
        card: What it was trained for.
        registration: Default: by correlation, as in training.
        label: Its name in tables.

    Raises:
        InputError: The network takes single pictures.
    """

    learned = True

    def __init__(
        self,
        network: Network,
        card: Card,
        registration: Registration | None = None,
        label: str = "Learned",
    ) -> None:
        if card.input != "burst":
            raise InputError(f"{card.architecture} takes {card.input}, not a burst: give it to sr=")
        super().__init__(card.scale, registration, label)
        self._network, self._kind = network, card.architecture
        self.about["lr_made_by"] = card.lr_made_by

    def _fuse(self, frames: torch.Tensor, motions: torch.Tensor) -> torch.Tensor:
        fused: torch.Tensor = self._network(laid_over(frames, motions, self.scale))
        return fused

    def describe(self) -> dict[str, object]:
        """Return what every fusion says, how its lessons were made, and which file it is."""
        return {**super().describe(), **self.about}


def load_fusion(
    weights: Path, registration: Registration | None = None, label: str = "Learned"
) -> Learned:
    """Load a network that fuses.

    Args:
        weights: A ``.safetensors`` or ``.ckpt`` file of ``lrsr train sr=fusion4x``. A name that
            does not lead to a file from here is looked for among those that ship.
        registration: Default: by correlation, as in training.
        label: Its name in tables.

    Raises:
        InputError: The file is missing, broken, or of a network that takes single pictures.
    """
    path = find_weights(weights)
    fusion = Learned(*read_weights(path), registration, label)
    fusion.about |= {"file": path.name, "sha256": sha256_of(path)}
    return fusion


def laid_over(frames: torch.Tensor, motions: torch.Tensor, scale: int) -> torch.Tensor:
    """Look at every frame where the points of the first one are, and say how near its pixels lie.

    Between pixels a frame tells what the cubic makes of its neighbours: how far they are is what a
    network needs to find what lies between them (Bhat et al. 2021, section 3.3).

    Args:
        frames: ``(B, N, 3, H, W)`` srgb.
        motions: ``(B, N, 2, 3)`` of :class:`lrsr.sr.registration.Registration`.
        scale: How much finer the grid of points is.

    Returns:
        ``(B, N, 4 * scale², H, W)``, the points of each pixel of the first frame as
        :func:`torch.nn.functional.pixel_unshuffle` orders them: three colours, and 1 at the centre
        of a pixel to 1/4 amid four of them; 0 all of it where the frame does not reach.
    """
    colours = lay_over(frames, motions, scale)
    points = pixels_through(motions, (colours.shape[-2], colours.shape[-1]), scale)
    near = ((3 + torch.cos(2 * pi * points)) / 4).prod(dim=-1)[:, :, None]
    both = torch.cat([colours, near.where(colours[:, :, :1].isfinite(), 0.0)], dim=2)
    return F.pixel_unshuffle(both.nan_to_num(), scale)
