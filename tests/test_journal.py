from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.journal import Journal

ASKED = {"seed": 1, "steps": (1, 2)}


def test_what_is_noted_is_read_in_order(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "below" / "found.jsonl", ASKED)
    assert journal.read() == []
    for k in range(3):
        journal.note({"k": k})
    assert Journal(journal.path, ASKED).read() == [{"k": 0}, {"k": 1}, {"k": 2}]


def test_a_line_that_a_kill_cut_short_is_left_out(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "found.jsonl", ASKED)
    journal.note({"k": 0})
    journal.path.write_text(journal.path.read_text() + '\n{"k": ')
    journal.note({"k": 1})
    assert journal.read() == [{"k": 0}, {"k": 1}]


def test_a_first_line_that_a_full_disk_cut_short_is_written_again(tmp_path: Path) -> None:
    journal = Journal(tmp_path / "found.jsonl", ASKED)
    journal.path.write_text('\n{"seed": 1, "st')
    assert journal.read() == []
    journal.note({"k": 0})
    assert journal.read() == [{"k": 0}]


def test_other_settings_are_refused_by_name(tmp_path: Path) -> None:
    Journal(tmp_path / "found.jsonl", ASKED).note({"k": 0})
    with pytest.raises(InputError, match="holds what another seed made: choose another out"):
        Journal(tmp_path / "found.jsonl", ASKED | {"seed": 2}).read()


def test_a_file_that_cannot_be_read_or_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bytes.jsonl").write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match="cannot read"):
        Journal(tmp_path / "bytes.jsonl", ASKED).read()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        Journal(tmp_path / "file" / "found.jsonl", ASKED).note({})
