"""How is a small srgb picture made larger? One protocol, and everything that keeps it."""

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from math import ceil
from numbers import Integral
from typing import Protocol

import torch

from lrsr.configuration import as_word
from lrsr.errors import InputError, NonFiniteError
from lrsr.images import (
    check_images,
    check_srgb,
    luminance,
    resize_bicubic,
    rgb_to_ycbcr,
    ycbcr_to_rgb,
)
from lrsr.sr.networks.network import Network
from lrsr.sr.tiles import check_size
from lrsr.sr.weights import ENLARGED_BY, LARGEST_SCALE, Card

_BICUBIC_REACH_PX = 2
"""Of the small picture."""


class Upscaler(Protocol):
    """Makes pictures larger.

    Attributes:
        label: Its name in tables.
        scale: New size over old.
        learned: Did it learn from pictures? Then it must beat the bicubic of the same scale.
        reach_px: How far from a pixel of the small picture what is made of it may depend on; None:
            unknown, or on all of it. Tiles of large pictures overlap by that.
        multiple_of: Where tiles may begin, rows and columns of the small picture.
    """

    label: str
    scale: int
    learned: bool
    reach_px: int | None
    multiple_of: int

    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 3, H, W) srgb in [0, 1] to (B, 3, scale * H, scale * W), clipped to [0, 1].

        No gradient is kept, and nothing is rounded to 8 bits.
        """

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it: label, scale, kind, file, sha256, ..."""


class OneStep:
    """What every upscaler of one step shares: the contract at both ends, batches, the device.

    Attributes:
        about: What :meth:`describe` says beside label and scale.
        batch_size: Pictures that go through at once; 32 of 128x128 take SRCNN about 200 MB.
    """

    learned = True
    batch_size = 32
    reach_px: int | None = None
    multiple_of = 1

    def __init__(self, label: str, scale: int, device: str, **about: object) -> None:
        self.label, self.scale = as_word(label, "label"), scale
        nothing = dict.fromkeys(("file", "sha256", "architecture", "lr_made_by", "kernel"), "")
        self.about = nothing | about
        self._device = _usable(device)

    @torch.no_grad()
    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge; see :class:`Upscaler`.

        Raises:
            ImageContractError: The pictures break the contract or lie outside [0, 1], or a network
                enlarges by another factor than its card says.
            InputError: A network returned a NaN or an infinity.
        """
        check_srgb(srgb, may_need_gradient=True)
        parts = []
        for part in torch.split(srgb.detach(), self.batch_size):
            with blaming_weights(self.label, self.about):
                larger = check_images(self._enlarge(part.to(self._device)), name=self.label)
            check_size(larger, part, self.scale, self.label)
            parts.append(larger.clamp(0.0, 1.0))
        return torch.cat(parts).to(srgb.device)

    def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
        return srgb if self.scale == 1 else resize_bicubic(srgb, self.scale)

    def describe(self) -> dict[str, object]:
        """Return label, scale, kind, file, sha256, architecture, lr_made_by and kernel."""
        return {"label": self.label, "scale": self.scale, **self.about}


class Bicubic(OneStep):
    """Keys' cubic, a = -0.5; a scale of 1 leaves the picture as the camera made it ("Base").

    Args:
        scale: New size over old, 1 to 16.
        label: Its name in tables.
        device: Where it runs, "cpu" or "cuda".

    Raises:
        InputError: The scale is out of range, or torch cannot use the device.

    Example:
        >>> Bicubic(4)(torch.full((1, 3, 8, 6), 0.5)).shape
        torch.Size([1, 3, 32, 24])
    """

    learned = False
    reach_px: int | None = _BICUBIC_REACH_PX

    def __init__(self, scale: int, label: str | None = None, *, device: str = "cpu") -> None:
        if not _is_whole(scale) or not 1 <= scale <= LARGEST_SCALE:
            raise InputError(f"scale={scale}: wanted a whole number from 1 to {LARGEST_SCALE}")
        scale = int(scale)
        label = label or ("Base" if scale == 1 else f"Bicubic {scale}")
        kernel = ENLARGED_BY if scale > 1 else ""
        super().__init__(label, scale, device, kind="bicubic", kernel=kernel)


class OfNetwork(OneStep, ABC):
    """A network of any kind: on luminance or on colours, behind bicubic enlargement or not."""

    _on_luminance: bool
    _enlarged: bool

    @abstractmethod
    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        """Run the network on ``(B, C, H, W)``."""

    def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
        if not self._on_luminance:
            return self._restore(super()._enlarge(srgb).clamp(0, 1) if self._enlarged else srgb)
        ycbcr = rgb_to_ycbcr(super()._enlarge(srgb))
        restored = self._restore(ycbcr[:, :1] if self._enlarged else luminance(srgb))
        return ycbcr_to_rgb(torch.cat([restored, ycbcr[:, 1:]], dim=1))

    def _reach(self, network_px: int | None) -> int | None:
        """Return the reach in pixels of the small picture, of that in pixels of the network's."""
        if network_px is None or not (self._enlarged or self._on_luminance):
            return network_px
        if self._enlarged:
            return ceil(network_px / self.scale) + _BICUBIC_REACH_PX
        return max(network_px, _BICUBIC_REACH_PX)


