"""Who turns a recipe into light? A maker; the real one is Mitsuba, tests bring a quick one."""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

from lrsr.pictures.recipe import Recipe

if TYPE_CHECKING:
    from lrsr.identities.head import Head
    from lrsr.rendering.radiance import Radiance
    from lrsr.rendering.survey import Survey


class Maker(Protocol):
    """Builds heads and renders them; what it makes depends on the recipe and its versions alone."""

    @property
    def versions(self) -> Mapping[str, str]:
        """Versions of everything that changes pixels; part of every key of the cache."""

    def head(self, recipe: Recipe) -> "Head":
        """Build the person of ``recipe``; called in a thread of its own."""

    def render(self, head: "Head", recipe: Recipe) -> "Radiance":
        """Render ``head`` as ``recipe`` says; called in the main thread."""


class Surveyor(Maker, Protocol):
    """A maker that also knows what lies behind each pixel."""

    def survey(self, head: "Head", recipe: Recipe) -> "Survey":
        """Look at ``head`` as ``recipe`` says; called in the main thread."""


class MitsubaMaker:
    """The procedural heads of :mod:`lrsr.identities`, rendered by :mod:`lrsr.rendering`."""

    @cached_property
    def versions(self) -> Mapping[str, str]:
        """Versions of the identities, of the renderer and of Mitsuba's variant: looked up once."""
        from lrsr.identities.morphable import RECIPE_VERSION
        from lrsr.rendering.backend import choose_variant
        from lrsr.rendering.renderer import RENDERER_VERSION, SPECTRA_VERSION

        variant = choose_variant().variant
        return {
            "identities": RECIPE_VERSION,
            "renderer": RENDERER_VERSION,
            "variant": variant,
            **({"spectra": SPECTRA_VERSION} if variant.endswith("spectral") else {}),
        }

    def head(self, recipe: Recipe) -> "Head":
        """Build the person of ``recipe``, under the name that the split gives."""
        scene, size = recipe.scene, recipe.quality.texture_size
        return recipe.person.head(scene.expression, size, scene.another_day)

    def render(self, head: "Head", recipe: Recipe) -> "Radiance":
        """Render with the one renderer of that skin model, whose scene is updated in place."""
        from lrsr.identities.person import Person, describe
        from lrsr.rendering.renderer import shared_renderer

        quality = recipe.quality
        radiance = shared_renderer(quality.skin, quality.max_depth).render(
            head,
            recipe.scene,
            recipe.film,
            samples_per_pixel=quality.samples_per_pixel,
            seed=recipe.seed,
        )
        drawn = isinstance(recipe.person, Person)  # of the photographed nobody knows it
        return replace(radiance, traits=describe(head) if drawn else None)

    def survey(self, head: "Head", recipe: Recipe) -> "Survey":
        """Say what lies behind each pixel of that picture."""
        from lrsr.rendering.renderer import shared_renderer

        quality = recipe.quality
        renderer = shared_renderer(quality.skin, quality.max_depth)
        return renderer.survey(head, recipe.scene, recipe.film)
