"""Which models are known by name, and where does one lie that is here?

``lrsr/assets/models.toml`` says of each source (an archive, a file, a Python package) where it
comes from, under which licence, which models it holds, and their checksums, as far as their makers
say them. What is here lies in one folder, ``NAME.onnx`` with ``NAME.toml``, its contract, and
``NAME.json``, its record; :mod:`lrsr.recognition.store` writes it.
"""

import json
import os
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from difflib import get_close_matches
from functools import cache
from pathlib import Path
from typing import Any, Literal

from lrsr.errors import InputError
from lrsr.files import read_bytes
from lrsr.paths import asset, models_folder, user_path

Kind = Literal["recogniser", "detector"]


@dataclass(frozen=True)
class Model:
    """One network of a source.

    Attributes:
        name: What it is called in ``recognition=`` or ``recognition.detector=``.
        kind: What it does.
        files: Their names within the source, and what they are called here.
        contract: Name of its contract; empty: none is written, as its user needs none.
        trained_on: Which faces it has seen.
        sha256: Of each file, by its name here; what is missing is not known.
        changes: What its contract says otherwise, by "table.field".
    """

    name: str
    kind: Kind
    files: Mapping[str, str]
    contract: str
    trained_on: str
    sha256: Mapping[str, str] = field(default_factory=dict)
    changes: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Source:
    """Something that can be fetched, and what is in it.

    Attributes:
        name: What it is called.
        licence: Of the weights.
        models: What it holds.
        url: Of a file or a ZIP archive; empty: it is a Python package.
        package: Its name and exact version, ``NAME==VERSION``.
        sha256: Of what is fetched; empty: its makers do not say.
        size: The same, in bytes; 0: not known.
        research_only: Whether the licence allows nothing else.
    """

    name: str
    licence: str
    models: tuple[Model, ...]
    url: str = ""
    package: str = ""
    sha256: str = ""
    size: int = 0
    research_only: bool = False


@cache
def sources() -> dict[str, Source]:
    """Return all that ships with lrsr's registry, by name."""
    found = {}
    for name, told in _document()["source"].items():
        models = tuple(Model(**{"name": key, **model}) for key, model in told.pop("model").items())
        found[name] = Source(name, models=models, **told)
    return found


def contracts() -> dict[str, dict[str, Any]]:
    """Return the contracts that have a name, by table and field."""
    return dict(_document()["contract"])


def _document() -> dict[str, Any]:
    return tomllib.loads(asset("models.toml").read_text(encoding="utf-8"))


def records() -> dict[str, dict[str, Any]]:
    """Return what is here: the record of each model, by name.

    Raises:
        InputError: A record cannot be read.
    """
    found = {}
    for path in sorted(models_folder().glob("*.json")):
        try:
            record = json.loads(read_bytes(path))
            kind, files = record["kind"], record["files"]
            whole = isinstance(kind, str) and all(
                isinstance(value, str) for value in files.values()
            )
        except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
            raise InputError(f"{path}: no record of a model ({error}); remove it") from error
        if not whole or not all(Path(name).name == name for name in files):
            raise InputError(f"{path}: no record of a model; remove it")
        found[path.stem] = record
    return found


def model_file(name: str, kind: Kind) -> Path:
    """Return the file that a user means by ``recognition=NAME`` or ``recognition.detector=NAME``.

    Args:
        name: Of a model that is here, of a source of such, or the path of a file.
        kind: What it is to do.

    Returns:
        Its path; the contract lies beside it.

    Raises:
        InputError: There is none of this name, it is not here, or does something else.
    """
    if os.sep in name or name.lower().endswith((".onnx", ".safetensors")):
        return user_path(name)
    here = records()
    # Of several that hold it the first, as lrsr models pull has it.
    known = {
        model.name: source for source in reversed(sources().values()) for model in source.models
    }
    if name in sources():
        inner = [model.name for model in sources()[name].models if model.kind == kind]
        known |= {name: sources()[name]}
        name = next((one for one in inner if one in here), name)
    if name in here:
        if here[name]["kind"] != kind:
            raise InputError(f"{name} is a {here[name]['kind']}; wanted a {kind}")
        file: str = next(iter(here[name]["files"]))
        return models_folder() / file
    if name in known:
        raise InputError(f"{name} is not here: lrsr models pull {known[name].name}")
    near = get_close_matches(name, [*here, *known], n=1)
    hint = f"did you mean {near[0]}?" if near else "lrsr models list shows what there is"
    raise InputError(f"no {kind} {name!r}: {hint}")
