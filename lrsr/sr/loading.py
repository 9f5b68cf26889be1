"""Which upscaler is in this file? Told by what the file is, never by its numbers."""

from pathlib import Path

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.paths import PACKAGE
from lrsr.sr.foreign import Foreign
from lrsr.sr.onnx_network import Onnx
from lrsr.sr.upscaler import Luminance, OneStep, Repeated, Rgb, Upscaler
from lrsr.sr.weights import has_card, read_weights


def load_upscaler(
    weights: Path, label: str | None = None, repeat: int = 1, *, device: str = "cpu"
) -> Upscaler:
    """Load a network by its file, whatever it is.

    Args:
        weights: A ``.safetensors``, ``.ckpt`` or ``.onnx`` file of ``lrsr train``, or somebody's
            ``.onnx``, ``.pth`` or ``.safetensors``. A name that does not lead to a file from here
            is looked for among those that ship, e.g. "weights/srcnn2x.safetensors".
        label: Its name in tables; the file's when None.
        repeat: How often it is taken.
        device: Where it runs, "cpu" or "cuda".

    Raises:
        InputError: The file is missing, broken or of another kind, or ``repeat`` is below 1.
    """
    path = find_weights(weights)
    upscaler: OneStep
    if path.suffix == ".onnx":
        upscaler = Onnx(path, label, device=device)
    elif path.suffix == ".pth" or (
        path.suffix == ".safetensors" and path.is_file() and not has_card(path)
    ):
        upscaler = Foreign(path, label, device=device)
    elif path.suffix in (".safetensors", ".ckpt"):
        network, card = read_weights(path)
        kind = Luminance if card.input == "luminance" else Rgb
        upscaler = kind(network, card, label or path.stem, device=device)
        upscaler.about |= {"file": path.name, "sha256": sha256_of(path)}
    else:
        raise InputError(f"weights={weights}: wanted a .safetensors, .ckpt, .onnx or .pth file")
    return upscaler if repeat == 1 else Repeated(upscaler, repeat, label)


def find_weights(weights: Path) -> Path:
    """Return the file that is named, from here or else among those that ship."""
    path = Path(str(weights)).expanduser()
    shipped = PACKAGE / "assets" / path
    return shipped if not path.exists() and shipped.is_file() else path
