"""How does somebody's network come in? As an ONNX file, and a ``.toml`` beside it that declares it.

What the graph states (sizes) must agree with the contract; what it cannot state (channel order,
range, ...) is taken from the contract and from nowhere else. This is the home of onnxruntime.
"""

import hashlib
import importlib
import json
import logging
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import MISSING, fields
from pathlib import Path
from typing import Any, TypeVar, get_args, get_origin

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.files import check_file, read_bytes, why_no_file

_CPU = ("CPUExecutionProvider",)
_GPUS = ("CUDAExecutionProvider", "ROCMExecutionProvider", "CoreMLExecutionProvider")

#: What each channel is given: one number for all, or one for each.
PerChannel = float | tuple[float, float, float]

DEVICES = ("auto", "cpu", "cuda")
"""Where networks run; see :func:`providers_on`."""

#: None: any size.
_Shape = tuple[int | None, ...]

#: The names of a contract's fields, by table; "" is the top of the file.
_Tables = Mapping[str, Sequence[str]]

_Declared = TypeVar("_Declared")

logger = logging.getLogger(__name__)


def providers_on(device: str) -> tuple[str, ...]:
    """Return who computes.

    Args:
        device: "cpu"; "cuda", where onnxruntime has it, else the CPU with a warning; or "auto", any
            GPU that onnxruntime has, else the CPU.
    """
    if device == "cpu":
        return _CPU
    there = importlib.import_module("onnxruntime").get_available_providers()
    wanted = _GPUS if device == "auto" else _GPUS[:1]
    found = tuple(name for name in wanted if name in there)
    if found or device == "auto":
        return (*found, *_CPU)
    logger.warning(
        "device=%s: this onnxruntime has no CUDA, so its networks run on the CPU", device
    )
    return _CPU


def open_session(model: Path, providers: Sequence[str] = _CPU) -> Any:
    """Open an ONNX file for running, on as many threads as torch has.

    Args:
        model: The file; its external data, if any, lies beside it.
        providers: Who computes, by onnxruntime's names, in order of preference.

    Returns:
        The ``onnxruntime.InferenceSession``.

    Raises:
        InputError: The file or its external data is missing, or it is no ONNX model.
    """
    if why := why_no_file(model):
        raise InputError(f"{model} {why}: give an ONNX file")
    onnxruntime = importlib.import_module("onnxruntime")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = torch.get_num_threads()
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(str(model), options, providers=list(providers))
    except Exception as error:  # onnxruntime's own classes share no public base
        why = _reason(error)
        raise InputError(f"{model}: not a usable ONNX model ({why}); get it again") from error


def run_session(
    session: Any, model: Path, inputs: NDArray[np.float32], *, batch_size: int, output: str = ""
) -> NDArray[np.float32]:
    """Run a model of one input over a batch, part by part.

    Args:
        session: Of :func:`open_session`.
        model: Its file, for messages.
        inputs: ``(B, ...)``, B > 0.
        batch_size: Of a part; a graph with a fixed batch overrules it, and is filled up.
        output: Which one, where the graph has several; "": the first.

    Returns:
        ``(B, ...)`` float32, finite.

    Raises:
        InputError: The model cannot take such inputs, or returns a NaN or an infinity.
    """
    names = [output] if output else None
    parts = [outputs[0] for _, outputs in _run_parts(session, model, inputs, batch_size, names)]
    values = np.concatenate(parts)[: len(inputs)].astype(np.float32, copy=False)
    if not np.isfinite(values).all():
        which = int(np.argwhere(~np.isfinite(values))[0, 0])
        raise InputError(
            f"{model}: returned a NaN or an infinity for input {which}: it cannot be used; give"
            " another"
        )
    return values


def run_lists(
    session: Any,
    model: Path,
    inputs: NDArray[np.float32],
    names: Sequence[str],
    *,
    batch_size: int,
) -> list[NDArray[np.float32]]:
    """Run a model that returns lists of numbers for each image, such as a detector.

    Args:
        session: Of :func:`open_session`.
        model: Its file, for messages.
        inputs: ``(B, ...)``, B > 0.
        names: Of the outputs that are wanted.
        batch_size: As for :func:`run_session`.

    Returns:
        ``(B, N, C)`` float32 for each name: C of the last axis, N of all between it and the batch,
        whether or not a graph for one image at a time has an axis for the batch.

    Raises:
        InputError: The model cannot take such inputs, or what it returns is no such list.
    """
    parts = _run_parts(session, model, inputs, batch_size, list(names))
    lists = []
    for number, name in enumerate(names):
        rows = []
        for images, outputs in parts:
            array = np.asarray(outputs[number], dtype=np.float32)
            if array.ndim < 2 or array.size % (images * array.shape[-1]):
                raise InputError(
                    f"{model}: output {name} has shape {array.shape} for {images} images;"
                    " wanted a list for each"
                )
            rows.append(array.reshape(images, -1, array.shape[-1]))
        lists.append(np.concatenate(rows)[: len(inputs)])
    return lists


