"""How is a small srgb picture made larger? One protocol, and everything that keeps it."""

from abc import ABC, abstractmethod
from math import ceil
from numbers import Integral
from pathlib import Path
from typing import Protocol

import numpy as np
import torch
from torch import nn

from lrsr.errors import InputError
from lrsr.images import (
    check_images,
    check_srgb,
    luminance,
    resize_bicubic,
    rgb_to_ycbcr,
    ycbcr_to_rgb,
)
from lrsr.onnx import check_graph, open_session, providers_on, run_session, sha256_of
from lrsr.paths import PACKAGE
from lrsr.sr.contract import read_contract
from lrsr.sr.tiles import check_size, run_in_tiles
from lrsr.sr.weights import ENLARGED_BY, LARGEST_SCALE, Card, read_weights


class Upscaler(Protocol):
    """Makes pictures larger.

    Attributes:
        label: Its name in tables.
        scale: New size over old.
        learned: Did it learn from pictures? Then it must beat the bicubic of the same scale.
    """

    label: str
    scale: int
    learned: bool

    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge (B, 3, H, W) srgb in [0, 1] to (B, 3, scale * H, scale * W), clipped to [0, 1].

        No gradient is kept, and nothing is rounded to 8 bits.
        """

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it: label, scale, kind, file, sha256, ..."""


