"""What does ``lrsr render`` do? Pictures of people as files in a folder, with their manifest."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import torch

from lrsr.camera import Camera
from lrsr.camera.exposure import expose
from lrsr.camera.optics import bin_pixels
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker, mitsuba_maker
from lrsr.data.manifest import MANIFEST, ManifestRow, about, read_manifest, write_manifest
from lrsr.data.png import write_png
from lrsr.data.probes import Probe, filmed, load_radiances, photograph, render_missing
from lrsr.data.recipe import Kind, ProbeRecipe
from lrsr.errors import InputError
from lrsr.files import sweep
from lrsr.identities.face.expression import find_expression
from lrsr.identities.roster import UNCHECKED, Cast
from lrsr.identities.splits import Split
from lrsr.paths import cache_folder
from lrsr.rendering.lens import find_lens
from lrsr.rendering.radiance import Radiance, spectrum_of
from lrsr.rendering.standpoint import find_standpoint

if TYPE_CHECKING:
    from lrsr.identities.face.expression import Expression
    from lrsr.rendering.lens import Lens
    from lrsr.rendering.scene import Lighting, Pose
    from lrsr.rendering.skin import Skin
    from lrsr.rendering.standpoint import Standpoint

_CHUNK = 64


@dataclass(frozen=True)
class RenderSettings:
    """Everything that ``lrsr render`` can be told.

    Attributes:
        out: Folder for the pictures and ``manifest.csv``; made if it is not there.
        count: How many people, >= 1.
        start: Number of the first one within the split.
        split: "train", "validation" or "test"; nobody is in two of them.
        cast: From whom they are drawn, and who of them was redrawn.
        kind: "probe", or "gallery": the enrolled picture, frontal in frontal light at 64 px without
            compression, whatever else is asked for.
        pose: Name, or any angles.
        lighting: Name, or any lights.
        compression: Of the ×1 picture. Finer films are true references: never compressed.
        ipd_px: Interpupillary distance of the frontal face on the ×1 film, px.
        scales: Films: 1, and 2 and 4 for references.
        png16: Write the exposed linear light too, clipped at white, in 16 bits a channel.
        camera: Takes the ×1 picture; its own compression is not used. None: the reference camera,
            which also takes enrolled pictures and finer films, with the exposure of this one.
        samples_per_pixel: Of the ×1 film.
        texture_size: Of the heads' albedo, px.
        skin: Name of a skin, or any other.
        max_depth: Longest light path.
        seed: Of the noise.
        cache: Folder of the render cache; None: the user's.
        expression: Name, or any face units; an enrolled face is neutral.
        lens: Name, or any surfaces; an enrolled picture is a pinhole's.
        standpoint: Name, or any place of the camera; level for an enrolled picture.

    Raises:
        InputError: A number is out of range, the roster does not reach that far, or there is no
            such compression.
    """

    out: Path
    count: int = 4
    start: int = 0
    split: Split = "test"
    kind: Kind = "probe"
    pose: "str | Pose" = "frontal"
    lighting: "str | Lighting" = "frontal"
    compression: str = "none"
    ipd_px: float = 8.0
    scales: Sequence[int] = (1,)
    png16: bool = False
    camera: Camera | None = None
    samples_per_pixel: int = 2048
    texture_size: int = 1024
    skin: "str | Skin" = "reflective"
    max_depth: int = 5
    seed: int = 0
    cache: Path | None = None
    cast: Cast = UNCHECKED
    expression: "str | Expression" = "neutral"
    lens: "str | Lens" = "pinhole"
    standpoint: "str | Standpoint" = "level"

    def __post_init__(self) -> None:
        if self.count < 1:
            raise InputError(f"identities.count={self.count}: wanted a number >= 1")
        if not self.scales:
            raise InputError("scales=[]: wanted at least one of 1, 2, 4")
        for index in (self.start, self.start + self.count - 1):
            self.cast.draw(self.split, index)  # refuses who is not on the roster
        Camera(self.compression)  # refuses an unknown one before anything is rendered

    def as_gallery(self) -> "RenderSettings":
        """Return the same with the conditions of an enrolled picture."""
        return replace(
            self,
            pose="frontal",
            lighting="frontal",
            expression="neutral",
            lens="pinhole",
            standpoint="level",
            compression="none",
            ipd_px=GALLERY_IPD_PX,
            samples_per_pixel=min(self.samples_per_pixel, GALLERY_SAMPLES),
        )

    def camera_of(self, scale: int) -> Camera:
        """Return who takes the pictures of that scale: finer ones are references, without flaws."""
        camera = self.camera or Camera()
        if scale == 1 and self.kind == "probe":
            return camera.compressing(self.compression)
        return camera.clean()

    def recipes(self, scale: int) -> list[ProbeRecipe]:
        """Return what everybody is rendered as, in pictures of that scale."""
        return [
            ProbeRecipe(
                split=self.split,
                index=index,
                kind=self.kind,
                pose=self.pose,
                lighting=self.lighting,
                ipd_px=self.ipd_px,
                scale=scale,
                samples_per_pixel=self.samples_per_pixel,
                texture_size=self.texture_size,
                skin=self.skin,
                max_depth=self.max_depth,
                population=self.cast.population,
                draw=self.cast.draw(self.split, index),
                expression=self.expression,
                lens=self.lens,
                standpoint=self.standpoint,
            ).seeded(self.seed)
            for index in range(self.start, self.start + self.count)
        ]


GALLERY_IPD_PX = 64.0
"""Of an enrolled picture; documents ask for 90, and recognition crops to about 35."""

GALLERY_SAMPLES = 64
"""Samples a pixel of a gallery picture at most: it has 64 times the pixels of an 8 px probe."""


def render_to_folder(
    settings: RenderSettings, *, progress: bool = True, maker: Maker | None = None
) -> Path:
    """Write the pictures and, last, the manifest that names them; return the manifest's path.

    Rows of earlier calls stay as long as their pictures do; a picture of the same name is made
    again. Stopped at any moment, the same call goes on: what was rendered is in the cache.

    Args:
        settings: What to write, and where.
        progress: Show a bar while rendering.
        maker: Builds and renders; Mitsuba when None.

    Raises:
        InputError: ``out`` is a file or holds a broken manifest, or it cannot be written.
    """
    if settings.kind == "gallery":
        settings = settings.as_gallery()
    maker = maker or mitsuba_maker()
    cache = RenderCache(settings.cache or cache_folder())
    rows = {row.file: row for row in _earlier(settings.out)}
    rows |= {row.file: row for row in write_pictures(settings, cache, progress, maker)}
    return write_manifest(settings.out, rows.values())


def write_pictures(
    settings: RenderSettings, cache: RenderCache, progress: bool, maker: Maker
) -> Iterator[ManifestRow]:
    """Write the pictures and yield their rows; what is not rendered yet is rendered first.

    Raises:
        InputError: The cache or ``out`` cannot be written.
    """
    cameras = {scale: settings.camera_of(scale) for scale in settings.scales}
    batches = [
        (camera, [filmed(recipe, camera) for recipe in settings.recipes(scale)])
        for scale, camera in cameras.items()
    ]
    everything = [recipe for _, recipes in batches for recipe in recipes]
    render_missing(everything, cache, progress=progress, maker=maker)
    sweep(settings.out)
    for camera, recipes in batches:
        for start in range(0, len(recipes), _CHUNK):
            chunk = recipes[start : start + _CHUNK]
            radiances = load_radiances(chunk, cache, progress=progress, maker=maker)
            probes = photograph(radiances, camera, [settings.kind] * len(chunk))
            for probe, radiance, recipe in zip(probes, radiances, chunk, strict=True):
                linear = _exposed(radiance, camera) if settings.png16 else None
                yield write_picture(
                    settings.out,
                    probe,
                    linear,
                    expression=find_expression(recipe.expression).name,
                    lens=find_lens(recipe.lens).name,
                    standpoint=find_standpoint(recipe.standpoint).name,
                    flaws="" if camera.flawless else camera.name,
                )


def _earlier(folder: Path) -> list[ManifestRow]:
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
    probe: Probe,
    linear: torch.Tensor | None = None,
    *,
    expression: str = "neutral",
    lens: str = "pinhole",
    standpoint: str = "level",
    flaws: str = "",
) -> ManifestRow:
    """Write a picture, and its linear light where that is given; return its row.

    The file's name says what is unusual about it; ``flaws`` is the name of a camera that has some.

    Raises:
        InputError: The folder cannot be written.
    """
    condition = f"{probe.kind}_{probe.pose}_{probe.lighting}_{probe.compression}"
    for name, usual in ((expression, "neutral"), (lens, "pinhole"), (standpoint, "level")):
        condition += f"_{name}" if name != usual else ""
    condition += f"_{flaws}" if flaws else ""
    stem = re.sub(
        r"[^\w.-]+", "-", f"{probe.identity_id}_{condition}_ipd{probe.ipd_px:g}_x{probe.scale}"
    )
    write_png(folder / f"{stem}.png", probe.image)
    if linear is not None:
        write_png(folder / f"{stem}_linear16.png", linear, bits=16)
    return ManifestRow(
        file=f"{stem}.png",
        identity_id=probe.identity_id,
        kind=probe.kind,
        pose=probe.pose,
        lighting=probe.lighting,
        compression=probe.compression,
        camera=probe.camera,
        ipd_px=probe.ipd_px,
        scale=probe.scale,
        seed=probe.seed,
        landmarks_px=tuple(probe.landmarks_px.flatten().tolist()),
        linear_file="" if linear is None else f"{stem}_linear16.png",
        **about(probe.person),
        expression=expression,
        lens=lens,
        standpoint=standpoint,
    )
