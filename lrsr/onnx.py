"""How does somebody's network come in? As an ONNX file, and a ``.toml`` beside it that declares it.

What the graph states (sizes) must agree with the contract; what it cannot state (channel order,
range, ...) is taken from the contract and from nowhere else. This is the home of onnxruntime.
"""

import hashlib
import importlib
import logging
import math
import tomllib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import InputError

CPU = ("CPUExecutionProvider",)

#: Tables of a contract; a field is given by its type, or by the value it has when left out.
Fields = Mapping[str, Mapping[str, Any]]

log = logging.getLogger(__name__)


def providers_on(device: str) -> tuple[str, ...]:
    """Return who computes: CUDA where it is asked for ("cuda") and there, else the CPU."""
    if not device.startswith("cuda"):
        return CPU
    if "CUDAExecutionProvider" in importlib.import_module("onnxruntime").get_available_providers():
        return ("CUDAExecutionProvider", *CPU)
    log.warning("device=%s: this onnxruntime has no CUDA, so its networks run on the CPU", device)
    return CPU


def open_session(model: Path, providers: Sequence[str] = CPU) -> Any:
    """Open an ONNX file for running, on as many threads as torch has.

    Args:
        model: The file; its external data, if any, lies beside it.
        providers: Who computes, by onnxruntime's names, in order of preference.

    Returns:
        The ``onnxruntime.InferenceSession``.

    Raises:
        InputError: The file or its external data is missing, or it is no ONNX model.
    """
    if not model.is_file():
        raise InputError(f"{model} is missing: give an ONNX file")
    onnxruntime = importlib.import_module("onnxruntime")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = torch.get_num_threads()
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(
            str(model), sess_options=options, providers=list(providers)
        )
    except Exception as error:  # onnxruntime's own classes share no public base
        raise InputError(
            f"{model}: not a usable ONNX model ({_reason(error)}); get it again"
        ) from error


def run_session(
    session: Any, model: Path, inputs: NDArray[np.float32], *, batch_size: int
) -> NDArray[np.float32]:
    """Run a model of one input and one output over a batch, part by part.

    Args:
        session: Of :func:`open_session`.
        model: Its file, for messages.
        inputs: ``(B, ...)``, B > 0.
        batch_size: Of a part; a graph with a fixed batch overrules it, and is filled up.

    Returns:
        ``(B, ...)`` float32.

    Raises:
        InputError: The model cannot take such inputs.
    """
    argument = session.get_inputs()[0]
    fixed, count = isinstance(argument.shape[0], int), len(inputs)
    size = argument.shape[0] if fixed else batch_size
    if fixed and (spare := -count % size):
        inputs = np.concatenate([inputs, np.repeat(inputs[-1:], spare, axis=0)])
    try:
        parts = [
            session.run(None, {argument.name: inputs[start : start + size]})[0]
            for start in range(0, len(inputs), size)
        ]
    except Exception as error:  # as above
        raise InputError(
            f"{model}: cannot take an input of {inputs.shape[1:]} ({_reason(error)}); mend its"
            " contract or give another model"
        ) from error
    return np.concatenate(parts)[:count].astype(np.float32, copy=False)


def check_graph(
    session: Any,
    model: Path,
    what: str,
    takes: tuple[tuple[int | None, ...], str],
    returns: tuple[tuple[int | None, ...], str],
) -> None:
    """Hold a graph against its contract.

    Args:
        session: Of :func:`open_session`.
        model: Its file, for messages.
        what: What it should be, for messages.
        takes: Shape of the input, None where any size will do, and the contract's words for it.
        returns: The same of the output.

    Raises:
        InputError: They disagree, or there is not one input and one output of floats.
    """
    inputs, outputs = session.get_inputs(), session.get_outputs()
    if len(inputs) != 1 or len(outputs) != 1:
        raise InputError(
            f"{model}: has {len(inputs)} inputs and {len(outputs)} outputs; {what} has one of each"
        )
    for verb, value, (shape, words) in (
        ("takes", inputs[0], takes),
        ("returns", outputs[0], returns),
    ):
        if value.type != "tensor(float)" or not _agree(value.shape, shape):
            raise InputError(
                f"{model}: {verb} {value.type} {value.shape}, its contract says {words};"
                " mend the contract or give the model it was written for"
            )


def contract_path(model: Path) -> Path:
    """Return where the contract of ``model`` lies: the same name, ending in ``.toml``."""
    return model.with_suffix(".toml")


def sha256_of(path: Path) -> str:
    """Return the sha256 of a file's bytes, in hex."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_fields(
    model: Path, wanted: Fields, choices: Mapping[str, Sequence[object]]
) -> dict[str, Any]:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Args:
        model: Path of the ``.onnx`` file.
        wanted: What a contract declares.
        choices: What may stand in a field, by "table.field".

    Returns:
        Every field by its name, the tables left out.

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
    found = _flatten(document, path, wanted, choices)
    if digest != found["sha256"]:
        raise InputError(
            f"{model}: sha256 is {digest[:12]}…, its contract says {found['sha256'][:12]}…; "
            "the file is damaged or is another model: get it again or mend the contract"
        )
    return found


def _flatten(
    document: Mapping[str, Any], path: Path, tables: Fields, choices: Mapping[str, Sequence[object]]
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for table, wanted in tables.items():
        section = document.get(table, {}) if table else document
        if not isinstance(section, Mapping):
            raise InputError(f"{path}: {table} = {section!r}; make it a table, [{table}]")
        allowed = set(wanted) if table else set(wanted) | {name for name in tables if name}
        if unknown := sorted(set(section) - allowed):
            where = f" in [{table}]" if table else ""
            raise InputError(
                f"{path}: unknown field {unknown[0]!r}{where}; wanted {', '.join(wanted)}"
            )
        for field, kind in wanted.items():
            name = f"{table}.{field}".lstrip(".")
            found[field] = _checked(section.get(field), name, kind, path)
            if name in choices and found[field] not in choices[name]:
                options = " or ".join(str(choice) for choice in choices[name])
                raise InputError(f"{path}: {name} = {found[field]!r}; wanted {options}")
    return found


def _checked(value: Any, name: str, wanted: Any, path: Path) -> object:
    kind = wanted if isinstance(wanted, type) else type(wanted)
    if value is None:
        if isinstance(wanted, type):
            raise InputError(f"{path}: {name} is missing; declare it")
        return wanted
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
        raise InputError(f"{path}: {name} = {value!r}; wanted {kind.__name__}")
    return value


def _agree(got: Sequence[object], wanted: Sequence[int | None]) -> bool:
    """Tell whether a graph's shape (numbers, or names where it is free) can be the wanted one."""
    return len(got) == len(wanted) and all(
        w is None or not isinstance(g, int) or g == w for g, w in zip(got, wanted, strict=True)
    )


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:160]