class _OfCard(OfNetwork):
    """A network of ours and what its card says.

    Args:
        network: As :func:`lrsr.sr.weights.read_weights` gives it.
        card: What it was trained for.
        label: Its name in tables; the architecture and the scale when None.
        device: Where it runs, "cpu" or "cuda".

    Raises:
        InputError: The network takes other input, or torch cannot use the device.
    """

    def __init__(
        self, network: Network, card: Card, label: str | None = None, *, device: str = "cpu"
    ) -> None:
        if card.input != ("luminance" if self._on_luminance else "rgb"):
            raise InputError(f"{card.architecture} takes {card.input}: use the other wrapper")
        kernel = ENLARGED_BY if self._on_luminance else card.enlarged_by  # of the chroma, at least
        about = {"kind": card.input, "lr_made_by": card.lr_made_by, "kernel": kernel}
        label = label or f"{card.architecture} {card.scale}"
        super().__init__(label, card.scale, device, architecture=card.architecture, **about)
        self._network, self._enlarged = network.to(self._device), bool(card.enlarged_by)
        self.reach_px = self._reach(network.reach_px)

    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        restored: torch.Tensor = self._network(images)
        return restored


class Luminance(_OfCard):
    """A network that restores the luminance, as SRCNN does; the chroma goes up bicubically."""

    _on_luminance = True


class Rgb(_OfCard):
    """A network that makes large srgb of small srgb, as EDSR does."""

    _on_luminance = False


class Repeated:
    """An upscaler taken several times, such as SRCNN 2x2.

    Args:
        upscaler: One step.
        times: How often, at least 1.
        label: Its name in tables.

    Raises:
        InputError: ``times`` is no whole number above 0.
    """

    def __init__(self, upscaler: Upscaler, times: int, label: str | None = None) -> None:
        if not _is_whole(times) or times < 1:
            raise InputError(f"repeat={times}: wanted a whole number above 0")
        times = int(times)
        self.label = as_word(label or f"{upscaler.label}, {times} times", "label")
        self.scale: int = upscaler.scale**times
        self.learned = upscaler.learned
        self.multiple_of = upscaler.multiple_of
        reach_px = upscaler.reach_px  # of the first step; of the others, in its pixels
        steps = [] if reach_px is None else [reach_px / upscaler.scale**k for k in range(times)]
        self.reach_px: int | None = sum(map(ceil, steps)) or reach_px
        self._upscaler, self._times = upscaler, times

    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge; see :class:`Upscaler`."""
        for _ in range(self._times):
            srgb = self._upscaler(srgb)
        return srgb

    def describe(self) -> dict[str, object]:
        """Return what the step says of itself, and how often it is taken."""
        own: dict[str, object] = {"label": self.label, "scale": self.scale, "times": self._times}
        return self._upscaler.describe() | own


@contextmanager
def blaming_weights(label: str, about: Mapping[str, object]) -> Iterator[None]:
    """Say of a NaN that a method makes of good pictures that it is its weights' fault.

    Args:
        label: The method's name in tables.
        about: What it says of itself, such as the "file" of its weights.

    Raises:
        InputError: It makes one, or an infinity.
    """
    try:
        yield
    except NonFiniteError as error:
        name = f"{label} ({about['file']})" if about.get("file") else label
        raise InputError(f"{name} makes no numbers ({error}): give other weights") from error


def _is_whole(value: object) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool)


def _usable(device: str) -> torch.device:
    try:
        return torch.empty(0, device=device).device
    except (RuntimeError, AssertionError, TypeError) as error:  # torch knows no better
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"device={device}: torch cannot use it here ({reason}); give cpu"
        ) from error
