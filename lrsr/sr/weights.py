"""How are SRCNN's weights kept: which numbers, and what must be known to use them rightly?

A network trained for one scale, one enlarging kernel and one way of making the small images loses
to bicubic on any other, so these travel in the file's own header.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as save_tensors

from lrsr.errors import InputError
from lrsr.files import write_bytes
from lrsr.sr.bicubic import ENLARGED_BY
from lrsr.sr.srcnn import SRCNN

ARCHITECTURE = "SRCNN 9-1-5, 64x1x9x9 32x64x1x1 1x32x5x5"


@dataclass(frozen=True)
class Recipe:
    """What the weights were trained for.

    Attributes:
        scale: New size over old: 2 or 4 in the paper.
        lr_made_by: How the small images came to be, in words.
        enlarged_by: The kernel that enlarges the small image before the network sees it.
        architecture: Filter counts and sizes.
    """

    scale: int
    lr_made_by: str
    enlarged_by: str = ENLARGED_BY
    architecture: str = ARCHITECTURE

    def as_text(self) -> dict[str, str]:
        """Return the fields as the strings that safetensors and ONNX headers take."""
        return {name: str(value) for name, value in asdict(self).items()}


def write_weights(path: Path, network: SRCNN, recipe: Recipe) -> None:
    """Write the network's weights (float32, 32 kB) and their recipe as one safetensors file."""
    tensors = {k: v.detach().float().cpu().contiguous() for k, v in network.state_dict().items()}
    write_bytes(path, save_tensors(tensors, metadata=recipe.as_text()))


def read_weights(path: Path) -> tuple[SRCNN, Recipe]:
    """Read a ``.safetensors`` file of :func:`write_weights` or a ``.ckpt`` of a training run.

    Returns:
        The network (replicate padding, float32, evaluation mode) and its recipe.

    Raises:
        InputError: The file is missing, broken, of another network, or holds a NaN.
    """
    if not path.is_file():
        raise InputError(f"no weights at {path}: give a .safetensors or .ckpt file of lrsr train")
    tensors, header = _read_checkpoint(path) if path.suffix == ".ckpt" else _read_tensors(path)
    try:
        recipe = _as_recipe(header)
        network = SRCNN(padding="replicate")
        network.load_state_dict(tensors)
    except (KeyError, ValueError, RuntimeError) as error:
        reason = " ".join(str(error).split())
        raise InputError(f"{path} is not SRCNN 9-1-5 from lrsr train: {reason}") from error
    for name, tensor in network.state_dict().items():
        if not bool(torch.isfinite(tensor).all()):
            raise InputError(f"{path}: {name} holds a NaN or an infinity; train again")
    return network.eval().requires_grad_(False), recipe


def _as_recipe(header: Mapping[str, str]) -> Recipe:
    known = {field.name: header[field.name] for field in fields(Recipe)}
    if known["architecture"] != ARCHITECTURE:
        raise ValueError(f"it holds {known['architecture']!r}")
    if known["enlarged_by"] != ENLARGED_BY:
        raise ValueError(f"it wants input enlarged by {known['enlarged_by']!r}")
    return Recipe(scale=int(known.pop("scale")), **known)


def _read_tensors(path: Path) -> tuple[Mapping[str, torch.Tensor], Mapping[str, str]]:
    try:
        with safe_open(path, framework="pt") as file:
            names = file.keys()
            return {name: file.get_tensor(name) for name in names}, file.metadata() or {}
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path} is no safetensors file ({error}); fetch it again") from error


def _read_checkpoint(path: Path) -> tuple[Mapping[str, torch.Tensor], Mapping[str, str]]:
    """Take the network and the recipe that ``SRCNNModule`` puts there.

    Raises:
        InputError: The file is broken or of another training.
    """
    from lrsr.sr.checkpoints import read_checkpoint  # Lightning: only for a .ckpt

    checkpoint = read_checkpoint(path)
    if "recipe" not in checkpoint:
        raise InputError(f"{path} is no checkpoint of lrsr train sr=...: it holds no recipe")
    state: Mapping[str, torch.Tensor] = checkpoint["state_dict"]
    return {name.removeprefix("network."): t for name, t in state.items()}, checkpoint["recipe"]
