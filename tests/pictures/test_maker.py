"""The real maker hands a recipe to the identities and the renderer, once a head and a skin."""

import sys
from dataclasses import replace
from types import ModuleType, SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch

from lrsr.data.maker import MitsubaMaker, mitsuba_maker
from lrsr.data.recipe import ProbeRecipe
from lrsr.identities.head import Head
from lrsr.identities.person import Person
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import identity_seed
from lrsr.rendering.radiance import Radiance

RECIPE = ProbeRecipe("test", 5, pose="left", ipd_px=9.0, scale=2, seed=3, texture_size=64)
SOMEBODY = Person("female", 40.0, {"asian": 1.0}, 30.0, "intermediate")


class Renderer:
    made: list[tuple[str, int]]
    asked: list[dict[str, Any]]

    def __init__(self, skin: str, *, max_depth: int) -> None:
        self.made.append((skin, max_depth))

    def render(self, head: Head, **settings: Any) -> Radiance:
        self.asked.append(settings)
        light = torch.zeros(3, 4, 4), torch.zeros(5, 2)
        return Radiance(*light, 8.0, 1, 1.0, 3, head.identity_id, "left", "frontal")


@pytest.fixture(autouse=True)
def _parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Stand-ins for the modules that build and render; their own tests are elsewhere."""
    Renderer.made, Renderer.asked = [], []

    def sample_head(
        seed: int, *, texture_size: int, population: Population, expression: str
    ) -> Head:
        numbers = {"seed": seed, "texture_size": texture_size, "population": population}
        numbers["expression"] = expression
        return Head("seed-x", (), np.zeros((2, 3)), np.zeros((5, 3)), numbers)

    parts: dict[str, dict[str, Any]] = {
        "lrsr.identities.morphable": {"RECIPE_VERSION": "a", "sample_head": sample_head},
        "lrsr.rendering.renderer": {
            "RENDERER_VERSION": "b",
            "SPECTRA_VERSION": "d",
            "Renderer": Renderer,
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
        "expression": "neutral",
    }


def test_a_head_wears_the_expression_of_the_recipe() -> None:
    head = MitsubaMaker().head(replace(RECIPE, expression="smile"))
    assert (head.identity_id, head.parameters["expression"]) == ("test-00005", "smile")


def test_a_redrawn_head_has_another_seed_and_its_population() -> None:
    women = Population("female")
    head = MitsubaMaker().head(replace(RECIPE, draw=2, population=women))
    assert head.identity_id == "test-00005-female-draw2"
    assert head.parameters["seed"] == identity_seed("test", 5, draw=2)
    assert head.parameters["population"] == women


def test_everything_the_recipe_says_reaches_the_renderer() -> None:
    maker = MitsubaMaker()
    radiance = maker.render(maker.head(RECIPE), RECIPE)
    assert (radiance.identity_id, radiance.person) == ("test-00005", SOMEBODY)
    (asked,) = Renderer.asked
    assert asked == {
        "pose": "left",
        "lighting": "frontal",
        "ipd_px": 9.0,
        "scale": 2,
        "samples_per_pixel": 2048,
        "seed": 3,
        "lens": "pinhole",
        "standpoint": "level",
        "bands": 0,
    }


def test_one_renderer_serves_all_pictures_of_a_skin() -> None:
    maker = MitsubaMaker()
    head = maker.head(RECIPE)
    for depth in (5, 5, 8, 5):
        maker.render(head, ProbeRecipe("test", 5, max_depth=depth))
    assert Renderer.made == [("reflective", 5), ("reflective", 8)]


def test_a_process_has_one_maker() -> None:
    assert mitsuba_maker() is mitsuba_maker()
