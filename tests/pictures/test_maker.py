"""The real maker hands a recipe to the identities and the renderer, once a head and a skin."""

import sys
from dataclasses import replace
from functools import cache
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from fakes.scenes import EXPRESSIONS, SKINS, recipe, scene

from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.head import Head
from lrsr.identities.person import Traits
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import identity_seed
from lrsr.pictures.maker import MitsubaMaker
from lrsr.rendering.radiance import Radiance
from lrsr.rendering.scene import Film, Scene
from lrsr.rendering.skin import REFLECTIVE, Skin

RECIPE = recipe(5, pose="left", ipd_px=9.0, scale=2, seed=3, texture_size=64)
SOMEBODY = Traits("female", 40.0, {"asian": 1.0}, 30.0, "intermediate")


class Renderer:
    made: list[tuple[Skin, int]]
    asked: list[tuple[Scene, Film, dict[str, Any]]]

    def __init__(self, skin: Skin, *, max_depth: int) -> None:
        self.made.append((skin, max_depth))

    def render(self, head: Head, scene: Scene, film: Film, **settings: Any) -> Radiance:
        self.asked.append((scene, film, settings))
        return Radiance(torch.zeros(3, 4, 4), torch.zeros(5, 2), 8.0, 1, 1.0)


@pytest.fixture(autouse=True)
def _parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand-ins for the modules that build and render; their own tests are elsewhere."""
    Renderer.made, Renderer.asked = [], []

    def sample_head(
        seed: int,
        *,
        texture_size: int,
        population: Population,
        expression: Expression,
        another_day: AnotherDay,
    ) -> Head:
        numbers = {"seed": seed, "texture_size": texture_size, "population": population}
        numbers |= {"expression": expression, "another_day": another_day}
        return Head("seed-x", (), np.zeros((2, 3)), np.zeros((5, 3)), numbers)

    parts: dict[str, dict[str, Any]] = {
        "lrsr.identities.morphable": {"RECIPE_VERSION": "a", "sample_head": sample_head},
        "lrsr.rendering.renderer": {
            "RENDERER_VERSION": "b",
            "SPECTRA_VERSION": "d",
            "shared_renderer": cache(lambda skin, depth: Renderer(skin, max_depth=depth)),
        },
        "lrsr.rendering.backend": {"choose_variant": lambda: SimpleNamespace(variant="c")},
    }
    monkeypatch.setattr("lrsr.identities.person.describe", lambda head: SOMEBODY)
    for name, contents in parts.items():
        module = ModuleType(name)
        vars(module).update(contents)
        monkeypatch.setitem(sys.modules, name, module)


def test_the_versions_are_those_of_all_that_changes_pixels() -> None:
    assert MitsubaMaker().versions == {"identities": "a", "renderer": "b", "variant": "c"}


def test_variants_that_trace_wavelengths_have_a_version_more(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    backend = sys.modules["lrsr.rendering.backend"]
    variant = SimpleNamespace(variant="llvm_ad_spectral")
    monkeypatch.setattr(backend, "choose_variant", lambda: variant)
    assert MitsubaMaker().versions["spectra"] == "d"


def test_a_head_has_the_seed_of_its_split_and_the_name_of_the_recipe() -> None:
    head = MitsubaMaker().head(RECIPE)
    assert head.identity_id == "test-00005"
    assert head.parameters == {
        "seed": 3 * 5 + 2,
        "texture_size": 64,
        "population": EVERYBODY,
        "expression": NEUTRAL,
        "another_day": SAME_DAY,
    }


def test_a_head_wears_the_expression_of_the_recipe() -> None:
    head = MitsubaMaker().head(replace(RECIPE, scene=scene(expression="smile")))
    assert head.identity_id == "test-00005"
    assert head.parameters["expression"] == EXPRESSIONS["smile"]


def test_a_redrawn_head_has_another_seed_and_its_population() -> None:
    women = Population("female")
    head = MitsubaMaker().head(recipe(5, draw=2, population=women))
    assert head.identity_id == "test-00005-female-draw2"
    assert head.parameters["seed"] == identity_seed("test", 5, draw=2)
    assert head.parameters["population"] == women


def test_everything_the_recipe_says_reaches_the_renderer() -> None:
    maker = MitsubaMaker()
    radiance = maker.render(maker.head(RECIPE), RECIPE)
    assert radiance.traits == SOMEBODY
    assert Renderer.asked == [
        (scene(pose="left"), Film(9.0, 2), {"samples_per_pixel": 2048, "seed": 3})
    ]


def test_one_renderer_serves_all_pictures_of_a_skin() -> None:
    maker = MitsubaMaker()
    head = maker.head(RECIPE)
    for depth in (5, 5, 8, 5):
        maker.render(head, recipe(5, max_depth=depth))
    maker.render(head, recipe(5, skin="subsurface"))
    assert Renderer.made == [(REFLECTIVE, 5), (REFLECTIVE, 8), (SKINS["subsurface"], 5)]