def _run_parts(
    session: Any,
    model: Path,
    inputs: NDArray[np.float32],
    batch_size: int,
    names: list[str] | None,
) -> list[tuple[int, list[Any]]]:
    """Return images and outputs of each part of a batch; a fixed batch's last is filled up.

    Raises:
        InputError: The model cannot take such inputs.
    """
    argument = session.get_inputs()[0]
    fixed, count = isinstance(argument.shape[0], int), len(inputs)
    size = argument.shape[0] if fixed else batch_size
    if fixed and (spare := -count % size):
        inputs = np.concatenate([inputs, np.repeat(inputs[-1:], spare, axis=0)])
    parts = [inputs[start : start + size] for start in range(0, len(inputs), size)]
    try:
        return [(len(part), session.run(names, {argument.name: part})) for part in parts]
    except Exception as error:  # as above
        got, why = inputs.shape[1:], _reason(error)
        raise InputError(f"{model}: cannot take an input of {got} ({why}); mend it") from error


def check_graph(
    session: Any,
    model: Path,
    what: str,
    takes: _Shape,
    returns: _Shape,
    words: tuple[str, str],
    output: str = "",
) -> None:
    """Hold a graph against its contract.

    Args:
        session: Of :func:`open_session`.
        model: Its file, for messages.
        what: What it should be, for messages.
        takes: Shape of the input, None where any size will do.
        returns: The same of the output.
        words: The contract's, for both.
        output: Which one is meant, where there are several; "": the only one.

    Raises:
        InputError: They disagree, or there is not one input and one output of floats.
    """
    inputs, outputs = session.get_inputs(), session.get_outputs()
    if output:
        names = [end.name for end in outputs]
        if output not in names:
            raise InputError(f"{model}: has no output {output!r}; it has {', '.join(names)}")
        outputs = [outputs[names.index(output)]]
    if len(inputs) != 1 or len(outputs) != 1:
        raise InputError(
            f"{model}: has {len(inputs)} inputs and {len(outputs)} outputs; {what} has one of each"
        )
    ends = zip(("takes", "returns"), (*inputs, *outputs), (takes, returns), words, strict=True)
    for verb, end, shape, said in ends:
        if end.type != "tensor(float)" or not _agree(end.shape, shape):
            raise InputError(
                f"{model}: {verb} {end.type} {end.shape}, its contract says {said};"
                " mend the contract or give the model it was written for"
            )


def declared_text(document: Mapping[str, Any]) -> str:
    """Return a contract as TOML: plain values first, then its tables of plain values and lists.

    Example:
        >>> print(declared_text({"input": {"mean": [104, 117, 123]}, "licence": "MIT"}), end="")
        licence = "MIT"
        <BLANKLINE>
        [input]
        mean = [104, 117, 123]
    """
    tables = {name: part for name, part in document.items() if isinstance(part, Mapping)}
    lines = []
    for table, part in {"": document, **tables}.items():
        lines += ["", f"[{table}]"] if table else []
        plain = {name: value for name, value in part.items() if not isinstance(value, Mapping)}
        # JSON is TOML, for such values
        lines += [f"{name} = {json.dumps(v, ensure_ascii=False)}" for name, v in plain.items()]
    return "\n".join(lines) + "\n"


def contract_path(model: Path) -> Path:
    """Return where the contract of ``model`` lies: the same name, ending in ``.toml``."""
    return model.with_suffix(".toml")


