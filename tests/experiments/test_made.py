"""Whatever happens, what is ours is known as ours, and nothing else is."""

from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.experiments.made import RECORD, Made

HOW = {"sr": {"scale": 2}}


def write(folder: Path, content: bytes = b"large", source: bytes = b"small", **how: int) -> Path:
    target = folder / "sub" / "größe.png"
    Made(folder).write(target, content, Path("/a/größe.png"), source, HOW | how)
    return target


def test_what_was_written_is_done_and_free_to_be_made_again(tmp_path: Path) -> None:
    target = write(tmp_path)
    made = Made(tmp_path)
    assert target.read_bytes() == b"large"
    assert made.source_of(target) == "/a/größe.png"
    assert made.is_done(target, b"small", HOW)
    made.check_free(target)


def test_another_source_or_way_or_a_lost_file_is_not_done(tmp_path: Path) -> None:
    target = write(tmp_path)
    assert not Made(tmp_path).is_done(target, b"other", HOW)
    assert not Made(tmp_path).is_done(target, b"small", HOW | {"quality": 3})
    target.unlink()
    assert not Made(tmp_path).is_done(target, b"small", HOW)
    assert not Made(tmp_path).is_done(tmp_path / "b.png", b"small", HOW)


def test_what_was_changed_since_or_never_ours_is_in_the_way(tmp_path: Path) -> None:
    target = write(tmp_path)
    target.write_bytes(b"retouched")
    assert not Made(tmp_path).is_done(target, b"small", HOW)
    (tmp_path / "b.png").write_bytes(b"somebody's")
    for path in (target, tmp_path / "b.png"):
        with pytest.raises(InputError, match=r"is there, and lrsr upscale did not make it so"):
            Made(tmp_path).write(path, b"new", Path("/x"), b"", HOW)
    assert target.read_bytes() == b"retouched"


def test_a_folder_of_that_name_is_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "b.png").mkdir()
    with pytest.raises(InputError, match=r"b\.png is there"):
        Made(tmp_path).check_free(tmp_path / "b.png")


def test_a_kill_between_record_and_picture_costs_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    target = write(tmp_path)

    def kill(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    with monkeypatch.context() as patch:
        patch.setattr("lrsr.experiments.made.write_bytes", kill)
        with pytest.raises(KeyboardInterrupt):
            write(tmp_path, b"larger", quality=3)
    made = Made(tmp_path)
    assert target.read_bytes() == b"large"
    assert not made.is_done(target, b"small", HOW | {"quality": 3})
    write(tmp_path, b"larger", quality=3)
    assert target.read_bytes() == b"larger"


def test_a_line_cut_short_hides_no_other(tmp_path: Path) -> None:
    write(tmp_path)
    with (tmp_path / RECORD).open("a") as record:
        record.write('\n{"file": "b.p')
    target = write(tmp_path, b"larger")
    assert Made(tmp_path).is_done(target, b"small", HOW)


def test_a_record_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / RECORD).write_bytes(b"\xff\xfe")
    with pytest.raises(InputError, match=r"cannot read .*upscaled\.jsonl.*choose another out"):
        Made(tmp_path)


def test_a_record_that_cannot_be_written_is_one_line(tmp_path: Path) -> None:
    made = Made(tmp_path)
    (tmp_path / RECORD).mkdir()
    with pytest.raises(InputError, match=r"cannot write .*upscaled\.jsonl: Is a directory"):
        made.write(tmp_path / "a.png", b"", Path("/x"), b"", HOW)
