"""Where is a rendering kept, so that it is made once and a damaged one is noticed?

What is kept is the light before the camera: another exposure or compression renders nothing anew.
An entry is one file, ``<first 2 digits of its key>/<key>.safetensors``. It is written beside and
renamed (:mod:`lrsr.files`), so it is there whole or not at all, whoever else writes the same one.
It carries a SHA-256 of its content; one that does not match is reported, and made again.
"""

import hashlib
import json
import logging
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError
from safetensors.torch import load, save

from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import read_bytes, sweep, write_bytes
from lrsr.identities.person import Traits
from lrsr.images import check_images
from lrsr.pictures.recipe import Recipe, canonical, digest
from lrsr.rendering.radiance import Radiance

_FORMAT = 3
"""Part of every key: a change of the entries' layout leaves the old ones unread."""

_TENSORS = ("image", "landmarks_px")

logger = logging.getLogger(__name__)


class RenderCache:
    """A folder of renderings, found by what made them. Safe for any number of processes at once.

    Args:
        folder: Made when the first entry is written.
        processes: How many render at once what it lacks.

    Raises:
        InputError: ``folder`` is a file, or there is to be no process.
    """

    def __init__(self, folder: Path, processes: int = 1) -> None:
        self.folder, self.processes = Path(folder), processes
        require(processes >= 1, "processes", processes, "at least 1")
        if self.folder.exists() and not self.folder.is_dir():
            raise InputError(f"cache folder {self.folder} is a file: choose another folder")
        self._reported: set[str] = set()

    @staticmethod
    def key(recipe: Recipe, versions: Mapping[str, str]) -> str:
        """Return under what a rendering is kept: a digest of everything that changes its pixels.

        Args:
            recipe: What is rendered.
            versions: Of the code that renders it.
        """
        return digest({"format": _FORMAT, **recipe.plain(versions)})

    def path(self, key: str) -> Path:
        """Return where the entry of that key is, or would be."""
        return self.folder / key[:2] / f"{key}.safetensors"

    def get(self, key: str) -> Radiance | None:
        """Return what is kept under ``key``; None if nothing is, or if it is damaged (logged once).

        Raises:
            InputError: The file is there but cannot be read.
        """
        path = self.path(key)
        try:
            content = read_bytes(path)
        except FileNotFoundError:
            return None
        except OSError as error:
            raise InputError(
                f"cannot read {path}: {error.strerror or error}; mend its rights or remove it"
            ) from error
        try:
            return _unpack(content)
        except (SafetensorError, ValueError, KeyError, TypeError) as error:
            if key not in self._reported:
                self._reported.add(key)
                logger.warning("damaged cache entry %s (%s): it is made again", path, error)
            return None

    def put(self, key: str, radiance: Radiance) -> None:
        """Keep ``radiance`` under ``key``, replacing what is there.

        Raises:
            InputError: The folder cannot be written or the disk is full; nothing is left behind.
            ImageContractError: The image breaks the contract.
            NonFiniteError: The image holds a NaN or an infinity: it would stay for ever.
        """
        channels = 3 if radiance.edges_nm is None else len(radiance.edges_nm) - 1
        check_images(radiance.image[None], channels=channels, name=f"rendering {key[:12]}")
        write_bytes(self.path(key), _pack(radiance), durable=False)  # its checksum tells

    def sweep(self) -> int:
        """Remove the unfinished files of killed writers; return how many there were."""
        return sum(sweep(shard) for shard in self.folder.glob("[0-9a-f][0-9a-f]"))


def _pack(radiance: Radiance) -> bytes:
    traits = None if radiance.traits is None else asdict(radiance.traits)
    plain: dict[str, Any] = {**vars(radiance), "traits": traits}
    tensors = {name: plain.pop(name).detach().cpu().float().contiguous() for name in _TENSORS}
    note = {"radiance": plain, "sha256": _digest(tensors, plain)}
    # One note, not two: safetensors writes several in random order, and equal means equal bytes.
    content: bytes = save(tensors, {"lrsr": canonical(note).decode()})
    return content


def _unpack(content: bytes) -> Radiance:
    tensors = load(content)
    length = int.from_bytes(content[:8], "little")
    note = json.loads(json.loads(content[8 : 8 + length])["__metadata__"]["lrsr"])
    plain = note["radiance"]
    if set(tensors) != set(_TENSORS) or note["sha256"] != _digest(tensors, plain):
        raise ValueError("its checksum does not match")
    traits = plain.pop("traits")
    for name in ("edges_nm", "metered_bands"):
        plain[name] = None if plain[name] is None else tuple(plain[name])
    return Radiance(**tensors, **plain, traits=None if traits is None else Traits(**traits))


def _digest(tensors: Mapping[str, torch.Tensor], plain: Mapping[str, Any]) -> str:
    digest = hashlib.sha256(canonical(plain))
    for name in _TENSORS:
        digest.update(f"{name}{tensors[name].dtype}{tuple(tensors[name].shape)}".encode())
        digest.update(tensors[name].numpy().tobytes())
    return digest.hexdigest()
