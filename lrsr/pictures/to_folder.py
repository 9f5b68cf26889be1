"""What does ``lrsr render`` do? Pictures of people as files in a folder, with their manifest."""

import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import torch

from lrsr.camera import Camera
from lrsr.camera.exposure import expose
from lrsr.camera.optics import bin_pixels
from lrsr.configuration import require
from lrsr.errors import InputError
from lrsr.files import locked, sweep
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import MANIFEST, Entry, about, read_manifest, write_manifest
from lrsr.pictures.image_files import write_png
from lrsr.pictures.maker import Maker, MitsubaMaker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe, digest
from lrsr.pictures.render import filmed, load_radiances
from lrsr.pictures.sitting import Sitting
from lrsr.pictures.source import Rendered, chunks, render_sources
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
        frames: Pictures of each person's burst, on each film.
        png16: Write the exposed linear light too, clipped at white, in 16 bits a channel.

    Raises:
        InputError: A number is out of range, there is no such compression, or the camera has a lens
            of its own besides the scene's.
    """

    out: Path
    sitting: Sitting
    camera: Camera
    camera_settings: Mapping[str, Any] = field(default_factory=dict)
    compression: str = "none"
    scales: Sequence[int] = (1,)
    frames: int = 1
    png16: bool = False

    def __post_init__(self) -> None:
        if not self.scales:
            raise InputError("scales=[]: wanted at least one of 1, 2, 4")
        lens = self.sitting.scene.lens
        self.camera.check_lens(lens.name, pinhole=lens.is_pinhole)
        require(self.frames >= 1, "frames", self.frames, "at least 1")
        for scale in self.scales:  # refuses what is wrong before anything is rendered
            self.shoot(scale)
            self.sitting.recipes(scale)

    def shoot(self, scale: int, frame: int = 0) -> "Shoot":
        """Return who takes the pictures of that scale: finer ones are references, without flaws."""
        if scale == 1 and self.sitting.kind == "probe":
            camera = self.camera.compressing(self.compression)
            return Shoot(self.sitting, camera, self.camera_settings, frame)
        return Shoot(self.sitting, self.camera.clean(), frame=frame)


@dataclass(frozen=True)
class Shoot:
    """A sitting and who takes its pictures.

    Attributes:
        sitting: Who is pictured, how, and what for.
        camera: Takes them.
        camera_settings: What it is made of, in plain values; a flawless one needs none.
        frame: Which of everyone's burst.
    """

    sitting: Sitting
    camera: Camera
    camera_settings: Mapping[str, Any] = field(default_factory=dict)
    frame: int = 0

    def entry(self, picture: Picture, recipe: Recipe, versions: Mapping[str, str]) -> Entry:
        """Return the row of a picture.

        Its file's name says what is unusual about it, and has a digest of all that made it.

        Args:
            picture: As the camera stored it.
            recipe: What was rendered.
            versions: Of the code that rendered it.
        """
        scene, film, skin, camera = recipe.scene, recipe.film, recipe.quality.skin, self.camera
        names = ("name", "exposure_ev", "compression", "bands", "adapted")
        told = {**self.camera_settings, **{name: getattr(camera, name) for name in names}}
        made_by = {"recipe": recipe.plain(versions), "camera": told}
        usual = {"neutral", "none", "pinhole", "level", "reflective", "reference"}
        further = (scene.expression, scene.another_day, scene.lens, scene.standpoint, skin, camera)
        words = [picture.identity_id, self.sitting.kind, scene.pose.name, scene.lighting.name]
        words += [camera.compression, *(each.name for each in further if each.name not in usual)]
        words += [digest(made_by)[:8], f"ipd{film.ipd_px:g}", f"x{picture.scale}"]
        words += [f"frame{self.frame}"] if self.frame else []
        points = picture.landmarks_px
        angles = {name: value for name, value in asdict(scene.pose).items() if name != "name"}
        return Entry(
            file=re.sub(r"[^\w.-]+", "-", "_".join(words)) + ".png",
            identity_id=picture.identity_id,
            kind=self.sitting.kind,
            pose=scene.pose.name,
            lighting=scene.lighting.name,
            compression=camera.compression,
            camera=camera.name,
            ipd_px=film.ipd_px,
            scale=picture.scale,
            seed=recipe.seed,
            landmarks_px=None if points is None else tuple(points.flatten().tolist()),
            **about(picture.traits),
            expression=scene.expression.name,
            lens=scene.lens.name,
            standpoint=scene.standpoint.name,
            **angles,
            skin=skin.name,
            samples_per_pixel=recipe.quality.samples_per_pixel,
            run_seed=self.sitting.seed,
            another_day=scene.another_day.name,
            frame=self.frame,
            settings=json.dumps(made_by, sort_keys=True),
        )


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
    maker = maker or MitsubaMaker()
    earlier_rows(settings.out)  # refuses a broken manifest before any work
    written = {row.file: row for row in _write_pictures(settings, cache, progress, maker)}
    with locked(settings.out):  # another process may write its rows
        rows = {row.file: row for row in earlier_rows(settings.out)}
        return write_manifest(settings.out, (rows | written).values())


def _write_pictures(
    settings: RenderSettings, cache: RenderCache, progress: bool, maker: Maker
) -> Iterator[Entry]:
    """Write the pictures and yield their rows; what is not rendered yet is rendered first."""
    taken = [
        (scale, settings.shoot(scale, frame))
        for scale in settings.scales
        for frame in range(settings.frames)
    ]
    sources = [
        Rendered(settings.sitting.recipes(scale, shoot.frame), shoot.camera, cache, maker, progress)
        for scale, shoot in taken
    ]
    render_sources(sources)
    sweep(settings.out)
    for (_, shoot), source in zip(taken, sources, strict=True):
        for place, pictures in chunks(source):
            for recipe, picture in zip(source.recipes[place], pictures, strict=True):
                entry = shoot.entry(picture, recipe, maker.versions)
                write_png(settings.out / entry.file, picture.image)
                if settings.png16:
                    stem = entry.file.removesuffix(".png")
                    entry = replace(entry, linear_file=f"{stem}_linear16.png")
                    film = [filmed(recipe, source.camera)]
                    (light,) = load_radiances(film, cache, progress=progress, maker=maker)
                    linear = _exposed(light, source.camera)
                    write_png(settings.out / entry.linear_file, linear, bits=16)
                yield entry


def earlier_rows(folder: Path) -> list[Entry]:
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
