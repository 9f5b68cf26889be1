"""Where do the pictures of an experiment come from? The cache, and the renderer for the rest."""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import torch
from tqdm import tqdm

from lrsr.camera import Camera
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker, mitsuba_maker
from lrsr.data.recipe import ProbeRecipe
from lrsr.errors import InputError
from lrsr.identities.face.expression import find_expression
from lrsr.identities.person import Person
from lrsr.rendering.radiance import Radiance, spectrum_of

if TYPE_CHECKING:
    from lrsr.identities.head import Head

__all__ = [
    "Probe",
    "ProbeRecipe",
    "filmed",
    "load_probes",
    "load_radiances",
    "photograph",
    "render_missing",
    "stack",
]

_CHUNK = 64
"""Renderings held in memory at once on their way through the camera."""


@dataclass(frozen=True)
class Probe:
    """One picture that a camera has taken, and what is known of it.

    Attributes:
        image: ``(3, H, W)`` float32, srgb, [0, 1], multiples of 1/255.
        landmarks_px: ``(5, 2)`` float32, (x, y) in pixels of ``image``, the order of
            :data:`lrsr.identities.head.LANDMARK_NAMES`.
        ipd_px: Interpupillary distance of the frontal face on the ×1 film, px.
        scale: How many times finer than the ×1 film.
        identity_id: Who it is.
        pose: Name.
        lighting: Name.
        compression: Name.
        camera: Name of the preset.
        seed: Of the sampler.
        kind: "probe" or "gallery".
        person: What is recorded of who it shows, where it is known.
    """

    image: torch.Tensor
    landmarks_px: torch.Tensor
    ipd_px: float
    scale: int
    identity_id: str
    pose: str
    lighting: str
    compression: str
    camera: str
    seed: int
    kind: str
    person: Person | None = None


def filmed(recipe: ProbeRecipe, camera: Camera) -> ProbeRecipe:
    """Return what is rendered for a picture: the film of a camera with a lens is finer.

    That of a camera with measured filters holds spectral bands. The sampler keeps its seed. Nothing
    else of the camera changes what is rendered.

    Args:
        recipe: Of the picture.
        camera: Takes it.

    Raises:
        InputError: No film is that fine: references of a camera with a lens are taken by
            :meth:`lrsr.camera.Camera.clean`.
    """
    finer, bands = camera.supersampling, recipe.bands or camera.bands
    if finer == 1 and bands == recipe.bands:
        return recipe
    return replace(recipe, scale=recipe.scale * finer, bands=bands)


