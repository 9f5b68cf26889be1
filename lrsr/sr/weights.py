"""How are a network's weights kept: which numbers, and what must be known to use them rightly?

A network trained for one scale, one enlarging kernel and one way of making the small images loses
to bicubic on any other, so its card travels with the weights: in the header of a ``.safetensors``
file, in a checkpoint, in the properties of an ONNX file.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import save as save_tensors
from torch import nn

from lrsr.errors import InputError
from lrsr.files import why_no_file, write_bytes
from lrsr.sr.networks import NETWORKS
from lrsr.sr.networks.network import Network

#: The one kernel by its words: a network that was trained behind it works behind no other.
ENLARGED_BY = "bicubic, Keys a=-0.5 (MATLAB imresize), edges replicated"

LARGEST_SCALE = 16


@dataclass(frozen=True)
class Card:
    """What weights are of, and what they were trained for.

    Attributes:
        architecture: Key of :data:`lrsr.sr.networks.NETWORKS`.
        arguments: The network's constructor arguments, plain values.
        scale: New size over old, 1 to 16.
        input: "luminance", "rgb" or "burst", as the network says.
        lr_made_by: How the small images came to be, in words.
        enlarged_by: The kernel that enlarges the small image before the network sees it,
            :data:`ENLARGED_BY`; "" where the network enlarges.

    Raises:
        InputError: The network is unknown, or a value is not what it can use.
    """

    architecture: str
    arguments: Mapping[str, Any]
    scale: int
    input: str
    lr_made_by: str
    enlarged_by: str = ""

    def __post_init__(self) -> None:
        known = NETWORKS.get(self.architecture)
        whole = type(self.scale) is int and 1 <= self.scale <= LARGEST_SCALE
        for name, holds, wanted in (
            ("architecture", known is not None, " or ".join(NETWORKS)),
            ("input", known and self.input == known.input, f"what {self.architecture} takes"),
            ("arguments", isinstance(self.arguments, Mapping), "names and values"),
            ("scale", whole, f"1 to {LARGEST_SCALE}"),
            ("enlarged_by", self.enlarged_by in ("", ENLARGED_BY), f"{ENLARGED_BY!r} or nothing"),
        ):
            if not holds:
                raise InputError(f"{name}={getattr(self, name)}: wanted {wanted}")

    def as_text(self) -> dict[str, str]:
        """Return the fields as the strings that safetensors, checkpoints and ONNX files take."""
        text = {name: str(value) for name, value in asdict(self).items()}
        return text | {"arguments": json.dumps(dict(self.arguments), sort_keys=True)}

    @classmethod
    def from_text(cls, text: Mapping[str, str]) -> "Card":
        """Read what :meth:`as_text` wrote; what else stands there is left alone.

        Raises:
            InputError: A field is missing or cannot be used.
        """
        try:
            known: dict[str, Any] = {field.name: text[field.name] for field in fields(cls)}
            known["scale"], known["arguments"] = int(known["scale"]), json.loads(known["arguments"])
        except KeyError as error:
            raise InputError(f"its card has no {error}") from error
        except (ValueError, TypeError) as error:
            raise InputError(f"its card cannot be read: {error}") from error
        return cls(**known)


def blank_network(card: Card) -> Network:
    """Make the network of a card as it is in use, without memory or random numbers for weights.

    Raises:
        InputError: An argument is none that it can use.
        TypeError: An argument is missing, or unknown to it.
    """
    kind = NETWORKS[card.architecture]
    with torch.device("meta"):
        return kind(**{**card.arguments, **kind.in_use})


def has_card(path: Path) -> bool:
    """Tell whether a ``.safetensors`` file is of :func:`write_weights`, or somebody else's.

    Raises:
        InputError: It is missing, or no such file.
    """
    return "architecture" in _of_safetensors(path)[1]


def write_weights(path: Path, network: nn.Module, card: Card) -> None:
    """Write the network's weights (float32) and their card as one safetensors file.

    Equal weights and cards make equal bytes.

    Raises:
        InputError: The file cannot be written.
    """
    tensors = {k: v.detach().float().cpu().contiguous() for k, v in network.state_dict().items()}
    write_bytes(path, _in_order(save_tensors(tensors, metadata=card.as_text())))


def _in_order(content: bytes) -> bytes:
    """Sort the card in a safetensors file's header, where the library has it in random order."""
    end = 8 + int.from_bytes(content[:8], "little")
    header = json.loads(content[8:end])
    header["__metadata__"] = dict(sorted(header["__metadata__"].items()))
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)  # what follows is aligned
    return len(text).to_bytes(8, "little") + text + content[end:]


