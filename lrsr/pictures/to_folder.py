"""What does ``lrsr render`` do? Pictures of people as files in a folder, with their manifest."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import torch

from lrsr.camera import Camera
from lrsr.camera.exposure import expose
from lrsr.camera.optics import bin_pixels
from lrsr.errors import InputError
from lrsr.files import sweep
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import MANIFEST, Entry, about, read_manifest, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.maker import Maker, mitsuba_maker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe, digest
from lrsr.pictures.render import CHUNK, filmed, load_radiances, photograph, render_missing
from lrsr.pictures.sitting import Sitting
from lrsr.rendering.radiance import Radiance, spectrum_of


@dataclass(frozen=True)
class RenderSettings:
    """Everything that ``lrsr render`` can be told.

    Attributes:
        out: Folder for the pictures and ``manifest.csv``; made if it is not there.
        sitting: Who is pictured, and how.
        camera: Takes the ×1 picture of a probe; its own compression is not used. The reference
            camera takes enrolled pictures and finer films, with the exposure of this one.
        camera_settings: What made that camera, in plain values, for the manifest.
        compression: Of the ×1 picture of a probe. True references are never compressed.
        scales: Films: 1, and 2 and 4 for references.
        png16: Write the exposed linear light too, clipped at white, in 16 bits a channel.

    Raises:
        InputError: A number is out of range, or there is no such compression.
    """

    out: Path
    sitting: Sitting
    camera: Camera
    camera_settings: Mapping[str, Any] = field(default_factory=dict)
    compression: str = "none"
    scales: Sequence[int] = (1,)
    png16: bool = False

    def __post_init__(self) -> None:
        if not self.scales:
            raise InputError("scales=[]: wanted at least one of 1, 2, 4")
        for scale in self.scales:  # refuses what is wrong before anything is rendered
            self.camera_of(scale)
            self.sitting.recipes(scale)

    def camera_of(self, scale: int) -> Camera:
        """Return who takes the pictures of that scale: finer ones are references, without flaws."""
        flawed = self.camera.compressing(self.compression)
        return flawed if scale == 1 and self.sitting.kind == "probe" else self.camera.clean()


def render_to_folder(
    settings: RenderSettings,
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> Path:
    """Write the pictures and, last, the manifest that names them; return the manifest's path.

    Rows of earlier calls stay as long as their pictures do. A picture that differs in anything has
    another name. Stopped at any moment, the same call goes on: what was rendered is in the cache.

    Args:
        settings: What to write, and where.
        cache: Where renderings are kept.
        progress: Show a bar while rendering.
        maker: Builds and renders; Mitsuba when None.

    Raises:
        InputError: ``out`` is a file or holds a broken manifest, or it cannot be written.
    """
    maker = maker or mitsuba_maker()
    _earlier(settings.out)  # refuses a broken manifest before any work
    written = {row.file: row for row in _write_pictures(settings, cache, progress, maker)}
    rows = {row.file: row for row in _earlier(settings.out)}
    return write_manifest(settings.out, (rows | written).values())


def _write_pictures(
    settings: RenderSettings, cache: RenderCache, progress: bool, maker: Maker
) -> Iterator[Entry]:
    """Write the pictures and yield their rows; what is not rendered yet is rendered first."""
    batches = [
        (settings.camera_of(scale), settings.sitting.recipes(scale)) for scale in settings.scales
    ]
    everything = [filmed(recipe, camera) for camera, recipes in batches for recipe in recipes]
    render_missing(everything, cache, progress=progress, maker=maker)
    sweep(settings.out)
    for camera, recipes in batches:
        for start in range(0, len(recipes), CHUNK):
            chunk = recipes[start : start + CHUNK]
            films = [filmed(recipe, camera) for recipe in chunk]
            radiances = load_radiances(films, cache, progress=progress, maker=maker)
            pictures = photograph(chunk, radiances, camera)
            for recipe, radiance, picture in zip(chunk, radiances, pictures, strict=True):
                linear = _exposed(radiance, camera) if settings.png16 else None
                made_by = {
                    "recipe": recipe.plain(maker.versions),
                    "camera": settings.camera_settings
                    if camera.name == settings.camera.name
                    else {"name": camera.name, "exposure_ev": camera.exposure_ev},
                }
                yield write_picture(
                    settings.out, picture, recipe, camera, settings.sitting, made_by, linear
                )


def _earlier(folder: Path) -> list[Entry]:
    """Return the rows of an earlier manifest whose pictures are still there.

    Raises:
        InputError: ``folder`` is a file, or its manifest is broken.
    """
    if folder.exists() and not folder.is_dir():
        raise InputError(f"out={folder} is a file: give a folder")
    if not (folder / MANIFEST).exists():
        return []
    return [row for row in read_manifest(folder, pictures=False) if (folder / row.file).is_file()]


def _exposed(radiance: Radiance, camera: Camera) -> torch.Tensor:
    """Return the exposed light ``(3, H, W)`` of a picture, linear, 1 = white."""
    metered = torch.tensor([radiance.metered])
    observed = camera.clean().see(radiance.image[None], spectrum_of([radiance]))
    exposed = expose(observed, metered, camera.exposure_ev)
    return bin_pixels(exposed, camera.supersampling)[0]


def write_picture(
    folder: Path,
    picture: Picture,
    recipe: Recipe,
    camera: Camera,
    sitting: Sitting,
    made_by: Mapping[str, Any],
    linear: torch.Tensor | None = None,
) -> Entry:
    """Write a picture, and its linear light where that is given; return its row.

    The file's name says what is unusual about it, and ends in a digest of everything that made it.

    Args:
        folder: Made if need be.
        picture: As the camera stored it.
        recipe: What was rendered.
        camera: Took it.
        sitting: What it is one of.
        made_by: Everything that made it, in plain values.
        linear: ``(3, H, W)``, exposed light.

    Raises:
        InputError: The folder cannot be written.
    """
    scene, film, compression = recipe.scene, recipe.film, camera.compression
    made_by = {**made_by, "compression": compression}
    usual = {"neutral", "pinhole", "level", "reflective", "reference"}
    further = (scene.expression, scene.lens, scene.standpoint, recipe.quality.skin, camera)
    words = [picture.identity_id, sitting.kind, scene.pose.name, scene.lighting.name, compression]
    words += [each.name for each in further if each.name not in usual]
    words += [f"ipd{film.ipd_px:g}", f"x{picture.scale}", digest(made_by)[:8]]
    stem = re.sub(r"[^\w.-]+", "-", "_".join(words))
    write_png(folder / f"{stem}.png", picture.image)
    if linear is not None:
        write_png(folder / f"{stem}_linear16.png", linear, bits=16)
    if picture.landmarks_px is None:
        raise RuntimeError("a rendered picture without landmarks")
    return Entry(
        file=f"{stem}.png",
        identity_id=picture.identity_id,
        kind=sitting.kind,
        pose=scene.pose.name,
        lighting=scene.lighting.name,
        compression=compression,
        camera=camera.name,
        ipd_px=film.ipd_px,
        scale=picture.scale,
        seed=recipe.seed,
        landmarks_px=tuple(picture.landmarks_px.flatten().tolist()),
        linear_file="" if linear is None else f"{stem}_linear16.png",
        **about(picture.traits),
        expression=scene.expression.name,
        lens=scene.lens.name,
        standpoint=scene.standpoint.name,
        yaw_deg=scene.pose.yaw_deg,
        pitch_deg=scene.pose.pitch_deg,
        roll_deg=scene.pose.roll_deg,
        skin=recipe.quality.skin.name,
        samples_per_pixel=recipe.quality.samples_per_pixel,
        run_seed=sitting.seed,
        settings=json.dumps(made_by, sort_keys=True),
    )
