"""A table is read as any program may have saved it, or refused by its line."""

from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.tables import read_rows


def rows(path: Path, content: bytes, *needed: str) -> list[tuple[int, dict[str, str]]]:
    path.write_bytes(content)
    return list(read_rows(path, needed or ("file",), "make one"))


@pytest.mark.parametrize(
    "content",
    [
        b"file,age\na.png,30\n",
        "\ufefffile;age\r\na.png;30\r\n".encode(),  # as Excel saves it
        "\ufefffile\tage\ra.png\t30\r".encode("utf-16"),
        b' file ,age\n\n"a.png","30"\n,\n\n',
    ],
    ids=["plain", "Excel", "UTF-16", "blanks"],
)
def test_whoever_saved_it_it_says_the_same(tmp_path: Path, content: bytes) -> None:
    ((_, cells),) = rows(tmp_path / "t.csv", content)
    assert cells == {"file": "a.png", "age": "30"}


def test_cells_that_are_missing_at_the_end_are_empty(tmp_path: Path) -> None:
    assert rows(tmp_path / "t.csv", b"file,age\na\n") == [(2, {"file": "a", "age": ""})]
    assert rows(tmp_path / "t.csv", b"file,age\n") == []


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "line 1: no column file among none; add it"),
        (b"name\nx\n", "line 1: no column file among name; add it"),
        (b"file,age,age\nx,1,2\n", "line 1: 2 columns age; rename one"),
        (b"file,age\nx,1\ny,2,3\n", "line 3: 3 cells for 2 columns"),
        (b'file\n"x\n', "line 2: unexpected end of data; make it again"),
        ("file\nü\n".encode("latin-1"), "save it as UTF-8"),
    ],
)
def test_what_is_wrong_is_told_with_its_place(tmp_path: Path, content: bytes, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        rows(tmp_path / "t.csv", content)
    assert str(tmp_path / "t.csv") in str(caught.value)


def test_a_table_that_is_not_there_is_told_with_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*gone\.csv: No such file.*; make one"):
        list(read_rows(tmp_path / "gone.csv", ("file",), "make one"))