def read_weights(path: Path) -> tuple[Network, Card]:
    """Read a ``.safetensors`` file of :func:`write_weights` or a ``.ckpt`` of a training run.

    Returns:
        The network as it is in use (whole pictures, float32, evaluation mode, on the CPU, no
        gradient), and its card.

    Raises:
        InputError: The file is missing, broken, of another network, or holds a NaN.
    """
    if why := why_no_file(path):
        raise InputError(f"{path} {why}: give a .safetensors or .ckpt file of lrsr train")
    tensors, text = _of_checkpoint(path) if path.suffix == ".ckpt" else _of_safetensors(path)
    try:
        card = Card.from_text(text)
        network = _build(card, tensors)
    except (InputError, AttributeError, RuntimeError, TypeError, ValueError) as error:
        reason = " ".join(str(error).split())[:300]
        raise InputError(f"{path} is not of lrsr train: {reason}; train again") from error
    return network, card


def read_checkpoint(path: Path) -> dict[str, Any]:
    """Read a checkpoint of any training onto the CPU.

    Raises:
        InputError: The file is missing, cut short, or holds more than numbers and strings.
    """
    try:
        checkpoint = torch.load(path, map_location="cpu", weights_only=True)
    except Exception as error:  # broken bytes make the unpickler raise nearly anything
        reason = " ".join(str(error).split())[:200]
        if "weights_only" in reason:  # torch's advice is to trust the file
            reason = "it is broken, or holds more than numbers and words"
        raise InputError(f"{path} is no checkpoint of lrsr train: {reason}") from error
    if not isinstance(checkpoint, dict) or not isinstance(checkpoint.get("state_dict"), dict):
        raise InputError(f"{path} is no checkpoint of lrsr train: it holds no state_dict")
    return checkpoint


def _build(card: Card, tensors: Mapping[str, torch.Tensor]) -> Network:
    """Make the network and try it on a small picture.

    Raises:
        InputError: A weight is no finite real number, or the picture comes back in another size.
    """
    network = blank_network(card)
    for name, tensor in tensors.items():
        if tensor.is_complex() or tensor.dtype == torch.bool:
            raise InputError(f"{name} holds {tensor.dtype}, wanted real numbers")
    plain = torch.contiguous_format  # training may keep them otherwise, which rounds otherwise
    state = {name: t.float().clone(memory_format=plain) for name, t in tensors.items()}
    network.load_state_dict(state, assign=True)
    network.eval().requires_grad_(False)
    for name, tensor in network.state_dict().items():
        if not bool(torch.isfinite(tensor).all()):
            raise InputError(f"{name} holds a NaN or an infinity")
    channels = 1 if card.input == "luminance" else 3
    factor = 1 if card.enlarged_by else card.scale
    got = tuple(network(torch.zeros(network.takes(6, 7))).shape)
    if got != (1, channels, 6 * factor, 7 * factor):
        raise InputError(f"scale={card.scale}, but it makes {got[-2]}x{got[-1]} pixels of 6x7")
    return network


def _of_safetensors(path: Path) -> tuple[Mapping[str, torch.Tensor], Mapping[str, str]]:
    try:
        with safe_open(path, framework="pt") as file:
            names = file.keys()
            return {name: file.get_tensor(name) for name in names}, file.metadata() or {}
    except (SafetensorError, OSError) as error:
        raise InputError(f"{path} is no safetensors file ({error}); fetch it again") from error


def _of_checkpoint(path: Path) -> tuple[Mapping[str, torch.Tensor], Mapping[str, str]]:
    checkpoint = read_checkpoint(path)
    card = checkpoint.get("card")
    if not isinstance(card, dict):
        raise InputError(f"{path} is no checkpoint of lrsr train sr=...: it holds no card")
    prefix, state = "network.", {str(k): v for k, v in checkpoint["state_dict"].items()}
    return {k.removeprefix(prefix): v for k, v in state.items() if k.startswith(prefix)}, card
