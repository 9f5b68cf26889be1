"""Which networks of other people are here, and are they still what they were?

Each lies in the folder of models as ``NAME.onnx``, with its contract ``NAME.toml`` and its record
``NAME.json``: what it does, its files' checksums, where it came from, its licence.
"""

import tempfile
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import write_json
from lrsr.onnx import contract_path, sha256_of
from lrsr.paths import models_folder
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.registry import records, sources


@contextmanager
def scratch_in(folder: Path) -> Iterator[Path]:
    """Give a folder on the same disk, so that what is in it can be renamed to its place."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".new-") as scratch:
        yield Path(scratch)


def keep(name: str, record: Mapping[str, Any], scratch: Path) -> None:
    """Rename the files of a record to their places, and write it down.

    Raises:
        InputError: The record cannot be written.
    """
    folder = models_folder()
    for here in record["files"]:
        for path in (scratch / here, contract_path(scratch / here)):
            if path.exists():
                path.replace(folder / path.name)
    write_json(folder / f"{name}.json", record)


def verify(names: Collection[str] = ()) -> list[str]:
    """Say of models that are here whether their bytes and contracts are what they were.

    Args:
        names: Which; empty: all.

    Returns:
        A line for each.

    Raises:
        InputError: One is not here, or not what it was.
    """
    here = records()
    chosen = [_known(name, here) for name in names] or [[name] for name in here]
    said, wrong = [], []
    for name in (one for some in chosen for one in some):
        try:
            said.append(f"{name}: {_verified(name, here[name])}")
        except InputError as error:
            wrong.append(str(error))
    if wrong:
        raise InputError("; ".join(wrong))
    return said


def _verified(name: str, record: Mapping[str, Any]) -> str:
    for here, digest in record["files"].items():
        path = models_folder() / here
        if not path.is_file():
            raise InputError(f"{name}: {path} is missing; remove it and pull or add it again")
        if sha256_of(path) != digest:
            raise InputError(f"{name}: {path} is damaged; remove it and pull or add it again")
        if contract_path(path).exists():
            _ = Embedder(path) if record["kind"] == "recogniser" else Detector(path)
    if record.get("checked"):
        return "as it was recorded"
    return "as it came; no checksum of its makers is known"


def _known(name: str, here: Mapping[str, Any]) -> list[str]:
    """Return the models that are here and are meant by a name, of one or of a source.

    Raises:
        InputError: None is here.
    """
    source = sources().get(name)
    inner = [model.name for model in source.models] if source else [name]
    found = [one for one in inner if one in here]
    if not found:
        raise InputError(f"{name} is not here: lrsr models list shows what is")
    return found


def remove(name: str) -> list[str]:
    """Remove a model, or all of a source; say which.

    Raises:
        InputError: It is not here.
    """
    folder, said = models_folder(), []
    here = records()
    for one in _known(name, here):
        (folder / f"{one}.json").unlink(missing_ok=True)
        for file in here[one]["files"]:
            (folder / file).unlink(missing_ok=True)
            contract_path(folder / file).unlink(missing_ok=True)
        said.append(f"{one}: removed")
    return said


def table() -> list[str]:
    """Return a line for each model: what is here, then what can be pulled."""
    here, checked = records(), {True: "known", False: "unknown"}
    rows = [("name", "does", "from", "checksum", "licence", "trained on")]
    for name, record in here.items():
        told = (str(record.get(key, "not told")) for key in ("licence", "trained_on"))
        rows.append((name, record["kind"], "here", checked[bool(record.get("checked"))], *told))
    rows += [
        (
            *(model.name, model.kind, f"pull {source.name}"),
            *(checked[bool(source.sha256 or model.sha256)], source.licence, model.trained_on),
        )
        for source in sources().values()
        for model in source.models
        if model.name not in here
    ]
    widths = [max(len(row[k]) for row in rows) for k in range(5)]
    return [
        "  ".join([*(cell.ljust(w) for cell, w in zip(row, widths, strict=False)), row[-1]])
        for row in rows
    ]
