"""Tests of lrsr/experiments/set_trial.py; its runs are tested by those of the studies."""

from pathlib import Path

from lrsr.experiments.set_trial import people_of
from lrsr.pictures.folder import Entry
from lrsr.pictures.source import Photographs


def test_people_are_chosen_by_their_numbers() -> None:
    entries = [Entry("", f"{k:03d}") for k in (1, 43, 44, 87, 88)]
    assert people_of(Photographs(Path(), entries), [44, 87]) == {"044", "087"}
