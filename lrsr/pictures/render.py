"""Where do the pictures of an experiment come from? The cache, and the renderer for the rest."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import torch
from tqdm import tqdm

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.crew import People, missing_of, render_in_processes, render_people
from lrsr.pictures.maker import Maker, MitsubaMaker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.rendering.radiance import Radiance, spectrum_of

CHUNK = 64
"""Renderings held in memory at once on their way through the camera."""


def filmed(recipe: Recipe, camera: Camera) -> Recipe:
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
    film = recipe.film
    finer, bands = camera.supersampling, film.bands or camera.bands
    return replace(recipe, film=replace(film, scale=film.scale * finer, bands=bands))


def render_missing(
    recipes: Iterable[Recipe],
    cache: RenderCache,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> int:
    """Render what ``cache`` lacks (or holds damaged) and keep it there, one picture at a time.

    Stopped at any moment (Ctrl-C, kill -9), the next call goes on after the last finished picture.
    Several processes, of this command (``cache.processes``) and of others that fill the same cache,
    divide the people among themselves; whom another one has in hand is waited for at the end.

    Args:
        recipes: In any order; doubles are made once.
        cache: Receives every picture as soon as it is done.
        progress: Show a bar with an estimate of the time left, on stderr.
        maker: Builds and renders; Mitsuba when None.

    Returns:
        How many pictures were lacking.

    Raises:
        InputError: The cache cannot be written or the disk is full, or a process was killed.
    """
    maker = maker or MitsubaMaker()
    cache.sweep()
    missing = missing_of(recipes, cache, maker)
    if not missing:
        return 0
    by_head: dict[str, list[Recipe]] = {}
    for recipe in missing:
        worn = (recipe.scene.expression, recipe.scene.another_day)
        shown = (recipe.person, recipe.quality.texture_size, *worn)
        by_head.setdefault(repr(shown), []).append(recipe)
    people: People = by_head
    with tqdm(total=len(missing), desc="rendering", unit="image", disable=not progress) as bar:
        if min(cache.processes, len(people)) > 1:
            people = render_in_processes(people, cache, maker, bar.update)
        render_people(people, cache, maker, bar.update)
    return len(missing)


def load_radiances(
    recipes: Sequence[Recipe],
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
    maker = maker or MitsubaMaker()
    keys = [cache.key(recipe, maker.versions) for recipe in recipes]
    radiances = [cache.get(key) for key in keys]
    if any(radiance is None for radiance in radiances):
        render_missing(recipes, cache, progress=progress, maker=maker)
        radiances = [cache.get(key) for key in keys]
    found = [radiance for radiance in radiances if radiance is not None]
    if len(found) < len(recipes):
        raise InputError(f"cache folder {cache.folder} loses what is written to it: choose another")
    return found


def take_pictures(
    recipes: Sequence[Recipe],
    cache: RenderCache,
    camera: Camera,
    *,
    progress: bool = True,
    maker: Maker | None = None,
) -> list[Picture]:
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
    pictures: list[Picture] = []
    for start in range(0, len(recipes), CHUNK):
        chunk = recipes[start : start + CHUNK]
        films = [filmed(recipe, camera) for recipe in chunk]
        radiances = load_radiances(films, cache, progress=progress, maker=maker)
        pictures += _photograph(chunk, radiances, camera)
    return pictures


def _photograph(
    recipes: Sequence[Recipe], radiances: Sequence[Radiance], camera: Camera
) -> list[Picture]:
    """Send light through the camera, images of one size together; there is no gradient.

    Raises:
        InputError: A film is not as fine as the camera wants it.
    """
    finer = camera.supersampling
    alike: dict[object, list[int]] = {}
    for i, radiance in enumerate(radiances):
        if radiance.scale % finer:
            raise InputError(
                f"a film of scale {radiance.scale} in camera {camera.name!r}: wanted {finer} times "
                "the picture's"
            )
        alike.setdefault((radiance.image.shape, radiance.edges_nm), []).append(i)
    images: dict[int, torch.Tensor] = {}
    for members in alike.values():
        linear = torch.stack([radiances[i].image for i in members])
        metered = torch.tensor([radiances[i].metered for i in members])
        seeds = [recipes[i].seed for i in members]
        spectrum = spectrum_of([radiances[i] for i in members])
        with torch.no_grad():
            images |= dict(zip(members, camera(linear, metered, seeds, spectrum), strict=True))
    return [
        Picture(
            image=images[i].clone(),
            identity_id=recipe.person.id,
            landmarks_px=camera.place_points(
                radiance.landmarks_px, (radiance.image.shape[-2], radiance.image.shape[-1])
            ),
            source=f"rendered: {recipe.scene.pose.name}, {recipe.scene.lighting.name}",
            scale=radiance.scale // finer,
            traits=radiance.traits,
        )
        for i, (recipe, radiance) in enumerate(zip(recipes, radiances, strict=True))
    ]
