"""A file is there whole or not at all, whatever happens."""

import errno
import json
import os
import re
import signal
import socket
import stat
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from lrsr.camera.preset_file import read_preset_file
from lrsr.camera.sensitivities import find_sensitivities
from lrsr.errors import InputError
from lrsr.evaluation.score_files.reading import read_scores
from lrsr.files import (
    check_file,
    fresh_folder,
    locked,
    make_folder,
    read_bytes,
    replacing,
    sweep,
    write_bytes,
    write_json,
    write_text,
)
from lrsr.identities.generated.boundaries import read_boundaries
from lrsr.identities.photographs.correspondence import read_correspondence
from lrsr.identities.photographs.person import read_photographed
from lrsr.identities.roster import IdentityRange
from lrsr.journal import read_lines
from lrsr.paths import PACKAGE
from lrsr.pictures.image_files import read_image
from lrsr.pictures.set_lists import read_listing
from lrsr.pictures.stored import read_header
from lrsr.sr import load_upscaler
from lrsr.tables import open_table

HANG_WHILE_WRITING = """
import sys, time
from pathlib import Path
from lrsr.files import replacing
with replacing(Path(sys.argv[1])) as temporary:
    temporary.write_bytes(b"half")
    print("writing", flush=True)
    time.sleep(60)
"""


def write_half(path: Path, failure: Exception) -> None:
    with replacing(path) as temporary:
        temporary.write_text("half")
        raise failure


def test_what_is_written_is_what_is_read(tmp_path: Path) -> None:
    write_bytes(tmp_path / "new" / "folder" / "a", b"\x00\xff")
    write_text(tmp_path / "b", "é\n")
    assert (tmp_path / "new" / "folder" / "a").read_bytes() == b"\x00\xff"
    assert (tmp_path / "b").read_bytes() == b"\xc3\xa9\n"


@pytest.mark.parametrize("durable", [True, False])
def test_an_old_file_is_replaced_and_nothing_else_left(tmp_path: Path, durable: bool) -> None:
    write_bytes(tmp_path / "a", b"old")
    write_bytes(tmp_path / "a", b"new", durable=durable)
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == {"a": b"new"}


def test_only_a_durable_write_waits_for_the_disk(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    waits: list[int] = []
    monkeypatch.setattr(os, "fsync", waits.append)
    write_bytes(tmp_path / "a", b"", durable=False)
    assert waits == []
    write_bytes(tmp_path / "a", b"")
    assert len(waits) == 1


def test_others_may_read_what_the_users_mask_lets_them(tmp_path: Path) -> None:
    mask = os.umask(0o027)
    try:
        write_text(tmp_path / "a", "")
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "a").stat().st_mode) == 0o640


def test_a_failure_leaves_the_old_file_and_no_other(tmp_path: Path) -> None:
    write_text(tmp_path / "a", "old")
    with pytest.raises(ZeroDivisionError):
        write_half(tmp_path / "a", ZeroDivisionError())
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "old"}


def test_a_full_disk_is_one_line_and_leaves_the_old_file(tmp_path: Path) -> None:
    write_text(tmp_path / "a", "old")
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(InputError, match=r"cannot write .*a: No space left on device; free space"):
        write_half(tmp_path / "a", full)
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"a": "old"}


def test_a_folder_that_is_a_file_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match=r"cannot write .*file/a"):
        write_text(tmp_path / "file" / "a", "")


def test_json_is_indented_and_ends_with_a_line(tmp_path: Path) -> None:
    write_json(tmp_path / "a.json", {"auc": 0.5})
    text = (tmp_path / "a.json").read_text()
    assert json.loads(text) == {"auc": 0.5}
    assert text == '{\n  "auc": 0.5\n}\n'


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_json_refuses_what_is_no_number(tmp_path: Path, value: float) -> None:
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_json(tmp_path / "a.json", {"auc": value})
    assert list(tmp_path.iterdir()) == []


def test_sweeping_removes_what_a_killed_writer_left_and_not_what_a_live_one_writes(
    tmp_path: Path,
) -> None:
    write_text(tmp_path / "kept", "kept")
    with subprocess.Popen(
        [sys.executable, "-c", HANG_WHILE_WRITING, str(tmp_path / "a")], stdout=subprocess.PIPE
    ) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"writing\n"
        assert sweep(tmp_path) == 0
        assert len(list(tmp_path.glob(".a.*.part"))) == 1
        writer.send_signal(signal.SIGKILL)
        writer.wait()
    assert sweep(tmp_path) == 1
    assert [path.name for path in tmp_path.iterdir()] == ["kept"]


def test_sweeping_a_folder_that_is_not_there_finds_nothing(tmp_path: Path) -> None:
    assert sweep(tmp_path / "none") == 0


def test_a_folder_that_cannot_be_made_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("nowhere")
    for name in ("file", "file/below", "link", "x" * 300):
        with pytest.raises(InputError, match=r"cannot make folder .*; choose another"):
            make_folder(tmp_path / name)


