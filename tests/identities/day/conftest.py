"""A few people as enrolled and on days that bring one thing each, made once."""

from collections.abc import Callable
from functools import cache
from typing import Any

import pytest
from fakes.scenes import DAYS, EXPRESSIONS

from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.identities.splits import identity_seed

Make = Callable[..., Head]


@cache
def _made(index: int, day: str, expression: str) -> Head:
    seed = identity_seed("test", index)
    worn: dict[str, Any] = {"another_day": DAYS[day], "expression": EXPRESSIONS[expression]}
    return sample_head(seed, texture_size=64, **worn)


@pytest.fixture(scope="session")
def person() -> Make:
    """Return who makes person ``index`` of the test split, that day, with that expression."""

    def make(index: int, day: str = "none", expression: str = "neutral") -> Head:
        return _made(index, day, expression)

    return make
