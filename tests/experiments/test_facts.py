"""Tests of lrsr/experiments/facts.py; how the section is read, test_case.py tries."""

from pathlib import Path
from typing import Any

import pytest

from lrsr.errors import InputError
from lrsr.experiments.facts import Facts
from lrsr.experiments.pair import Pair

PAIR = Pair(Path("a"), Path("b"))


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"score": 1, "pair": PAIR}, r"case\.score=1: wanted null where case\.probe is given"),
        ({"generic_scores": Path("x")}, r"case\.generic_scores=x: wanted case\.scores besides"),
        ({"scores": Path("x"), "images": Path("y")}, r"case\.images=.*: wanted null where"),
        ({"scores": Path("x"), "pair": PAIR}, r"case\.pair=.*: wanted null where"),
    ],
)
def test_facts_that_exclude_each_other_are_refused(given: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Facts(**given)


def test_nothing_need_be_known() -> None:
    assert Facts() == Facts(None, 0.75, 12)