def test_a_folder_that_cannot_be_written_is_told_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert make_folder(tmp_path / "a" / "b").is_dir()
    monkeypatch.setattr(os, "access", lambda path, mode: False)  # root may everything
    with pytest.raises(InputError, match="no permission; choose another"):
        make_folder(tmp_path / "a" / "b")


def test_a_fresh_folder_is_nobody_elses(tmp_path: Path) -> None:
    wanted = tmp_path / "runs" / "12-00"
    made = [fresh_folder(wanted).name for _ in range(3)]
    assert made == ["12-00", "12-00-2", "12-00-3"]


def test_no_fresh_folder_where_a_file_is_in_the_way(tmp_path: Path) -> None:
    (tmp_path / "runs").touch()
    with pytest.raises(InputError, match="cannot make folder"):
        fresh_folder(tmp_path / "runs" / "12-00")


def test_a_claimed_folder_is_refused_until_it_is_given_back(tmp_path: Path) -> None:
    with locked(tmp_path, wait=False):
        write_text(tmp_path / "a", "writing in it goes on")
        with pytest.raises(InputError, match="is in use by another"), locked(tmp_path, wait=False):
            pass
    with locked(tmp_path, wait=False):
        pass
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


def test_of_many_that_read_change_and_write_none_is_lost(tmp_path: Path) -> None:
    path = tmp_path / "rows"
    write_text(path, "")

    def add(k: int) -> None:
        with locked(tmp_path):
            write_bytes(path, path.read_bytes() + b"%d\n" % k, durable=False)

    with ThreadPoolExecutor(8) as pool:
        list(pool.map(add, range(40)))
    assert sorted(map(int, path.read_text().split())) == list(range(40))


# what only looks like a file


def make_pipe(path: Path) -> Path:
    os.mkfifo(path)
    return path


def make_socket(path: Path) -> Path:
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(path))
    return path


@pytest.mark.parametrize(
    ("make", "kind"),
    [
        (make_pipe, "a named pipe"),
        (make_socket, "a socket"),
        (make_folder, "a folder"),
        (lambda _: Path("/dev/zero"), "a device"),
    ],
    ids=["pipe", "socket", "folder", "device"],
)
def test_what_is_no_file_is_told_and_not_waited_for(
    tmp_path: Path, make: Callable[[Path], Path], kind: str
) -> None:
    path = make(tmp_path / "x.png")
    with pytest.raises(OSError, match=f"{kind}, not a file"):
        read_bytes(path)
    with pytest.raises(InputError, match=f"cannot read {path}: {kind}, not a file"):
        read_image(path)


def test_a_link_to_a_file_is_one(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("there")
    (tmp_path / "b").symlink_to(tmp_path / "a")
    assert check_file(tmp_path / "b") == tmp_path / "b"
    assert read_bytes(tmp_path / "b") == b"there"
    with pytest.raises(FileNotFoundError):
        read_bytes(tmp_path / "c")


@pytest.mark.parametrize(
    ("name", "read"),
    [
        ("a.png", lambda path: read_header(path, path)),
        ("a.csv", lambda path: open_table(path, "make it")),
        ("a.csv", lambda path: read_scores([path])),
        ("a.yaml", read_preset_file),
        ("a.json", lambda path: IdentityRange(count=1, roster=str(path))),
        ("a.safetensors", load_upscaler),
        ("a.onnx", load_upscaler),
        ("a.mat", lambda path: read_listing(path, "x", "y")),
        ("a.jsonl", read_lines),
        ("a.safetensors", lambda path: read_boundaries(path, 8)),
        ("a.csv", lambda path: find_sensitivities(str(path))),
        ("a.npz", lambda path: read_correspondence(path.with_suffix(".onnx"), "")),
    ],
)
def test_no_reader_waits_for_a_pipe(
    tmp_path: Path, name: str, read: Callable[[Any], object]
) -> None:
    path = make_pipe(tmp_path / name)
    with pytest.raises(InputError, match=re.escape(str(path))):
        read(path)


def test_a_pipe_is_no_record_of_people(tmp_path: Path) -> None:
    make_pipe(tmp_path / "people.json")
    with pytest.raises(InputError, match=r"no people\.json there"):
        read_photographed(tmp_path)


def test_nothing_of_the_users_is_read_another_way() -> None:
    ours = {
        *("files.py", "training/precision.py", "recognition/registry.py"),
        *("experiments/report/published.py", "experiments/fitted.py"),  # behind is_file
        *("identities/shape/build_basis.py", "identities/shape/makehuman.py"),  # of a package
    }
    found = {
        str(file.relative_to(PACKAGE))
        for file in PACKAGE.rglob("*.py")
        if re.search(r"\.read_(bytes|text)\(", file.read_text())
    }
    assert found == ours