def render_missing(
    recipes: Iterable[ProbeRecipe],
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> int:
    """Render what ``cache`` lacks (or holds damaged) and keep it there, one picture at a time.

    Each head is built once, in a second thread while the one before is being rendered. Stopped at
    any moment (Ctrl-C, kill -9), the next call goes on after the last finished picture.

    Args:
        recipes: In any order; doubles are made once.
        cache: Receives every picture as soon as it is done.
        progress: Show a bar with an estimate of the time left, on stderr.
        maker: Builds and renders; Mitsuba when None.

    Returns:
        How many pictures were rendered.

    Raises:
        InputError: The cache cannot be written or the disk is full.
    """
    maker = maker or mitsuba_maker()
    cache.sweep()
    versions = maker.versions
    keyed = {cache.key(recipe.plain(versions)): recipe for recipe in recipes}
    missing = {key: recipe for key, recipe in keyed.items() if cache.get(key) is None}
    if not missing:
        return 0
    people: dict[tuple[object, ...], list[str]] = {}
    for key, recipe in missing.items():
        shown = (recipe.identity_id, recipe.texture_size, find_expression(recipe.expression))
        people.setdefault(shown, []).append(key)
    firsts = [missing[keys[0]] for keys in people.values()]
    with tqdm(total=len(missing), desc="rendering", unit="image", disable=not progress) as bar:
        for head, keys in zip(_heads(maker, firsts), people.values(), strict=True):
            for key in keys:
                cache.put(key, maker.render(head, missing[key]))
                bar.update()
    return len(missing)


def _heads(maker: Maker, recipes: Sequence[ProbeRecipe]) -> Iterator["Head"]:
    """Build one head ahead of the one that is being rendered."""
    builder = ThreadPoolExecutor(max_workers=1, thread_name_prefix="lrsr-head")
    try:
        coming = builder.submit(maker.head, recipes[0])
        for following in [*recipes[1:], None]:
            head = coming.result()
            if following is not None:
                coming = builder.submit(maker.head, following)
            yield head
    finally:
        builder.shutdown(wait=False, cancel_futures=True)


def load_radiances(
    recipes: Sequence[ProbeRecipe],
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> list[Radiance]:
    """Return the light of each recipe, in their order; what is not rendered yet is rendered.

    Args:
        recipes: Sizes may differ; all are held in memory at once.
        cache: Where renderings are kept.
        progress: Show a bar while rendering.
        maker: Renders what is missing; Mitsuba when None.

    Raises:
        InputError: The cache cannot be read or written, or loses what is written to it.
    """
    maker = maker or mitsuba_maker()
    keys = [cache.key(recipe.plain(maker.versions)) for recipe in recipes]
    radiances = [cache.get(key) for key in keys]
    if any(radiance is None for radiance in radiances):
        render_missing(recipes, cache, progress=progress, maker=maker)
        radiances = [cache.get(key) for key in keys]
    found = [radiance for radiance in radiances if radiance is not None]
    if len(found) < len(recipes):
        raise InputError(f"cache folder {cache.folder} loses what is written to it: choose another")
    return found


def load_probes(
    recipes: Sequence[ProbeRecipe],
    cache: RenderCache,
    camera: Camera,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> list[Probe]:
    """Take one picture for each recipe, in their order; what is not rendered yet is rendered.

    Args:
        recipes: What to show; sizes may differ. For a camera with a lens their films are finer.
        cache: Where renderings are kept.
        camera: Takes the pictures; not trained through (no gradient). The seed of a picture's
            noise is that of its sampler.
        progress: Show a bar while rendering.
        maker: Renders what is missing; Mitsuba when None.

    Raises:
        InputError: The cache cannot be read or written, or loses what is written to it.
    """
    probes: list[Probe] = []
    for start in range(0, len(recipes), _CHUNK):
        chunk = recipes[start : start + _CHUNK]
        films = [filmed(recipe, camera) for recipe in chunk]
        radiances = load_radiances(films, cache, progress=progress, maker=maker)
        probes += photograph(radiances, camera, [recipe.kind for recipe in chunk])
    return probes


def photograph(radiances: Sequence[Radiance], camera: Camera, kinds: Sequence[str]) -> list[Probe]:
    """Send light through the camera, images of one size together; there is no gradient.

    Args:
        radiances: Of any sizes, on films as fine as the camera wants them (:func:`filmed`).
        camera: Takes the pictures; a radiance's seed is that of its picture's noise.
        kinds: "probe" or "gallery", one for each.

    Raises:
        InputError: A film is not as fine as the camera wants it.
    """
    finer = camera.supersampling
    for radiance in radiances:
        if radiance.scale % finer:
            raise InputError(
                f"a film of scale {radiance.scale} in camera {camera.name!r}: wanted {finer} times "
                "the picture's"
            )
    alike: dict[object, list[int]] = {}
    for i, radiance in enumerate(radiances):
        alike.setdefault((radiance.image.shape, radiance.edges_nm), []).append(i)
    images: dict[int, torch.Tensor] = {}
    for members in alike.values():
        linear = torch.stack([radiances[i].image for i in members])
        metered = torch.tensor([radiances[i].metered for i in members])
        with torch.no_grad():
            seeds = [radiances[i].seed for i in members]
            spectrum = spectrum_of([radiances[i] for i in members])
            srgb = camera(linear, metered, seeds, spectrum)
            images |= dict(zip(members, srgb, strict=True))
    return [
        Probe(
            image=images[i].clone(),
            landmarks_px=camera.place_points(radiance.landmarks_px, _size(radiance)),
            ipd_px=radiance.ipd_px,
            scale=radiance.scale // finer,
            identity_id=radiance.identity_id,
            pose=radiance.pose,
            lighting=radiance.lighting,
            compression=camera.compression,
            camera=camera.name,
            seed=radiance.seed,
            kind=kind,
            person=radiance.person,
        )
        for i, (radiance, kind) in enumerate(zip(radiances, kinds, strict=True))
    ]


def _size(radiance: Radiance) -> tuple[int, int]:
    return radiance.image.shape[-2], radiance.image.shape[-1]


def stack(probes: Sequence[Probe]) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the images ``(B, 3, H, W)`` and landmarks ``(B, 5, 2)`` of probes of one size.

    Raises:
        InputError: The sizes differ, or there are none.
    """
    sizes = sorted({tuple(probe.image.shape[1:]) for probe in probes})
    if len(sizes) != 1:
        raise InputError(f"probes of sizes {sizes} make no batch: wanted one size")
    images = torch.stack([probe.image for probe in probes])
    return images, torch.stack([probe.landmarks_px for probe in probes])
