"""How is a small srgb image made larger: not at all, bicubically, by SRCNN, or by SRCNN twice?"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

import torch
from torch import nn

from lrsr.errors import InputError
from lrsr.images import check_images, rgb_to_ycbcr, ycbcr_to_rgb
from lrsr.paths import asset
from lrsr.sr.bicubic import resize_bicubic
from lrsr.sr.weights import read_weights


@dataclass(frozen=True)
class Method:
    """One way of enlarging.

    Attributes:
        label: Its name in tables.
        step_scale: How many times larger one step makes the image; 1 leaves it as it is.
        steps: How often the step is taken.
        weights: The file of the network, below ``lrsr/assets``; None is plain bicubic.
    """

    label: str
    step_scale: int
    steps: int = 1
    weights: str | None = None

    @property
    def scale(self) -> int:
        """New size over old."""
        scale: int = self.step_scale**self.steps
        return scale


#: Every method by its name in configurations, in the order of the paper's tables.
METHODS: Mapping[str, Method] = MappingProxyType(
    {
        "base": Method("Base", 1),
        "bicubic2": Method("Bicubic 2", 2),
        "bicubic4": Method("Bicubic 4", 4),
        "srcnn2": Method("SR 2", 2, weights="weights/srcnn2x.safetensors"),
        "srcnn2x2": Method("SR 2x2", 2, steps=2, weights="weights/srcnn2x.safetensors"),
        "srcnn4": Method("SR 4", 4, weights="weights/srcnn4x.safetensors"),
    }
)


class Upscaler(nn.Module):
    """One call for every method: srgb in, srgb out.

    SRCNN restores the luminance; the chroma goes up bicubically. The result is clipped to [0, 1]
    and not quantised. No gradient is kept.

    Args:
        method: A name in :data:`METHODS`.
        weights: A ``.safetensors`` or ``.ckpt`` file instead of the shipped one; only for SRCNN.
        batch_size: Images that go through at once; 32 of 128x128 take about 200 MB.

    Attributes:
        method: Its name.
        label: Its name in tables.
        scale: New size over old: 1, 2 or 4.

    Raises:
        InputError: The method is unknown, takes no weights, or the weights are for another scale.

    Example:
        >>> Upscaler("bicubic4")(torch.full((1, 3, 8, 6), 0.5)).shape
        torch.Size([1, 3, 32, 24])
    """

    def __init__(self, method: str, weights: Path | None = None, *, batch_size: int = 32) -> None:
        super().__init__()
        if method not in METHODS:
            raise InputError(f"no upscaling method {method!r}: choose one of {', '.join(METHODS)}")
        self._method = METHODS[method]
        self.method = method
        self.label = self._method.label
        self.scale = self._method.scale
        self.batch_size = batch_size
        self.network: nn.Module | None = None
        if self._method.weights is not None:
            self.network = _network(method, weights or asset(self._method.weights))
        elif weights is not None:
            raise InputError(f"{method} takes no weights, got {weights}: leave them out")

    @torch.no_grad()
    def forward(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge.

        Args:
            srgb: (B, 3, H, W), [0, 1].

        Returns:
            srgb: (B, 3, scale * H, scale * W), [0, 1].

        Raises:
            ImageContractError: The images break the contract.
        """
        check_images(srgb, name="srgb")
        if self.scale == 1:
            return srgb
        return torch.cat([self._enlarge(part) for part in torch.split(srgb, self.batch_size)])

    def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
        for _ in range(self._method.steps):
            larger = resize_bicubic(srgb, self._method.step_scale)
            if self.network is not None:
                ycbcr = rgb_to_ycbcr(larger)
                restored = self.network(ycbcr[:, :1])
                larger = ycbcr_to_rgb(torch.cat([restored, ycbcr[:, 1:]], dim=1))
            srgb = larger.clamp(0.0, 1.0)
        return srgb


def _network(method: str, path: Path) -> nn.Module:
    network, recipe = read_weights(path)
    wanted = METHODS[method].step_scale
    if recipe.scale != wanted:
        raise InputError(
            f"{path} was trained for {recipe.scale}x, but {method} needs {wanted}x:"
            f" give the weights of lrsr train sr=srcnn{wanted}x"
        )
    return network
