from pathlib import Path

import pytest
import torch

from lrsr.errors import InputError
from lrsr.sr.weights import read_checkpoint
from lrsr.training.checkpoints import WholeFileIO


class Unpickled:
    """Something that only an unsafe load would bring back."""


def test_checkpoint_comes_back(tmp_path: Path) -> None:
    WholeFileIO().save_checkpoint({"state_dict": {"a": torch.ones(2)}, "epoch": 3}, tmp_path / "c")
    assert read_checkpoint(tmp_path / "c")["epoch"] == 3
    assert WholeFileIO().load_checkpoint(tmp_path / "c")["epoch"] == 3
    assert [path.name for path in tmp_path.iterdir()] == ["c"]


def test_failed_write_leaves_the_old_checkpoint(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "last.ckpt"
    WholeFileIO().save_checkpoint({"state_dict": {}, "epoch": 1}, path)

    def fill_the_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_bytes", fill_the_disk)
    with pytest.raises(InputError, match=r"cannot write .*last.ckpt: No space left"):
        WholeFileIO().save_checkpoint({"state_dict": {}, "epoch": 2}, path)
    assert read_checkpoint(path)["epoch"] == 1


def test_checkpoint_with_an_object_is_refused(tmp_path: Path) -> None:
    torch.save({"state_dict": {}, "extra": Unpickled()}, tmp_path / "c.ckpt")
    for read in (read_checkpoint, WholeFileIO().load_checkpoint):
        with pytest.raises(InputError, match=r"c.ckpt is no checkpoint of lrsr train"):
            read(tmp_path / "c.ckpt")


@pytest.mark.parametrize("content", [b"", b"half a file"], ids=["empty", "broken"])
def test_broken_checkpoint_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "c.ckpt").write_bytes(content)
    with pytest.raises(InputError, match=r"c.ckpt is no checkpoint of lrsr train"):
        read_checkpoint(tmp_path / "c.ckpt")


def test_file_without_weights_is_refused(tmp_path: Path) -> None:
    torch.save([1, 2], tmp_path / "c.ckpt")
    with pytest.raises(InputError, match="holds no state_dict"):
        read_checkpoint(tmp_path / "c.ckpt")
