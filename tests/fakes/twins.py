"""Painted people of whom some look like others, as the same paint with other noise."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from fakes.painted import PaintedMaker

from lrsr.evaluation.distinctness import Drawn
from lrsr.identities.head import Head
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.person import Person, Traits, _tone_of
from lrsr.pictures.recipe import Recipe
from lrsr.rendering.radiance import Radiance


class TwinMaker(PaintedMaker):
    """Paints whom it is told alike; says who everyone is, and notes whom it was asked for.

    Args:
        looks: Index and draw of a person, and the index of the person whose looks they have.
        patience: Renderings after which Ctrl-C is pressed; None: never.
    """

    def __init__(
        self, looks: Mapping[Drawn, int] | None = None, patience: int | None = None
    ) -> None:
        self.looks = dict(looks or {})
        self.patience = patience
        self.rendered: list[str] = []
        self.versions: Mapping[str, str] = {"painted": "1", "identities": RECIPE_VERSION}

    def render(self, head: Head, recipe: Recipe) -> Radiance:
        if self.patience == len(self.rendered):
            raise KeyboardInterrupt
        person = recipe.person
        self.rendered.append(person.id)
        own = person.index + 1000 * person.draw
        look = self.looks.get((person.index, person.draw), own)
        radiance = super().render(head, replace(recipe, person=replace(person, index=look)))
        return replace(radiance, traits=traits(person))


def traits(person: Person) -> Traits:
    """Say who somebody is: sex, age and what the gate did follow from the number; a redrawn one is
    a year older.
    """
    number = person.index
    ita_deg = 50.0 - 10.0 * (number % 10)
    ancestry = {"african": 0.1, "asian": 0.1, "caucasian": 0.8}
    sex = ("female", "male")[number % 2]
    age_years = 25.0 + number % 40 + person.draw
    return Traits(sex, age_years, ancestry, ita_deg, _tone_of(ita_deg), gate(number))


def gate(number: int) -> Mapping[str, Any]:
    """Say that one face in three was drawn again, for the first and perhaps a second reason."""
    reasons = ["eye: opening, mm", "hair: height of the edge on the forehead, mm"]
    failures = [] if number % 3 else [reasons[: 1 + number]]
    return {"redraws": len(failures), "failures": failures}
