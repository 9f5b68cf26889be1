"""From a head, a pose and a lighting to the light on the film."""

from functools import cache
from typing import Any

import numpy as np
import torch

from lrsr.errors import InputError, NonFiniteError
from lrsr.identities.head import Head
from lrsr.rendering.film import expose
from lrsr.rendering.geometry import place_camera
from lrsr.rendering.lens import Lens, find_lens
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import Lighting, Pose, environment, find_lighting, find_pose
from lrsr.rendering.skin import Skin
from lrsr.rendering.stage import Stage
from lrsr.rendering.standpoint import Standpoint, find_standpoint
from lrsr.spectra import band_edges

RENDERER_VERSION = "2"
"""Changes whenever the same head would give other pixels."""

SPECTRA_VERSION = "1"
"""Changes whenever it would do so only in variants that trace wavelengths."""

MIN_SAMPLES = 16
"""No pixel has fewer samples, however fine its film."""

ROULETTE_DEPTH = 2
"""From which bounce on dim paths may end by chance: a third less time, 7 % more noise."""


class Renderer:
    """Renders heads; keeps its scene and its compiled kernels between calls.

    Args:
        skin: Name of a skin model, "reflective" (opaque, the fastest), "subsurface" (translucent),
            "volumetric" (the same, traced in full: the truth, for comparison) or another of
            :data:`lrsr.rendering.skin.SKINS`; or any :class:`lrsr.rendering.skin.Skin`.
        max_depth: Longest path, in edges from the camera, >= 2; volumetric skin knows no limit.

    Raises:
        InputError: There is no such skin model, or the depth is too small.
    """

    def __init__(self, skin: str | Skin = "reflective", *, max_depth: int = 5) -> None:
        if max_depth < 2:
            raise InputError(f"max_depth={max_depth} lights nothing; give at least 2")
        self.max_depth = max_depth
        self._stage = Stage(skin)
        self.skin = self._stage.skin.name

    def render(
        self,
        head: Head,
        *,
        pose: str | Pose = "frontal",
        lighting: str | Lighting = "frontal",
        ipd_px: float = 8.0,
        scale: int = 1,
        samples_per_pixel: int = 2048,
        seed: int = 0,
        camera_m: float | None = None,
        lens: str | Lens = "pinhole",
        standpoint: str | Standpoint = "level",
        bands: int = 0,
    ) -> Radiance:
        """Render one picture.

        Args:
            head: Who.
            pose: Name or angles.
            lighting: Name or lights.
            ipd_px: Interpupillary distance of the frontal face on the ×1 film, px, > 0.
            scale: The film has ``scale`` times the pixels of the ×1 film, >= 1.
            samples_per_pixel: Of the ×1 film; a finer one has 1/scale² of them, at least 16.
            seed: Of the sampler, >= 0.
            camera_m: Distance of the camera, m; None: where the reference camera must stand.
            lens: Name or surfaces. It is focused on the eyes, unless it says otherwise.
            standpoint: Name or distance and height of the camera.
            bands: Spectral bands to deliver instead of three colours, 7 to 350, in a variant that
                traces wavelengths; 0: three colours.

        Returns:
            The linear picture with its landmarks.

        Raises:
            InputError: No such pose, lighting, lens or standpoint, a number out of range, or bands
                of a variant that traces colours.
            NonFiniteError: A pixel is NaN or infinite.
        """
        pose, lighting, lens = find_pose(pose), find_lighting(lighting), find_lens(lens)
        standpoint = find_standpoint(standpoint)
        if not ipd_px > 0 or scale < 1 or samples_per_pixel < 1 or seed < 0:
            raise InputError(
                f"ipd_px={ipd_px}, scale={scale}, samples_per_pixel={samples_per_pixel},"
                f" seed={seed}: give ipd_px > 0, scale >= 1, samples_per_pixel >= 1, seed >= 0"
            )
        if camera_m is not None and not camera_m > 0:
            raise InputError(f"camera_m={camera_m}: give a distance > 0, in metres")
        try:
            viewpoint = place_camera(
                head.pupils,
                ipd_px,
                offset_mm=pose.frame_offset_mm(),
                camera_m=standpoint.camera_m if camera_m is None else camera_m,
                above_m=standpoint.above_m,
            )
        except ValueError as error:
            raise InputError(f"standpoint {standpoint.name!r}: {error}; give another") from error
        image = expose(
            self._stage.show(head, lighting, pose),
            self._path(),
            viewpoint,
            pose,
            scale=scale,
            samples=max(round(samples_per_pixel / scale**2), MIN_SAMPLES),
            seed=seed,
            lens=lens,
            focus_mm=float(viewpoint.depth_mm(pose.turn(head.pupils)).mean()),
            bands=bands,
        )
        if not np.isfinite(image).all():
            raise NonFiniteError(
                f"head {head.identity_id}, pose {pose.name}, lighting {lighting.name}:"
                f" {int((~np.isfinite(image)).sum())} values are not finite"
            )
        landmarks = viewpoint.project(pose.turn(head.landmarks), scale)
        return Radiance(
            image=torch.from_numpy(np.ascontiguousarray(image.transpose(2, 0, 1))),
            landmarks_px=torch.from_numpy(landmarks.astype(np.float32)),
            ipd_px=float(ipd_px),
            scale=scale,
            metered=environment(lighting)[1],
            seed=seed,
            identity_id=head.identity_id,
            pose=pose.name,
            lighting=lighting.name,
            **_spectrum(lighting, bands),
        )

    def _path(self) -> Any:
        return self._stage.integrator(self.max_depth, ROULETTE_DEPTH)


def _spectrum(lighting: Lighting, bands: int) -> dict[str, Any]:
    """Return what a radiance of so many bands holds besides."""
    if not bands:
        return {}
    from lrsr.rendering.upsampling import meter_bands

    edges = band_edges(bands)
    return {"edges_nm": edges, "metered_bands": meter_bands(lighting, edges)}


@cache
def shared_renderer(skin: str = "reflective") -> Renderer:
    """Return the process's one renderer of that skin."""
    return Renderer(skin)


def render(head: Head, **settings: Any) -> Radiance:
    """Render one picture with the shared reflective renderer; see :meth:`Renderer.render`.

    Raises:
        InputError: No such pose or lighting, or a number out of range.
        NonFiniteError: A pixel is NaN or infinite.
    """
    return shared_renderer().render(head, **settings)
