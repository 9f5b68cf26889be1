"""How is a small srgb picture made larger? One protocol, and everything that keeps it."""

from collections.abc import Callable
from functools import partial
from math import ceil
from pathlib import Path
from typing import ClassVar, Protocol

import numpy as np
import torch
from torch import nn

from lrsr.errors import ImageContractError, InputError
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
from lrsr.sr.tiles import run_in_tiles
from lrsr.sr.weights import ENLARGED_BY, LARGEST_SCALE, Card, read_weights

Run = Callable[[torch.Tensor], torch.Tensor]
Description = dict[str, str | int | float | bool]


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

    def describe(self) -> Description:
        """Return what a report must say of it: label, scale, kind, file, sha256, ..."""


class _OneStep:
    """What every upscaler of one step shares: the contract at both ends, batches, the device."""

    learned = True

    def __init__(
        self, enlarge: Run, label: str, scale: int, about: Description, device: str, batch_size: int
    ) -> None:
        self.label, self.scale = label, scale
        self._enlarge, self._about = enlarge, about
        self._device, self._batch_size = _usable(device), batch_size

    @torch.no_grad()
    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge; see :class:`Upscaler`.

        Raises:
            ImageContractError: The pictures break the contract or lie outside [0, 1], or a network
                enlarges by another factor than its card says.
            NonFiniteError: A network returned a NaN or an infinity.
        """
        check_srgb(srgb, may_need_gradient=True)
        parts = torch.split(srgb.detach(), self._batch_size)
        return torch.cat([self._step(part.to(self._device)) for part in parts]).to(srgb.device)

    def _step(self, srgb: torch.Tensor) -> torch.Tensor:
        larger = check_images(self._enlarge(srgb), name=self.label)
        _check_size(larger, srgb, self.scale, self.label)
        return larger.clamp(0.0, 1.0)

    def describe(self) -> Description:
        """Return label, scale, kind, file, sha256, architecture, lr_made_by and kernel."""
        nothing = dict.fromkeys(("file", "sha256", "architecture", "lr_made_by", "kernel"), "")
        return {"label": self.label, "scale": self.scale, **nothing, **self._about}


class Bicubic(_OneStep):
    """Keys' cubic, a = -0.5; a scale of 1 leaves the picture as the camera made it ("Base").

    Args:
        scale: New size over old, a whole number.
        label: Its name in tables.
        device: Where it runs, "cpu" or "cuda".
        batch_size: Pictures that go through at once.

    Raises:
        InputError: The scale is no whole number above 0, or torch cannot use the device.

    Example:
        >>> Bicubic(4)(torch.full((1, 3, 8, 6), 0.5)).shape
        torch.Size([1, 3, 32, 24])
    """

    learned = False

    def __init__(
        self, scale: int, label: str | None = None, *, device: str = "cpu", batch_size: int = 32
    ) -> None:
        if type(scale) is not int or not 1 <= scale <= LARGEST_SCALE:
            raise InputError(f"scale={scale}: wanted a whole number from 1 to {LARGEST_SCALE}")
        about: Description = {"kind": "bicubic", "kernel": ENLARGED_BY if scale > 1 else ""}
        label = label or ("Base" if scale == 1 else f"Bicubic {scale}")
        super().__init__(self._resize, label, scale, about, device, batch_size)

    def _resize(self, srgb: torch.Tensor) -> torch.Tensor:
        return srgb if self.scale == 1 else resize_bicubic(srgb, self.scale)


class _OfCard(_OneStep):
    """A network of ours and what its card says.

    Args:
        network: As :func:`lrsr.sr.weights.read_weights` gives it.
        card: What it was trained for.
        label: Its name in tables; the architecture and the scale when None.
        file: Where the weights came from, for reports.
        device: Where it runs, "cpu" or "cuda".
        batch_size: Pictures that go through at once; 32 of 128x128 take SRCNN about 200 MB.

    Raises:
        InputError: The network takes other input, or torch cannot use the device.
    """

    _takes: ClassVar[str]

    def __init__(
        self,
        network: nn.Module,
        card: Card,
        label: str | None = None,
        *,
        file: Path | None = None,
        device: str = "cpu",
        batch_size: int = 32,
    ) -> None:
        if card.input != self._takes:
            raise InputError(f"{card.architecture} takes {card.input}, wanted {self._takes}")
        about: Description = {
            "kind": card.input,
            "architecture": card.architecture,
            "lr_made_by": card.lr_made_by,
            "kernel": card.enlarged_by,
        }
        if file is not None:
            about |= {"file": file.name, "sha256": sha256_of(file)}
        enlarge = partial(
            _restore,
            run=network.to(_usable(device)),
            scale=card.scale,
            on_luminance=card.input == "luminance",
            enlarged=bool(card.enlarged_by),
        )
        label = label or f"{card.architecture} {card.scale}"
        super().__init__(enlarge, label, card.scale, about, device, batch_size)


class Luminance(_OfCard):
    """A network that restores the luminance, as SRCNN does; the chroma goes up bicubically."""

    _takes = "luminance"


class Rgb(_OfCard):
    """A network that makes large srgb of small srgb, as EDSR does."""

    _takes = "rgb"


class Onnx(_OneStep):
    """An ONNX network: somebody's with its contract beside it, or one that ``lrsr train`` made.

    Args:
        model: The ``.onnx`` file; see :mod:`lrsr.sr.contract`.
        label: Its name in tables; the file's when None.
        device: "cpu", or "cuda" where onnxruntime has it.
        batch_size: Pictures that go through at once; a graph with a fixed batch overrules it.

    Raises:
        InputError: The file or its contract is missing or broken, or they disagree.
    """

    def __init__(
        self,
        model: Path,
        label: str | None = None,
        *,
        device: str = "cpu",
        batch_size: int = 32,
    ) -> None:
        self._model = model
        self._session = open_session(model, providers_on(device))
        properties = self._session.get_modelmeta().custom_metadata_map
        self.contract = told = read_contract(model, properties)
        check_graph(self._session, model, "an upscaler", told.takes, told.takes)
        self._size = told.height_and_width(self._session.get_inputs()[0].shape, model)
        self._factor = 1 if told.enlarged else told.scale
        about: Description = {
            "kind": "onnx",
            "file": model.name,
            "sha256": told.sha256,
            "architecture": told.source,
            "lr_made_by": told.lr_made_by,
            "kernel": ENLARGED_BY if told.enlarged or told.channels == "Y" else "",
        }
        enlarge = partial(
            _restore,
            run=self._in_tiles,
            scale=told.scale,
            on_luminance=told.channels == "Y",
            enlarged=told.enlarged,
        )
        super().__init__(enlarge, label or model.stem, told.scale, about, "cpu", batch_size)

    def _in_tiles(self, images: torch.Tensor) -> torch.Tensor:
        many = self.contract.multiple_of
        tile_px = [
            size if isinstance(size, int) else many * ceil(have / many)
            for size, have in zip(self._size, images.shape[-2:], strict=True)
        ]
        height, width = tile_px
        return run_in_tiles(images, self._run, tile_px=(height, width), factor=self._factor)

    def _run(self, images: torch.Tensor) -> torch.Tensor:
        """Run the network on (B, C, h, w), as the contract says."""
        told = self.contract
        given = images.flip(1) if told.channels == "BGR" else images
        given = given.permute(0, 2, 3, 1) if told.layout == "NHWC" else given
        values = np.ascontiguousarray((given * told.white).numpy())
        got = run_session(self._session, self._model, values, batch_size=self._batch_size)
        result = torch.from_numpy(got) / told.white
        result = result.permute(0, 3, 1, 2) if told.layout == "NHWC" else result
        _check_size(result, images, self._factor, self.label)
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
        if type(times) is not int or times < 1:
            raise InputError(f"repeat={times}: wanted a whole number above 0")
        self.label = label or f"{upscaler.label}, {times} times"
        self.scale: int = upscaler.scale**times
        self.learned = upscaler.learned
        self._upscaler, self._times = upscaler, times

    def __call__(self, srgb: torch.Tensor) -> torch.Tensor:
        """Enlarge; see :class:`Upscaler`."""
        for _ in range(self._times):
            srgb = self._upscaler(srgb)
        return srgb

    def describe(self) -> Description:
        """Return what the step says of itself, and how often it is taken."""
        own: Description = {"label": self.label, "scale": self.scale, "times": self._times}
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
    upscaler: Upscaler
    if path.suffix == ".onnx":
        upscaler = Onnx(path, label, device=device)
    elif path.suffix in (".safetensors", ".ckpt"):
        network, card = read_weights(path)
        kind = Luminance if card.input == "luminance" else Rgb
        upscaler = kind(network, card, label or path.stem, file=path, device=device)
    else:
        raise InputError(f"weights={weights}: wanted a .safetensors, .ckpt or .onnx file")
    return upscaler if repeat == 1 else Repeated(upscaler, repeat, label)


def _find(path: Path) -> Path:
    shipped = PACKAGE / "assets" / path
    return shipped if not path.exists() and shipped.is_file() else path


def _restore(
    srgb: torch.Tensor, *, run: Run, scale: int, on_luminance: bool, enlarged: bool
) -> torch.Tensor:
    """Enlarge, on luminance or colours, before the network or by it."""
    larger = resize_bicubic(srgb, scale) if on_luminance or enlarged else srgb
    if not on_luminance:
        return run(larger.clamp(0.0, 1.0))
    ycbcr = rgb_to_ycbcr(larger)
    restored = run(ycbcr[:, :1] if enlarged else luminance(srgb))
    return ycbcr_to_rgb(torch.cat([restored, ycbcr[:, 1:]], dim=1))


def _check_size(larger: torch.Tensor, srgb: torch.Tensor, scale: int, label: str) -> None:
    got, given = tuple(larger.shape[-2:]), tuple(srgb.shape[-2:])
    wanted = tuple(scale * size for size in given)
    if got != wanted:
        raise ImageContractError(
            f"{label}: got {got} pixels of {given}, wanted {wanted}; mend its scale in its contract"
        )


def _usable(device: str) -> torch.device:
    try:
        return torch.empty(0, device=device).device
    except (RuntimeError, AssertionError, TypeError) as error:  # torch knows no better
        reason = " ".join(str(error).split())[:120]
        raise InputError(
            f"device={device}: torch cannot use it here ({reason}); give cpu"
        ) from error
