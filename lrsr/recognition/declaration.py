"""What is said of a model that comes here? Its contract, written beside it, and tried."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import write_text
from lrsr.onnx import contract_path, declared_text, open_session, sha256_of
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.registry import Kind, Model, Source, contracts


def contract_of(source: Source, model: Model, place: Path) -> dict[str, Any]:
    """Return what the registry says of a file that one of its models is."""
    document = graphs_own(contracts()[model.contract], place) | {
        "licence": source.licence,
        "source": origin_of(source),
    }
    for changed, value in model.changes.items():
        table, _, field = changed.partition(".")
        document[table] = {**document[table], field: value}
    return document


def origin_of(source: Source) -> str:
    """Return where a source's makers have it."""
    return source.url or f"the Python package {source.package}"


def graphs_own(contract: Mapping[str, Any], model: Path) -> dict[str, Any]:
    """Return a contract with what the graph states: sizes and dimension, or names of outputs."""
    document = {key: dict(v) if isinstance(v, dict) else v for key, v in contract.items()}
    session = open_session(model)
    outputs, shape = session.get_outputs(), session.get_inputs()[0].shape
    if "alignment" not in document:
        if "output" in document:
            document["output"].setdefault("names", [output.name for output in outputs])
        return document
    sides = shape[2:4] if document["input"]["layout"] == "NCHW" else shape[1:3]
    stated = dict(zip(("height_px", "width_px"), sides, strict=False))
    document["input"] |= {key: side for key, side in stated.items() if isinstance(side, int)}
    if outputs and isinstance(outputs[0].shape[-1], int):
        document["output"]["dimension"] = outputs[0].shape[-1]
    return document


def declare(model: Path, document: Mapping[str, Any]) -> Kind:
    """Write a contract beside a model, and try both.

    Raises:
        InputError: They do not fit, or one cannot be used.
    """
    text = declared_text({**document, "sha256": sha256_of(model)})
    write_text(contract_path(model), text)
    kind: Kind = "recogniser" if "alignment" in document else "detector"
    try:
        _ = Embedder(model) if kind == "recogniser" else Detector(model)
    except InputError as error:
        raise InputError(str(error).replace(f"{model.parent}/", "")) from error
    return kind
