from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from lrsr.identities.day.haircut import _hair_length_mm, restyle
from lrsr.identities.head import Head

Make = Callable[..., Head]


class Face:
    """What the gate needs of a face at rest."""

    def __init__(self, head: Head) -> None:
        self.skin = head.part("skin").vertices
        self.eyes = self
        self.pupils = head.pupils


def restyled(head: Head, seed: int) -> tuple[dict[str, Any], str]:
    return restyle(head.parameters, Face(head), np.random.default_rng(seed))  # type: ignore[arg-type]


@pytest.mark.parametrize("index", [0, 1])
def test_cut_hair_is_shorter_grown_hair_longer_and_the_scalp_the_same(
    person: Make, index: int
) -> None:
    head = person(index)
    own: Any = head.parameters["hair"]
    seen = set()
    for seed in range(6):
        hair, way = restyled(head, seed)
        seen.add(way)
        longer = _hair_length_mm(hair) / _hair_length_mm(own)
        assert {"cut": longer < 0.7, "grown": longer > 1.45}.get(way, longer == 1)
        for name in ("hairline_deg", "recession_deg", "bald_deg", "hair_colour", "grey"):
            assert hair[name] == own[name]
    assert len(seen) > 1


def test_nobody_gets_back_what_they_have_lost(person: Make) -> None:
    head = person(1)
    bald: Any = {**head.parameters["hair"], "style": "horseshoe", "bald_deg": 50.0}  # type: ignore[dict-item]
    for seed in range(3):
        numbers = {**head.parameters, "hair": bald}
        hair, _ = restyle(numbers, Face(head), np.random.default_rng(seed))  # type: ignore[arg-type]
        assert hair["style"] in {"horseshoe", "shaved"}
        assert hair["bald_deg"] == 50.0
