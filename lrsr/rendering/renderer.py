"""From a head, a pose and a lighting to the light on the film."""

from functools import cache
from typing import Any

import numpy as np
import torch

from lrsr.errors import InputError, NonFiniteError
from lrsr.identities.head import Head
from lrsr.presets import preset
from lrsr.rendering.backend import alone
from lrsr.rendering.environment import environment
from lrsr.rendering.exposure import expose
from lrsr.rendering.geometry import Viewpoint, place_camera
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.live_scene import LiveScene
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import FEWEST_ON_FINE, Film, Quality, Scene
from lrsr.rendering.skin import REFLECTIVE, Skin
from lrsr.rendering.spectral_upsampling import meter_bands
from lrsr.rendering.survey import Survey, survey
from lrsr.spectra import band_edges

RENDERER_VERSION = "3"
"""Changes whenever the same head would give other pixels."""

SPECTRA_VERSION = "1"
"""Changes whenever it would do so only in variants that trace wavelengths."""

_ROULETTE_DEPTH = 2
"""From which bounce on dim paths may end by chance: a third less time, 7 % more noise."""


class Renderer:
    """Renders heads; keeps its scene and its compiled kernels between calls.

    Args:
        skin: How light meets skin.
        max_depth: Longest path, in edges from the camera, >= 2; volumetric skin knows no limit.
    """

    def __init__(self, skin: Skin = REFLECTIVE, *, max_depth: int = 5) -> None:
        self.max_depth = max_depth
        self._live = LiveScene(skin)

    @alone()
    def render(
        self,
        head: Head,
        scene: Scene,
        film: Film,
        *,
        samples_per_pixel: int,
        seed: int = 0,
        camera_m: float | None = None,
    ) -> Radiance:
        """Render one picture.

        Args:
            head: Who; already wears the scene's expression.
            scene: Pose, lighting, lens and standpoint. A lens is focused on the eyes, unless it
                says otherwise.
            film: Bands need a variant that traces wavelengths.
            samples_per_pixel: Of the ×1 film; a finer one has 1/scale² of them, but 16 or as many.
            seed: Of the sampler, >= 0.
            camera_m: Distance of the camera, m; None: what the standpoint says, or where the
                reference camera must stand.

        Returns:
            The linear picture with its landmarks.

        Raises:
            InputError: A number out of range, bands of a variant that traces colours, or a place
                from which the camera cannot see the face.
            NonFiniteError: A pixel is NaN or infinite.
        """
        if samples_per_pixel < 1 or seed < 0 or not (camera_m is None or camera_m > 0):
            raise InputError(
                f"samples_per_pixel={samples_per_pixel}, seed={seed}, camera_m={camera_m}: give"
                " samples_per_pixel >= 1, seed >= 0, camera_m > 0"
            )
        pose, viewpoint = scene.pose, viewpoint_of(head, scene, film, camera_m)
        image = expose(
            self._live.show(head, scene.lighting, pose),
            self._path(),
            viewpoint,
            pose,
            scale=film.scale,
            samples=_samples(samples_per_pixel, film.scale),
            seed=seed,
            lens=scene.lens,
            focus_mm=float(viewpoint.depth_mm(pose.turn(head.pupils)).mean()),
            bands=film.bands,
        )
        if not np.isfinite(image).all():
            raise NonFiniteError(
                f"head {head.identity_id}, pose {pose.name}, lighting {scene.lighting.name}:"
                f" {int((~np.isfinite(image)).sum())} values are not finite"
            )
        landmarks = viewpoint.project(pose.turn(head.landmarks), film.scale)
        return Radiance(
            image=torch.from_numpy(np.ascontiguousarray(image.transpose(2, 0, 1))),
            landmarks_px=torch.from_numpy(landmarks.astype(np.float32)),
            ipd_px=film.ipd_px / (1 - film.nearer),
            scale=film.scale,
            metered=environment(scene.lighting)[1],
            **_spectrum(scene.lighting, film.bands),
        )

    @alone()
    def survey(self, head: Head, scene: Scene, film: Film) -> Survey:
        """Say what lies behind each pixel of the picture that :meth:`render` makes of the same.

        Args:
            head: Who; already wears the scene's expression.
            scene: As for the picture; light does not matter.
            film: Its bands do not matter.

        Raises:
            InputError: The lens is no pinhole, or the camera cannot see the face from there.
        """
        if not scene.lens.is_pinhole:
            raise InputError(
                f"lens={scene.lens.name}: what lies behind a pixel is told of lens=pinhole"
            )
        viewpoint = viewpoint_of(head, scene, film)
        live = self._live.show(head, scene.lighting, scene.pose)
        names = [part.name for part in head.parts]
        return survey(live, names, viewpoint, scene.pose, film.scale)

    def _path(self) -> Any:
        return self._live.integrator(self.max_depth, _ROULETTE_DEPTH)


