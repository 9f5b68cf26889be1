"""Tests of lrsr/experiments/intake.py with a network that finds a face on everything."""

import csv
import json
from collections.abc import Iterator
from pathlib import Path

import pytest
from fakes.reconstructions import pretended
from fakes.sets import write_face

from lrsr.experiments.intake import Intake, Told, write_people
from lrsr.identities.photographs.person import read_photographed
from lrsr.identities.photographs.quality import Filters
from lrsr.pictures.cache import RenderCache


@pytest.fixture
def made() -> Iterator[list[str]]:
    """List who was reconstructed; the one on file 3 wears glasses."""
    with pretended(glasses="3") as found:
        yield found


def look(folder: Path, filters: Filters, **refused: str) -> list[Told]:
    sources = {folder / f"{number}.jpg": f"person {number}" for number in (1, 2, 3)}
    for number, source in enumerate(sources, start=1):
        write_face(source, number, 96)
    told = Intake(filters).look(
        sources,
        RenderCache(folder / "cache"),
        refused={folder / f"{name[1:]}.jpg": why for name, why in refused.items()},
        progress=False,
    )
    return list(told)


def test_what_was_found_on_a_photograph_is_remembered(tmp_path: Path, made: list[str]) -> None:
    strict = Filters(most_glasses_edge=100.0)
    first = look(tmp_path, strict)
    assert [one["filter"] for one in first] == ["", "", "glasses"]
    assert [one["who"] for one in first] == ["person 1", "person 2", "person 3"]
    assert look(tmp_path, strict) == first
    assert made == ["1", "2", "3"]
    assert [one["filter"] for one in look(tmp_path, Filters())] == ["", "", ""]  # other settings
    assert len(made) == 6


def test_a_damaged_memory_is_made_again(tmp_path: Path, made: list[str]) -> None:
    first = look(tmp_path, Filters())
    for path in (tmp_path / "cache").rglob("*.json"):
        path.write_text("{")
    assert look(tmp_path, Filters()) == first
    assert len(made) == 6


def test_who_is_refused_beforehand_is_not_looked_at(tmp_path: Path, made: list[str]) -> None:
    found = look(tmp_path, Filters(), _2="17 years old")
    assert (found[1]["filter"], found[1]["why"]) == ("adult", "17 years old")
    assert made == ["1", "3"]


@pytest.mark.usefixtures("made")
def test_people_and_a_table_of_all_photographs_are_written(tmp_path: Path) -> None:
    write_people(tmp_path, look(tmp_path, Filters(most_glasses_edge=100.0)))
    assert [one.id for one in read_photographed(tmp_path)] == ["person 1", "person 2"]
    with (tmp_path / "photographs.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [(row["who"], row["taken"]) for row in rows] == [
        ("person 1", "yes"),
        ("person 2", "yes"),
        ("person 3", "no"),
    ]
    (refused,) = json.loads((tmp_path / "people.json").read_text())["refused"]
    assert refused["filter"] == "glasses"
    assert refused["why"] == rows[2]["why"]
