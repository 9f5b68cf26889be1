"""What does ``lrsr identities export=DIR`` do? Meshes of people, and what a camera sees of them.

Each person has a folder, named as the picture of ``lrsr render`` would be:

==================== ==============================================================================
``picture.png``      as the camera stored it
``head.glb``         glTF 2.0: a mesh and an albedo texture for each part, metres
``head.obj``         the same for older programs, with ``head.mtl`` and an albedo ``PART.png`` each
``depth_mm.png``     16 bits, whole millimetres along the optical axis; 0: nothing, 65535: farther
``normals.png``      8 bits, (n + 1) / 2 of the camera frame; black: nothing
``parts.png``        8 bits, the number of the part; 0: nothing. ``landmarks.json`` names them
``geometry.npz``     ``depth_m``, ``normals``, ``parts`` as they were measured, float32 and uint8
``landmarks.json``   landmarks in mm and px, the camera, the names of the parts
==================== ==============================================================================

The camera frame has x to the picture's right, y up, z towards the camera.
"""

import io
import json
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from lrsr.errors import InputError
from lrsr.files import locked, make_folder, sweep, write_bytes, write_json
from lrsr.identities.head import LANDMARK_NAMES, Head
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import Entry, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.maker import MitsubaMaker, Surveyor
from lrsr.pictures.mesh_files import write_meshes
from lrsr.pictures.picture import Picture
from lrsr.pictures.render import filmed, take_pictures
from lrsr.pictures.to_folder import RenderSettings, earlier_rows
from lrsr.rendering.survey import Survey

_LAST = "landmarks.json"
"""Written when all else of a person is there."""
_FARTHEST_MM = 65535


def export_to_folder(
    settings: RenderSettings,
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Surveyor | None = None,
) -> Path:
    """Write a folder for each person and, last, the manifest that names them; return its path.

    Stopped at any moment, the same call goes on after the last person that is complete.

    Args:
        settings: Who, how pictured and where to; of the scales only the first film is used.
        cache: Where renderings are kept.
        progress: Show a bar.
        maker: Builds, renders and surveys; Mitsuba when None.

    Raises:
        InputError: The lens is no pinhole, ``out`` is a file or holds a broken manifest, or it
            cannot be written.
    """
    maker = maker or MitsubaMaker()
    lens = settings.sitting.scene.lens
    if not lens.is_pinhole:
        raise InputError(f"lens={lens.name}: depth and normals are those of lens=pinhole")
    earlier_rows(settings.out)  # refuses a broken manifest before any work
    written = {row.file: row for row in _export(settings, cache, progress, maker)}
    with locked(settings.out):
        rows = {row.file: row for row in earlier_rows(settings.out)}
        return write_manifest(settings.out, (rows | written).values())


def _export(
    settings: RenderSettings, cache: RenderCache, progress: bool, maker: Surveyor
) -> Iterator[Entry]:
    shoot = settings.shoot(1)
    recipes = settings.sitting.recipes()
    for recipe in tqdm(recipes, desc="exporting", unit="person", disable=not progress):
        film = filmed(recipe, shoot.camera)
        key = cache.key(film, maker.versions)
        head = None
        if cache.get(key) is None:
            head = maker.head(film)
            cache.put(key, maker.render(head, film))
        (picture,) = take_pictures([recipe], cache, shoot.camera, progress=False, maker=maker)
        entry = shoot.entry(picture, recipe, maker.versions)
        name = entry.file.removesuffix(".png")
        folder = make_folder(settings.out / name)
        if not (folder / _LAST).exists():
            sweep(folder)
            head = head or maker.head(recipe)
            write_png(folder / "picture.png", picture.image)
            _write_person(folder, head, picture, maker.survey(head, recipe))
        yield replace(entry, file=str(PurePosixPath(name) / "picture.png"))


def _write_person(folder: Path, head: Head, picture: Picture, seen: Survey) -> None:
    write_meshes(folder, head)
    millimetres = np.clip(np.rint(1000 * seen.depth_m), 0, _FARTHEST_MM).astype(np.uint16)
    shown = np.where(seen.parts[..., None] > 0, (seen.normals + 1) / 2, 0)
    images = {
        "depth_mm": millimetres,
        "normals": np.rint(255 * shown[..., ::-1]).astype(np.uint8),  # OpenCV's order
        "parts": seen.parts,
    }
    for name, image in images.items():
        _, file = cv2.imencode(".png", np.ascontiguousarray(image))
        write_bytes(folder / f"{name}.png", file.tobytes(), durable=False)
    arrays = io.BytesIO()
    np.savez_compressed(arrays, depth_m=seen.depth_m, normals=seen.normals, parts=seen.parts)
    write_bytes(folder / "geometry.npz", arrays.getvalue(), durable=False)
    write_json(folder / _LAST, _describe(head, picture, seen))


def _describe(head: Head, picture: Picture, seen: Survey) -> dict[str, Any]:
    """Say where the landmarks are, in plain values, and by which camera.

    Returns:
        JSON-serialisable: ``identity_id``; ``landmarks``, by name, each with ``head_mm`` (head
        frame), ``camera_mm`` (camera frame) and ``image_px`` (the centre of the top-left pixel is
        0, 0); ``ipd_mm``; ``camera``: ``head_to_camera`` (4 × 4, mm), ``focal_px``, ``centre_px``
        and ``size_px`` of the picture; ``parts``: the number of each in ``parts.png``.
    """
    side = seen.depth_m.shape[0]
    camera_mm = _moved(head.landmarks, seen.to_camera)
    points = np.full((5, 2), np.nan) if picture.landmarks_px is None else picture.landmarks_px
    return {
        "identity_id": picture.identity_id,
        "landmarks": {
            name: {
                "head_mm": _rounded(head.landmarks[k]),
                "camera_mm": _rounded(camera_mm[k]),
                "image_px": _rounded(np.asarray(points)[k]),
            }
            for k, name in enumerate(LANDMARK_NAMES)
        },
        "ipd_mm": round(head.ipd_mm, 4),
        "camera": {
            "head_to_camera": [_rounded(row, 9) for row in seen.to_camera],
            "focal_px": round(seen.focal_px, 6),
            "centre_px": [side / 2 - 0.5, side / 2 - 0.5],
            "size_px": [side, side],
        },
        "parts": {name: 1 + place for place, name in enumerate(seen.names)},
        "parameters": json.loads(json.dumps(dict(head.parameters))),
    }


def _moved(points: NDArray[np.float64], matrix: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(points @ matrix[:3, :3].T + matrix[:3, 3])


def _rounded(values: NDArray[Any], digits: int = 4) -> list[float]:
    return [round(float(value), digits) + 0.0 for value in values]
