"""What must a super-resolution network say of itself?"""

from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import ClassVar, Literal

from torch import nn

from lrsr.configuration import require


class Network(nn.Module):
    """A network with plain constructor arguments (numbers, words), which are kept on its card.

    Attributes:
        input: "luminance": (B, 1, H, W), studio BT.601 / 255; "rgb": (B, 3, H, W) srgb, [0, 1];
            "burst": (B, N, C, H, W), frames laid over the first.
        in_use: Arguments that overrule the card's after training. In use a network must return
            the whole picture: ``scale`` times as large if it enlarges, else as large as its input.
        enlarges: Does it take the small picture? Else one that was enlarged bicubically.
    """

    input: ClassVar[Literal["luminance", "rgb", "burst"]]
    enlarges: ClassVar[bool] = True
    in_use: ClassVar[Mapping[str, object]] = MappingProxyType({})

    def takes(self, height: int, width: int) -> tuple[int, ...]:
        """Return the shape of what it takes of one small picture of that size."""
        return (1, 1 if self.input == "luminance" else 3, height, width)

    @property
    def reach_px(self) -> int | None:
        """How far from a pixel of its input what it makes there may depend on; None: on all of it.

        Half the kernels of all convolutions, which is enough where each is used once and none
        shrinks the picture. A network that is built otherwise says its own.
        """
        layers = (
            each for each in self.modules() if isinstance(each, nn.Conv2d | nn.ConvTranspose2d)
        )
        return sum(
            max(d * (k // 2) for d, k in zip(each.dilation, each.kernel_size, strict=True))
            for each in layers
        )


def check_choice(name: str, value: object, choices: Sequence[str]) -> None:
    """Refuse a word that is no choice of an argument.

    Raises:
        InputError: It is none.
    """
    known = isinstance(value, str) and value in choices
    require(known, f"module.arguments.{name}", value, f"one of {', '.join(choices)}")


def check_whole(name: str, value: object, least: int, most: int) -> None:
    """Refuse what is no whole number of the range of an argument.

    Raises:
        InputError: It is none.
    """
    holds = type(value) is int and least <= value <= most
    require(holds, f"module.arguments.{name}", value, f"a whole number, {least} to {most}")
