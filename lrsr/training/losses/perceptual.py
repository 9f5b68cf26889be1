"""Does the restored picture look like the true one? As a classifier of photographs sees both."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import torch
from safetensors.torch import load_file
from torch import nn
from torch.nn import functional as F

from lrsr.configuration import as_whole, require
from lrsr.errors import InputError
from lrsr.files import check_file
from lrsr.paths import user_path
from lrsr.training.losses.term import Term

_NETWORKS = ("vgg11", "vgg13", "vgg16", "vgg19")
#: Of ImageNet, which torchvision's networks were trained on.
_MEAN, _DEVIATION = (0.485, 0.456, 0.406), (0.229, 0.224, 0.225)


class PerceptualLoss(Term):
    """Mean absolute difference of the features of a VGG (Johnson et al. 2016, arXiv:1603.08155).

    Args:
        weight: In the sum.
        weights: A file of torchvision's weights for the network, ``.pth`` or ``.safetensors``;
            nothing is downloaded.
        network: vgg11, vgg13, vgg16 or vgg19.
        layer: Number of the layer in torchvision's ``features`` whose output is compared; 34 of
            vgg19 is the last convolution before its rectifier (Wang et al. 2018, arXiv:1809.00219).

    Raises:
        InputError: A setting is out of range, or the file is missing or of another network.
    """

    def __init__(
        self, *, weight: float, weights: str | Path, network: str = "vgg19", layer: int = 34
    ) -> None:
        super().__init__("perceptual", weight)
        known = isinstance(network, str) and network in _NETWORKS
        wish = f"one of {', '.join(_NETWORKS)}"
        require(known, "module.losses.perceptual.network", network, wish)
        layers = _layers(network)
        number = as_whole(layer, "module.losses.perceptual.layer")
        wish = f"0 to {len(layers) - 1}, a layer of {network}"
        require(0 <= number < len(layers), "module.losses.perceptual.layer", layer, wish)
        path = user_path(weights, "module.losses.perceptual.weights")
        state = {
            name.removeprefix("features."): tensor.float()
            for name, tensor in _read(path).items()
            if name.startswith("features.")
        }
        try:
            layers.load_state_dict(state, assign=True)
        except RuntimeError as error:
            reason = " ".join(str(error).split())[:160]
            raise InputError(f"{path} is not of torchvision's {network}: {reason}") from error
        self._network = (layers[: number + 1].eval().requires_grad_(False),)  # no part of the state

    def forward(
        self,
        restored: torch.Tensor,
        targets: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Return the mean over pictures, channels and places; see the base."""
        with torch.no_grad():
            wanted = self._see(targets)
        return F.l1_loss(self._see(restored), wanted)

    def _see(self, srgb: torch.Tensor) -> torch.Tensor:
        mean, deviation = (srgb.new_tensor(x).view(3, 1, 1) for x in (_MEAN, _DEVIATION))
        seen: torch.Tensor = self._network[0].to(srgb.device)((srgb - mean) / deviation)
        return seen


def _layers(network: str) -> nn.Sequential:
    """Return the convolutions of a VGG without memory for what is replaced at once."""
    from torchvision import models  # seconds, and few ask for it

    with torch.device("meta"):
        layers: nn.Sequential = getattr(models, network)(weights=None).features
    for layer in layers:
        if isinstance(layer, nn.ReLU):
            layer.inplace = False  # what is compared may stand right before it
    return layers


def _read(path: Path) -> Mapping[str, Any]:
    """Read tensors by their names.

    Raises:
        InputError: The file is missing, broken, or holds more than numbers and strings.
    """
    try:
        check_file(path)
        if path.suffix == ".safetensors":
            return dict(load_file(path))
        state: Any = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # broken bytes make the unpickler raise nearly anything
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{path}: no weights of torchvision ({reason}); get it again") from error
    if not isinstance(state, dict):
        raise InputError(f"{path}: no weights of torchvision; get it again")
    return dict(state)
