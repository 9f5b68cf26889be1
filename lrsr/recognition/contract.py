"""What does an embedding model expect and return? Declared in a TOML file beside it, never sniffed.

``face.onnx`` needs ``face.toml``::

    sha256 = "…"                # of face.onnx
    licence = "MIT"
    source = "lrsr train recognition=arcface, seed 7"

    [input]
    layout = "NCHW"             # or "NHWC"
    channels = "RGB"            # or "BGR"
    height_px = 112
    width_px = 112
    mean = 127.5                # the model sees (255 srgb - mean) / scale
    scale = 127.5

    [output]
    dimension = 128

    [alignment]
    template = "arcface5"       # the only one so far
    antialias = true            # average when the face is made smaller; insightface does not

The numbers that the graph states too (sizes, dimension) must agree with it; what it cannot state
(channel order, mean, scale, antialias) is taken from here and from nowhere else.
"""

import hashlib
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.recognition.alignment import CROP_PX

_TABLES: dict[str, dict[str, type]] = {
    "": {"sha256": str, "licence": str, "source": str},
    "input": {
        "layout": str,
        "channels": str,
        "height_px": int,
        "width_px": int,
        "mean": float,
        "scale": float,
    },
    "output": {"dimension": int},
    "alignment": {"template": str, "antialias": bool},
}
_CHOICES: dict[str, tuple[object, ...]] = {
    "input.layout": ("NCHW", "NHWC"),
    "input.channels": ("RGB", "BGR"),
    "input.height_px": (CROP_PX,),
    "input.width_px": (CROP_PX,),
    "alignment.template": ("arcface5",),
}


@dataclass(frozen=True)
class Contract:
    """One model's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    layout: str
    channels: str
    height_px: int
    width_px: int
    mean: float
    scale: float
    dimension: int
    template: str
    antialias: bool

    @property
    def input_shape(self) -> tuple[int, int, int]:
        """Shape of one image as the model takes it, without the batch."""
        if self.layout == "NCHW":
            return (3, self.height_px, self.width_px)
        return (self.height_px, self.width_px, 3)


def contract_path(model: Path) -> Path:
    """Return where the contract of ``model`` lies: the same name, ending in ``.toml``."""
    return model.with_suffix(".toml")


def read_contract(model: Path) -> Contract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Args:
        model: Path of the ``.onnx`` file.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or
            out of range; or the model is not the one that the contract was written for.
    """
    path = contract_path(model)
    try:
        digest = sha256_of(model)
        with path.open("rb") as file:
            document = tomllib.load(file)
    except FileNotFoundError as error:
        raise InputError(
            f"{error.filename} is missing: a model needs NAME.onnx and NAME.toml"
        ) from error
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(
            f"{path}: cannot be read as a contract ({error}); mend or replace it"
        ) from error
    contract = Contract(**_fields(document, path))
    if digest != contract.sha256:
        raise InputError(
            f"{model}: sha256 is {digest[:12]}…, its contract says {contract.sha256[:12]}…; "
            "the file is damaged or is another model: get it again or mend the contract"
        )
    return contract


def write_contract(contract: Contract) -> str:
    """Return the contract as TOML; :func:`read_contract` reads it back unchanged."""
    lines = []
    for table, fields in _TABLES.items():
        if table:
            lines += ["", f"[{table}]"]
        lines += [f"{name} = {_toml(getattr(contract, name))}" for name in fields]
    return "\n".join(lines) + "\n"


def sha256_of(path: Path) -> str:
    """Return the sha256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _toml(value: object) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ")
        return f'"{escaped}"'
    return repr(value)


def _fields(document: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """Flatten the document's tables and check names, types and ranges.

    Raises:
        InputError: A field is missing, unknown or out of range.
    """
    found: dict[str, Any] = {}
    for table, wanted in _TABLES.items():
        section = document.get(table, {}) if table else document
        if not isinstance(section, Mapping):
            raise InputError(f"{path}: {table} = {section!r}; make it a table, [{table}]")
        allowed = set(wanted) if table else set(wanted) | {name for name in _TABLES if name}
        if unknown := sorted(set(section) - allowed):
            where = f" in [{table}]" if table else ""
            raise InputError(
                f"{path}: unknown field {unknown[0]!r}{where}; wanted {', '.join(wanted)}"
            )
        for name, kind in wanted.items():
            found[name] = _checked(section.get(name), f"{table}.{name}".lstrip("."), kind, path)
    if found["scale"] <= 0 or found["dimension"] <= 0:
        raise InputError(f"{path}: input.scale and output.dimension must be above 0")
    return found


def _checked(value: object, name: str, kind: type, path: Path) -> object:
    if value is None:
        raise InputError(f"{path}: {name} is missing; declare it")
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind:
        raise InputError(f"{path}: {name} = {value!r}; wanted {kind.__name__}")
    choices = _CHOICES.get(name)
    if choices is not None and value not in choices:
        wanted = " or ".join(str(choice) for choice in choices)
        raise InputError(f"{path}: {name} = {value!r}; wanted {wanted}")
    return value