class _OneStep:
    """What every upscaler of one step shares: the contract at both ends, batches, the device.

    Attributes:
        about: What :meth:`describe` says beside label and scale.
        batch_size: Pictures that go through at once; 32 of 128x128 take SRCNN about 200 MB.
    """

    learned = True
    batch_size = 32

    def __init__(self, label: str, scale: int, device: str, **about: object) -> None:
        self.label, self.scale = label, scale
        nothing = dict.fromkeys(("file", "sha256", "architecture", "lr_made_by", "kernel"), "")
        self.about = nothing | about
        self._device = _usable(device)

    @torch.no_grad()
    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge; see :class:`Upscaler`.

        Raises:
            ImageContractError: The pictures break the contract or lie outside [0, 1], or a network
                enlarges by another factor than its card says.
            NonFiniteError: A network returned a NaN or an infinity.
        """
        check_srgb(srgb, may_need_gradient=True)
        parts = []
        for part in torch.split(srgb.detach(), self.batch_size):
            larger = check_images(self._enlarge(part.to(self._device)), name=self.label)
            check_size(larger, part, self.scale, self.label)
            parts.append(larger.clamp(0.0, 1.0))
        return torch.cat(parts).to(srgb.device)

    def _enlarge(self, srgb: torch.Tensor) -> torch.Tensor:
        return srgb if self.scale == 1 else resize_bicubic(srgb, self.scale)

    def describe(self) -> dict[str, object]:
        """Return label, scale, kind, file, sha256, architecture, lr_made_by and kernel."""
        return {"label": self.label, "scale": self.scale, **self.about}


class Bicubic(_OneStep):
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

    def __init__(self, scale: int, label: str | None = None, *, device: str = "cpu") -> None:
        if not _is_whole(scale) or not 1 <= scale <= LARGEST_SCALE:
            raise InputError(f"scale={scale}: wanted a whole number from 1 to {LARGEST_SCALE}")
        scale = int(scale)
        label = label or ("Base" if scale == 1 else f"Bicubic {scale}")
        kernel = ENLARGED_BY if scale > 1 else ""
        super().__init__(label, scale, device, kind="bicubic", kernel=kernel)


class _Network(_OneStep, ABC):
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


class _OfCard(_Network):
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
        self, network: nn.Module, card: Card, label: str | None = None, *, device: str = "cpu"
    ) -> None:
        if self._on_luminance != (card.input == "luminance"):
            raise InputError(f"{card.architecture} takes {card.input}: use the other wrapper")
        kernel = ENLARGED_BY if self._on_luminance else card.enlarged_by  # of the chroma, at least
        about = {"kind": card.input, "lr_made_by": card.lr_made_by, "kernel": kernel}
        label = label or f"{card.architecture} {card.scale}"
        super().__init__(label, card.scale, device, architecture=card.architecture, **about)
        self._network, self._enlarged = network.to(self._device), bool(card.enlarged_by)

    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        restored: torch.Tensor = self._network(images)
        return restored


class Luminance(_OfCard):
    """A network that restores the luminance, as SRCNN does; the chroma goes up bicubically."""

    _on_luminance = True


class Rgb(_OfCard):
    """A network that makes large srgb of small srgb, as EDSR does."""

    _on_luminance = False


class Onnx(_Network):
    """An ONNX network: somebody's with its contract beside it, or one that ``lrsr train`` made.

    Args:
        model: The ``.onnx`` file; see :mod:`lrsr.sr.contract`.
        label: Its name in tables; the file's when None.
        device: "cpu", or "cuda" where onnxruntime has it.

    Raises:
        InputError: The file or its contract is missing or broken, or they disagree.
    """

    def __init__(self, model: Path, label: str | None = None, *, device: str = "cpu") -> None:
        self._model, self._session = model, open_session(model, providers_on(device))
        properties = self._session.get_modelmeta().custom_metadata_map
        self.contract = told = read_contract(model, properties)
        words = f"float {told.layout} of {told.channels}"
        check_graph(self._session, model, "an upscaler", told.shape, told.shape, (words, words))
        self._on_luminance, self._enlarged = told.channels == "Y", told.enlarged
        kernel = ENLARGED_BY if self._enlarged or self._on_luminance else ""
        about = {"kind": "onnx", "file": model.name, "sha256": told.sha256, "kernel": kernel}
        about |= {"architecture": told.source, "lr_made_by": told.lr_made_by}
        super().__init__(label or model.stem, told.scale, "cpu", **about)

    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        shape, many = self._session.get_inputs()[0].shape, self.contract.multiple_of
        fixed = shape[2:] if self.contract.layout == "NCHW" else shape[1:3]
        height, width = (
            size if isinstance(size, int) else many * ceil(have / many)
            for size, have in zip(fixed, images.shape[-2:], strict=True)
        )
        factor = 1 if self._enlarged else self.scale
        return run_in_tiles(images, self._run, tile_px=(height, width), factor=factor)

    def _run(self, images: torch.Tensor) -> torch.Tensor:
        """Run the network on (B, C, h, w), as the contract says."""
        told = self.contract
        given = images.flip(1) if told.channels == "BGR" else images
        given = given.permute(0, 2, 3, 1) if told.layout == "NHWC" else given
        values = np.ascontiguousarray((given * told.white).numpy())
        got = run_session(self._session, self._model, values, batch_size=self.batch_size)
        result = torch.from_numpy(got) / told.white
        result = result.permute(0, 3, 1, 2) if told.layout == "NHWC" else result
        return result.flip(1) if told.channels == "BGR" else result


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
        self.label = label or f"{upscaler.label}, {times} times"
        self.scale: int = upscaler.scale**times
        self.learned = upscaler.learned
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


def load_upscaler(
    weights: Path, label: str | None = None, repeat: int = 1, *, device: str = "cpu"
) -> Upscaler:
    """Load a network by its file, whatever it is.

    Args:
        weights: A ``.safetensors``, ``.ckpt`` or ``.onnx`` file of ``lrsr train``, or somebody's
            ``.onnx``. A name that does not lead to a file from here is looked for among those that
            ship, e.g. "weights/srcnn2x.safetensors".
        label: Its name in tables; the file's when None.
        repeat: How often it is taken.
        device: Where it runs, "cpu" or "cuda".

    Raises:
        InputError: The file is missing, broken or of another kind, or ``repeat`` is below 1.
    """
    path = _find(Path(str(weights)).expanduser())
    upscaler: _OneStep
    if path.suffix == ".onnx":
        upscaler = Onnx(path, label, device=device)
    elif path.suffix in (".safetensors", ".ckpt"):
        network, card = read_weights(path)
        kind = Luminance if card.input == "luminance" else Rgb
        upscaler = kind(network, card, label or path.stem, device=device)
        upscaler.about |= {"file": path.name, "sha256": sha256_of(path)}
    else:
        raise InputError(f"weights={weights}: wanted a .safetensors, .ckpt or .onnx file")
    return upscaler if repeat == 1 else Repeated(upscaler, repeat, label)


def _find(path: Path) -> Path:
    shipped = PACKAGE / "assets" / path
    return shipped if not path.exists() and shipped.is_file() else path


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