def viewpoint_of(head: Head, scene: Scene, film: Film, camera_m: float | None = None) -> Viewpoint:
    """Place the camera.

    Raises:
        InputError: It cannot see the face from there.
    """
    standpoint = scene.standpoint
    try:
        return place_camera(
            head.pupils,
            film.ipd_px,
            offset_mm=scene.pose.frame_offset_mm(),
            camera_m=standpoint.camera_m if camera_m is None else camera_m,
            above_m=standpoint.above_m,
            nearer=film.nearer,
            shift_px=film.shift_px,
        )
    except ValueError as error:
        raise InputError(f"standpoint {standpoint.name!r}: {error}; give another") from error


def _samples(samples_per_pixel: int, scale: int) -> int:
    """Return how many each pixel of a film has."""
    return max(round(samples_per_pixel / scale**2), min(samples_per_pixel, FEWEST_ON_FINE))


def _spectrum(lighting: Lighting, bands: int) -> dict[str, Any]:
    """Return what a radiance of so many bands holds besides."""
    if not bands:
        return {}
    edges = band_edges(bands)
    return {"edges_nm": edges, "metered_bands": meter_bands(lighting, edges)}


@alone()
@cache
def shared_renderer(skin: Skin, max_depth: int) -> Renderer:
    """Return the process's one renderer of that skin: its scene and kernels are used again."""
    return Renderer(skin, max_depth=max_depth)


def render(
    head: Head,
    *,
    pose: str = "frontal",
    lighting: str = "frontal",
    lens: str = "pinhole",
    standpoint: str = "level",
    skin: str = "reflective",
    ipd_px: float = 8.0,
    scale: int = 1,
    bands: int = 0,
    samples_per_pixel: int = 512,
    max_depth: int = 5,
    seed: int = 0,
) -> Radiance:
    """Render one picture from names of presets, for notebooks; :class:`Renderer` takes values.

    Args:
        head: Who.
        pose: Name of a file in ``conf/pose``, as the next ones in their groups.
        lighting: Name.
        lens: Name.
        standpoint: Name.
        skin: Name in ``conf/rendering/skin``.
        ipd_px: See :class:`lrsr.rendering.scene.Film`, as the next two.
        scale: How many times finer than the ×1 film: 1, 2, 3 or 4.
        bands: Spectral bands; 0: three colours.
        samples_per_pixel: Of the ×1 film, at this very size.
        max_depth: Longest light path.
        seed: Of the sampler.

    Raises:
        InputError: No such preset, or a number out of range.
        NonFiniteError: A pixel is NaN or infinite.
    """
    scene = Scene(
        lighting=preset("lighting", lighting),
        pose=preset("pose", pose),
        lens=preset("lens", lens),
        standpoint=preset("standpoint", standpoint),
    )
    quality = Quality(samples_per_pixel, max_depth, skin=preset("rendering/skin", skin))
    renderer = shared_renderer(quality.skin, quality.max_depth)
    film = Film(ipd_px, scale, bands)
    return renderer.render(
        head, scene, film, samples_per_pixel=quality.samples_per_pixel, seed=seed
    )