def sha256_of(path: Path) -> str:
    """Return the sha256 of a file's bytes, in hex."""
    with check_file(path).open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def read_declared(
    kind: type[_Declared], model: Path, tables: _Tables, choices: Mapping[str, Sequence[object]]
) -> _Declared:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Args:
        kind: A dataclass of plain types and tuples of them, ``tuple[int, ...]``. A field with a
            default may be left out of the file.
        model: Path of the ``.onnx`` file.
        tables: Where each field stands.
        choices: What may stand in a field, by "table.field".

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or
            out of range; or the model is not the one that the contract was written for.
    """
    path = contract_path(model)
    for one in (model, path):
        if why := why_no_file(one):
            raise InputError(f"{one} {why}: a model needs NAME.onnx and NAME.toml")
    try:
        digest = sha256_of(model)
        document = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except (OSError, tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: cannot be read as a contract ({error}); mend it") from error
    declared = check_declared(kind, document, tables, choices, path)
    if digest != document["sha256"]:
        raise InputError(
            f"{model}: sha256 is {digest[:12]}…, its contract says {document['sha256'][:12]}…; "
            "the file is damaged or is another model: get it again or mend the contract"
        )
    return declared


def check_declared(
    kind: type[_Declared],
    document: Mapping[str, Any],
    tables: _Tables,
    choices: Mapping[str, Sequence[object]],
    where: Path | str,
) -> _Declared:
    """Make a contract of what is declared; see :func:`read_declared`.

    Args:
        kind: Of the contract.
        document: Fields and tables of fields.
        tables: Where each field stands.
        choices: What may stand in a field, by "table.field".
        where: What messages call the document.

    Raises:
        InputError: A field is missing, unknown or out of range.
    """
    known, found = {field.name: field for field in fields(kind)}, {}  # type: ignore[arg-type]
    for name, written in _flatten(document, tables, where):
        field = known[name.rpartition(".")[2]]
        value = found[field.name] = _checked(written, field, name, where)
        if value not in choices.get(name, (value,)) and value is not field.default:
            raise InputError(f"{where}: {name} = {value!r}; wanted {_either(choices[name])}")
    return kind(**found)


def _either(choices: Sequence[object]) -> str:
    """Return choices in words."""
    if isinstance(choices, range):
        return f"{choices[0]} to {choices[-1]}"
    return " or ".join(str(choice) for choice in choices)


def _flatten(
    document: Mapping[str, Any], tables: _Tables, path: Path | str
) -> Iterator[tuple[str, Any]]:
    """Yield each field's full name and value, None where it is left out.

    Raises:
        InputError: A field is in no table, or a table is none.
    """
    for table, names in tables.items():
        section = document.get(table, {}) if table else document
        if not isinstance(section, Mapping):
            raise InputError(f"{path}: {table} = {section!r}; make it a table, [{table}]")
        if unknown := sorted(set(section) - set(names) - (set() if table else set(tables))):
            where = f"{unknown[0]!r} in [{table}]" if table else repr(unknown[0])
            raise InputError(f"{path}: unknown field {where}; wanted {', '.join(names)}")
        yield from ((f"{table}.{name}".lstrip("."), section.get(name)) for name in names)


def _checked(value: Any, field: Any, name: str, path: Path | str) -> Any:
    if value is None and field.default is MISSING:
        raise InputError(f"{path}: {name} is missing; declare it")
    if value is None:
        return field.default
    try:
        return _typed(value, field.type)
    except TypeError as error:
        raise InputError(f"{path}: {name} = {value!r}; wanted {error}") from error


def _typed(value: Any, kind: Any) -> Any:
    """Return a value of TOML as the type of a field: a plain one, or a tuple of any number of them.

    Raises:
        TypeError: It is another; the message says which is wanted.
    """
    if kind == PerChannel:
        with suppress(TypeError):
            if not isinstance(value, list):
                return _typed(value, float)
            if len(value) == 3:
                return tuple(_typed(each, float) for each in value)
        raise TypeError("a number, or three")
    if type(None) in get_args(kind):  # may be left out
        kind = get_args(kind)[0]
    if get_origin(kind) is tuple:
        inner = get_args(kind)[0]
        if not isinstance(value, list):
            raise TypeError("a list")
        return tuple(_typed(each, inner) for each in value)
    if kind is float and type(value) is int:
        value = float(value)
    if type(value) is not kind or (isinstance(value, float) and not math.isfinite(value)):
        raise TypeError(kind.__name__)
    return value


def _agree(got: Sequence[object], wanted: _Shape) -> bool:
    """Tell whether a graph's shape (numbers, or names where it is free) can be the wanted one.

    Where a number is wanted and the graph leaves it free, it must leave all free but the batch:
    otherwise the number stands elsewhere, and the graph is of the other layout.
    """
    free = not any(isinstance(size, int) for size in got[1:])
    return len(got) == len(wanted) and all(
        w is None or g == w or (free and not isinstance(g, int))
        for g, w in zip(got, wanted, strict=True)
    )


def _reason(error: Exception) -> str:
    return " ".join(str(error).split())[:160]
