"""Tests of lrsr/experiments/labels.py."""

from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.experiments.labels import labels_of_entry, read_labels
from lrsr.pictures.folder import Entry


def test_a_manifest_and_a_plain_table_are_read(tmp_path: Path) -> None:
    path = tmp_path / "people.csv"
    path.write_text(
        "file,identity_id,sex,age_years,ancestry,skin_tone\n"
        "a.png,a,female,34.5,african=0.1 asian=0.9,light\nb.png,b,,,caucasian,\n"
        "c.png,c,male,17,african=0.4 asian=0.3 caucasian=0.3,dark\n"
    )
    assert read_labels(path) == {
        "a": {"sex": "female", "age": "30 to 39", "ancestry": "asian", "skin tone": "light"},
        "b": {"ancestry": "caucasian"},
        "c": {"sex": "male", "ancestry": "mixed", "skin tone": "dark"},
    }


def test_an_entry_of_a_manifest_has_the_same_groups() -> None:
    entry = Entry("a.png", "a", sex="male", age_years="50", ancestry="asian=1")
    assert labels_of_entry(entry) == {"sex": "male", "age": "50 to 59", "ancestry": "asian"}
    assert labels_of_entry(Entry("a.png", "a", age_years="old")) == {}


def test_an_age_that_is_no_number_is_told_with_its_line(tmp_path: Path) -> None:
    path = tmp_path / "people.csv"
    path.write_text("identity_id,age_years\na,30\nb,old\n")
    with pytest.raises(InputError, match="line 3: age_years=old"):
        read_labels(path)


def test_a_table_of_something_else_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "people.csv"
    path.write_text("name,sex\na,male\n")
    with pytest.raises(InputError, match="no column identity_id among name, sex; add it"):
        read_labels(path)
    path.write_text("identity_id,eyes\na,blue\n")
    with pytest.raises(InputError, match="line 1: wanted some of the columns sex, age_years"):
        read_labels(path)
    with pytest.raises(InputError, match="cannot read"):
        read_labels(tmp_path)
