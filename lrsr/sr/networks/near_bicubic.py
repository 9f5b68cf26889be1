"""How does a network that enlarges begin where bicubic ends? A path through it that does the same.

Trained for minutes, a network that starts at random is still below bicubic. One that starts here
loses nothing to it from the first step on, and every weight can learn.
"""

from itertools import product

import torch
from torch import nn

_SMALL = 0.01
_COLOURS = 3


def keys(distance_px: torch.Tensor) -> torch.Tensor:
    """Return Keys' cubic, a = -0.5 (1981, doi:10.1109/TASSP.1981.1163711, eq. 15).

    Example:
        >>> keys(torch.tensor([0.0, 0.5, 1.5, 2.5])).tolist()
        [1.0, 0.5625, -0.0625, 0.0]
    """
    x = distance_px.abs()
    near, far = (1.5 * x - 2.5) * x * x + 1, ((-0.5 * x + 2.5) * x - 4) * x + 2
    return torch.where(x < 1, near, torch.where(x < 2, far, torch.zeros_like(x)))


def _three_taps(scale: int) -> list[torch.Tensor]:
    """Return what each of ``scale`` pixels takes of the pixel that it comes from and of two beside.

    Bicubic takes four; the farthest, which three cannot hold, is given to its neighbour.

    Example:
        >>> [taps.tolist() for taps in _three_taps(2)]
        [[0.203125, 0.8671875, -0.0703125], [-0.0703125, 0.8671875, 0.203125]]
    """
    places = [(pixel + 0.5) / scale - 0.5 for pixel in range(scale)]
    five = [keys(torch.arange(-2.0, 3.0) - place) for place in places]
    return [torch.stack([t[0] + t[1], t[2], t[3] + t[4]]) for t in five]


@torch.no_grad()
def quieten(layer: nn.Module) -> None:
    """Make what a layer returns small, but not zero, which could not be learned from."""
    for parameter in layer.parameters():
        parameter.mul_(_SMALL)


def let_colours_pass(layer: nn.Module) -> None:
    """Let features 0 to 2 of a 3x3 convolution be its inputs 0 to 2: red, green and blue."""
    centre = torch.zeros(3, 3)
    centre[1, 1] = 1
    for colour in range(_COLOURS):
        _let_through(layer, colour, colour, centre)


def let_colours_grow(layer: nn.Module, scale: int) -> None:
    """Let a 3x3 convolution before a pixel shuffle enlarge features 0 to 2 bicubically."""
    for colour in range(_COLOURS):
        for place, (down, right) in enumerate(product(_three_taps(scale), repeat=2)):
            kernel = torch.outer(down, right)
            _let_through(layer, colour, scale**2 * colour + place, kernel)


@torch.no_grad()
def _let_through(layer: nn.Module, source: int, target: int, kernel: torch.Tensor) -> None:
    """Let channel ``target`` be ``source`` through a (3, 3) kernel, and little of the others."""
    weight, bias = layer.get_parameter("weight"), layer.get_parameter("bias")
    weight[target].mul_(_SMALL)
    weight[target, :_COLOURS] = 0.0
    weight[target, source] = kernel
    bias[target] = 0.0
