"""How does a network of the user's come among the models? Copied, declared, and tried."""

import shutil
import tomllib
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import locked, make_folder, read_bytes, why_no_file
from lrsr.onnx import contract_path, sha256_of
from lrsr.paths import models_folder
from lrsr.recognition.declaration import contract_of, declare, graphs_own
from lrsr.recognition.registry import Model, Source, contracts, records, sources
from lrsr.recognition.store import keep, scratch_in


def add(
    file: Path, contract: str = "", *, name: str = "", licence: str = "", source: str = ""
) -> str:
    """Copy a network of the user's into the folder of models, so that its name is enough.

    A file of the registry's is known by its bytes, whatever it is called: it needs no contract, and
    is recorded as if it had been pulled.

    Args:
        file: An ONNX file.
        contract: One with a name, or a TOML file; empty: the registry's, else the one beside the
            file.
        name: What it is to be called; empty: as the registry has it, else as the file.
        licence: Of the weights; empty: what the contract says, or not told.
        source: Where it comes from; empty: the same.

    Returns:
        A line that says where it is.

    Raises:
        InputError: The file, the contract or the name cannot be used; nothing is kept.
    """
    if why := why_no_file(file):
        raise InputError(f"{file} {why}: give an ONNX file")
    digest = sha256_of(file)
    same = [one for one in _single_files() if digest in one[1].sha256.values()]
    known = min(same, key=lambda one: one[1].name != (name or file.stem), default=None)
    name = name or (known[1].name if known else file.stem)
    if not name.translate(str.maketrans("", "", "-_.")).isalnum() or name.startswith("."):
        raise InputError(f"name={name}: wanted letters, digits, - and _")
    folder = make_folder(models_folder())
    with locked(folder), scratch_in(folder) as scratch:
        if name in records():
            raise InputError(f"name={name}: taken; give another, or lrsr models remove {name}")
        if not (known and known[1].name == name) and name in _registered():
            raise InputError(f"name={name}: lrsr models list has another file of it; give another")
        place = scratch / f"{name}.onnx"
        shutil.copyfile(file, place)
        untold = {"licence": "not told", "source": f"added from {file.name}"}
        if known and not contract:
            document = contract_of(*known, file)
        else:
            document = untold | _document(contract, file, digest)
        given = {"licence": licence, "source": source}
        document |= {key: value for key, value in given.items() if value}
        kind = declare(place, document)
        record = {
            "kind": kind,
            "files": {place.name: digest},
            "licence": document["licence"],
            "source": document["source"],
            "trained_on": known[1].trained_on if known else "not told",
            "checked": True,
        }
        keep(name, record, scratch)
    return f"{name}: {folder / place.name} ({kind})"


def _single_files() -> list[tuple[Source, Model]]:
    """Return the registry's models of one file with a contract."""
    return [
        (source, model)
        for source in sources().values()
        for model in source.models
        if model.contract and len(model.files) == 1
    ]


def _registered() -> set[str]:
    return {*sources(), *(model.name for one in sources().values() for model in one.models)}


def _document(contract: str, file: Path, digest: str) -> dict[str, Any]:
    """Return the contract that a user means.

    Raises:
        InputError: There is none, it cannot be read, or is about another file.
    """
    if contract in contracts():
        return graphs_own(contracts()[contract], file)
    path = Path(contract).expanduser() if contract else contract_path(file)
    try:
        document = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except (OSError, ValueError) as error:
        named = ", ".join(contracts())
        raise InputError(
            f"contract={contract or path}: cannot be read ({error}); one of {named}, or a TOML file"
        ) from error
    if document.get("sha256", digest) != digest:
        raise InputError(f"{path}: its sha256 is not that of {file}; give the contract of this one")
    return document
