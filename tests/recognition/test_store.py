"""What is here is listed, damage is found, and what is not wanted is removed."""

from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.recognition.addition import add
from lrsr.recognition.registry import records
from lrsr.recognition.store import remove, table, verify


def test_damage_is_found(folder: Path, net: Path) -> None:
    add(net, "insightface")
    add(net, "insightface", name="two")
    with (folder / "net.onnx").open("ab") as file:
        file.write(b"\0")
    (folder / "two.onnx").unlink()
    with pytest.raises(InputError, match=r"net: .*net.onnx is damaged; .*two: .* is missing"):
        verify()
    with pytest.raises(InputError, match="one is not here"):
        verify(["one"])
    with pytest.raises(InputError, match="one is not here"):
        remove("one")


def test_the_table_says_what_is_here_and_what_could_be(folder: Path, net: Path) -> None:
    add(net, "insightface", licence="CC0")
    lines = table()
    assert lines[1].split()[:3] == ["net", "recogniser", "here"]
    assert any("research only" in line and line.startswith("w600k_r50") for line in lines)
    assert records().keys() == {"net"}
