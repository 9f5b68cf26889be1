from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.recognition.memory import Memory

ROWS = np.arange(6, dtype=np.float32).reshape(2, 3)


class Maker:
    def __init__(self) -> None:
        self.calls = 0

    def __call__(self) -> np.ndarray:
        self.calls += 1
        return ROWS


def test_what_was_made_is_not_made_again(tmp_path: Path) -> None:
    make = Maker()
    first = Memory(tmp_path).recall({"a": 1}, [ROWS], make)
    again = Memory(tmp_path).recall({"a": 1}, [ROWS.copy()], make)
    np.testing.assert_array_equal(first, again)
    assert make.calls == 1


@pytest.mark.parametrize(
    ("what", "arrays"),
    [
        ({"a": 2}, [ROWS]),
        ({"a": 1}, [ROWS + 1e-6]),
        ({"a": 1}, [ROWS.astype(np.float64)]),
        ({"a": 1}, [ROWS, ROWS]),
        ({"a": 1}, [ROWS.reshape(2, 3, 1)]),
    ],
    ids=["setting", "pixel", "type", "one more", "shape"],
)
def test_anything_else_is_made(
    tmp_path: Path, what: dict[str, int], arrays: list[np.ndarray]
) -> None:
    make = Maker()
    Memory(tmp_path).recall({"a": 1}, [ROWS], make)
    Memory(tmp_path).recall(what, arrays, make)
    assert make.calls == 2


@pytest.mark.parametrize("damage", [b"", b"no numbers", None], ids=["empty", "other", "cut"])
def test_what_is_damaged_is_made_again(tmp_path: Path, damage: bytes | None) -> None:
    make = Maker()
    Memory(tmp_path).recall({}, [ROWS], make)
    (file,) = tmp_path.rglob("*.npy")
    file.write_bytes(file.read_bytes()[:-1] if damage is None else damage)
    np.testing.assert_array_equal(Memory(tmp_path).recall({}, [ROWS], make), ROWS)
    assert make.calls == 2


def test_without_a_folder_nothing_is_kept(tmp_path: Path) -> None:
    make = Maker()
    for _ in range(2):
        Memory().recall({}, [ROWS], make)
    assert make.calls == 2


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="cannot write"):
        Memory(tmp_path / "file").recall({}, [ROWS], Maker())
