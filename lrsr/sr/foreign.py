"""How does somebody's PyTorch network enlarge? As spandrel builds it from its weights.

spandrel (an extra, ``pip install 'lrsr[sr]'``) tells some forty architectures by the names and
shapes of their weights: ESRGAN, SwinIR, HAT, SRVGGNetCompact, GFPGAN ... CodeFormer and a few more
come with ``spandrel_extra_arches``, whose licences are narrower. The file is read here, as numbers
only; nothing that a pickle names is ever called.
"""

import importlib
from importlib.util import find_spec
from pathlib import Path
from typing import Any
from warnings import catch_warnings

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file

from lrsr.configuration import as_whole, require
from lrsr.errors import InputError
from lrsr.files import why_no_file
from lrsr.onnx import sha256_of
from lrsr.sr.upscaler import OfNetwork
from lrsr.sr.weights import ENLARGED_BY, LARGEST_SCALE

_EXTRA = "spandrel_extra_arches"
_FACE_PX = 512
"""Sides of an aligned face, as the restorers of faces were trained on."""


class Foreign(OfNetwork):
    """A network of colours that spandrel knows.

    Networks that restore without enlarging see the picture bicubically enlarged by ``scale``. Those
    that restore faces want an aligned one: 512 x 512 px, about four times the eyes' distance.

    Args:
        model: A ``.pth``, ``.pt`` or ``.safetensors`` file.
        label: Its name in tables; the file's when None.
        scale: New size over old; None: the network's own.
        device: Where it runs, "cpu" or "cuda".

    Raises:
        InputError: spandrel is not installed, the file is missing, broken, holds more than numbers
            or no network that can be used, or the network has another scale.
    """

    batch_size = 1  # as spandrel wants it
    _on_luminance = False

    def __init__(
        self,
        model: Path | str,
        label: str | None = None,
        scale: int | None = None,
        *,
        device: str = "cpu",
    ) -> None:
        path = Path(str(model)).expanduser()
        if find_spec("spandrel") is None:
            raise InputError(
                f"{path}: spandrel, which reads it, is missing; pip install 'lrsr[sr]'"
            )
        if why := why_no_file(path):
            raise InputError(f"{path} {why}: give a .pth or .safetensors file")
        self._path, self._network = path, _build(path, _read(path))
        own = self._network.scale
        scale = own if scale is None else as_whole(scale, "scale")
        wanted = f"{own}, which is the network's" if own > 1 else f"1 to {LARGEST_SCALE}"
        require(scale == own if own > 1 else 1 <= scale <= LARGEST_SCALE, "scale", scale, wanted)
        self._enlarged = scale > own
        version = _library().__version__
        super().__init__(
            label or path.stem,
            scale,
            device,
            kind=f"foreign, {self._network.purpose}",
            file=path.name,
            sha256=sha256_of(path),
            architecture=f"{self._network.architecture.name} (spandrel {version})",
            kernel=ENLARGED_BY if self._enlarged else "",
        )
        self._network.to(self._device).eval()
        self.multiple_of = self._network.size_requirements.multiple_of

    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        size = tuple(images.shape[-2:])
        if self._network.purpose == "FaceSR" and size != (_FACE_PX, _FACE_PX):
            raise InputError(
                f"{self._path.name} restores faces of {_FACE_PX}x{_FACE_PX} px, cut out and"
                f" upright; got {size[1]}x{size[0]} px after enlarging by {self.scale}: give such a"
                " face, another scale, or another network"
            )
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(0)  # some draw noise: the same for each picture
            restored: torch.Tensor = self._network(images).clone()  # else of inference mode
        return restored


def _library(name: str = "spandrel") -> Any:
    with catch_warnings(action="ignore"):  # of what torch gives up, which is spandrel's to mend
        return importlib.import_module(name)


def _read(path: Path) -> Any:
    """Read the weights, as numbers only.

    Raises:
        InputError: The file is broken, or holds more than numbers.
    """
    try:
        if path.suffix == ".safetensors":
            return load_file(path)
        return torch.load(path, map_location="cpu", weights_only=True)
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path} cannot be read ({_reason(error)}); get it again") from error
    except Exception as error:  # broken bytes make the unpickler raise nearly anything
        raise InputError(
            f"{path} is broken or holds more than numbers, which could run anything"
            f" ({_reason(error)}); get it as .safetensors"
        ) from error


def _build(path: Path, weights: Any) -> Any:
    """Let spandrel tell the network by its weights.

    Returns:
        The ``spandrel.ImageModelDescriptor``, on the CPU.

    Raises:
        InputError: There is none that spandrel knows, or it does not take and return colours.
    """
    spandrel = _library()
    registry = spandrel.MAIN_REGISTRY.copy()
    if find_spec(_EXTRA) is not None:
        registry.add(*_library(_EXTRA).EXTRA_REGISTRY, ignore_duplicates=True)
    try:
        with torch.random.fork_rng(devices=[]):  # weights are drawn, then replaced
            network = spandrel.ModelLoader(registry=registry).load_from_state_dict(weights)
    except spandrel.UnsupportedModelError as error:
        hint = "" if find_spec(_EXTRA) else f"; pip install {_EXTRA} adds CodeFormer and others"
        raise InputError(f"{path} holds no network that spandrel knows{hint}") from error
    except Exception as error:  # its forty detectors index whatever the file holds
        raise InputError(f"{path} holds no whole network ({_reason(error)})") from error
    takes, returns = network.input_channels, network.output_channels
    if network.purpose == "Inpainting" or (takes, returns) != (3, 3):
        what = f"{network.architecture.name}, {network.purpose}"
        raise InputError(
            f"{path} ({what}) makes {returns} channels of {takes}"
            + (" and a mask" if network.purpose == "Inpainting" else "")
            + "; wanted a network that makes colours of colours"
        )
    return network


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:160] or type(error).__name__
