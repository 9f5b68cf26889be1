"""Tests of lrsr/pictures/set_lists.py."""

from pathlib import Path

import numpy as np
import pytest
from fakes.sets import cells, write_face, write_listing
from scipy.io import savemat

from lrsr.errors import InputError
from lrsr.pictures.set_lists import photographs_of, read_listing, read_pairs


@pytest.mark.parametrize("files", [{"b.jpg": 7, "a.jpg": 300}, {"one.jpg": 1}], ids=["two", "one"])
def test_a_listing_keeps_its_order(tmp_path: Path, files: dict[str, int]) -> None:
    write_listing(tmp_path / "x.mat", "probe", files)
    found = read_listing(tmp_path / "x.mat", "probe_set", "probe_ids")
    assert found == [(name, str(number)) for name, number in files.items()]


@pytest.mark.parametrize("pairs", [[("a.jpg", "b.jpg")], [("a.jpg", "b.jpg"), ("c.jpg", "a.jpg")]])
def test_pairs_are_read_line_by_line(tmp_path: Path, pairs: list[tuple[str, str]]) -> None:
    savemat(tmp_path / "x.mat", {"pairs": cells(pairs)})
    assert read_pairs(tmp_path / "x.mat", "pairs") == pairs


@pytest.mark.parametrize(
    ("content", "message"),
    [
        pytest.param({"other": 1}, "no variable probe_set", id="absent"),
        pytest.param(
            {"probe_set": cells(["a.jpg", "b.jpg"]), "probe_ids": np.array([1])},
            "2 probe_set and 1 probe_ids",
            id="lengths",
        ),
        pytest.param(
            {"probe_set": cells(["a.jpg"]), "probe_ids": np.array([1.5])},
            "wanted a whole number",
            id="fraction",
        ),
        pytest.param(
            {"probe_set": cells(["../a.jpg"]), "probe_ids": np.array([1])},
            r"names '\.\./a\.jpg': wanted a file's plain name",
            id="outside",
        ),
        pytest.param(
            {"probe_set": {"a": 1.0}, "probe_ids": np.array([1])},
            "wanted a file's plain name",
            id="struct",
        ),
    ],
)
def test_other_content_is_refused(tmp_path: Path, content: dict[str, object], message: str) -> None:
    savemat(tmp_path / "x.mat", content)
    with pytest.raises(InputError, match=message):
        read_listing(tmp_path / "x.mat", "probe_set", "probe_ids")


def test_pairs_without_a_second_picture_are_refused(tmp_path: Path) -> None:
    savemat(tmp_path / "x.mat", {"pairs": cells(["a.jpg", "b.jpg", "c.jpg"])})
    with pytest.raises(InputError, match="3 pairs: wanted two a line"):
        read_pairs(tmp_path / "x.mat", "pairs")


@pytest.mark.parametrize("content", [None, b"", b"MATLAB 7.3 MAT-file" + bytes(600)])
def test_a_file_that_is_absent_or_broken_is_refused(tmp_path: Path, content: bytes | None) -> None:
    if content is not None:
        (tmp_path / "x.mat").write_bytes(content)
    with pytest.raises(InputError, match=r"cannot read .*x\.mat"):
        read_pairs(tmp_path / "x.mat", "pairs")


def test_a_picture_that_is_listed_and_not_there_is_refused(tmp_path: Path) -> None:
    write_face(tmp_path / "Probe" / "a.jpg", 1)
    found = photographs_of(tmp_path, "Probe", [("a.jpg", "1")], "probe")
    assert (found.names, found.identity_ids) == (["Probe/a.jpg"], ["1"])
    with pytest.raises(InputError, match=r"1 of 2 pictures are not there, such as b\.jpg"):
        photographs_of(tmp_path, "Probe", [("a.jpg", "1"), ("b.jpg", "2")], "probe")
