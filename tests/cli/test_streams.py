"""Closed, full and ASCII streams, signals, folders that cannot be made: with a task of paper."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

STUB = """
import signal, sys, time, types
from tqdm import tqdm
signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background job ignores it
from pathlib import Path
from lrsr import cli
from lrsr.configuration import run_folder
from lrsr.errors import InputError
from lrsr.files import make_folder, write_text

def task(config):
    if config.name == "out":
        return make_folder(Path("größe"))
    if config.name == "wrong":
        raise InputError(f"name=wrong: seed {config.seed} is refused")
    if config.name == "broken":
        raise ValueError(f"seed {config.seed}")
    with run_folder(config) as folder:
        write_text(folder / "results.json", "whole")
        with tqdm(total=1, desc="progress") as bar:
            bar.update()
        if config.name == "wait":
            print("waiting", flush=True)
            time.sleep(60)
        return folder

sys.modules["lrsr.tasks"] = types.SimpleNamespace(run_score=task)  # neither torch nor renderer
raise SystemExit(cli.main())
"""


def start(shell: str, folder: Path, **environment: str) -> subprocess.Popen[bytes]:
    if not (folder / "stub.py").exists():  # else another process may be reading it
        (folder / "stub.py").write_text(STUB)
    command = f"exec {sys.executable} stub.py score {shell}"
    env = {**os.environ, **environment}
    return subprocess.Popen(
        ["bash", "-c", command], cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )


def run(shell: str, folder: Path, **environment: str) -> tuple[int, bytes, bytes]:
    with start(shell, folder, **environment) as process:
        out, err = process.communicate(timeout=120)
    return process.returncode, out, err


@pytest.mark.parametrize(
    "shell",
    [
        ">&-",
        "2>&-",
        "<&-",
        "<&- >&- 2>&-",
        ">/dev/full",
        "2>/dev/full",
        "2> >(exit)",
        ">/dev/full 2>&1",
    ],
)
def test_work_that_is_done_is_status_0_whatever_the_streams(shell: str, tmp_path: Path) -> None:
    status, _, err = run(f"paths.run=x {shell}", tmp_path)
    assert status == 0, err
    assert b"Traceback" not in err
    assert (tmp_path / "x" / "results.json").read_text() == "whole"
    assert [path.name for path in (tmp_path / "x").iterdir()] == ["results.json"]


def test_letters_that_a_stream_cannot_show_are_spelt(tmp_path: Path) -> None:
    status, out, err = run("name=out", tmp_path, PYTHONIOENCODING="ascii")
    assert status == 0, err
    assert out.strip().endswith(rb"gr\xf6\xdfe")


def test_output_that_is_the_work_cannot_be_lost(tmp_path: Path) -> None:
    status, _, err = run("--cfg job >/dev/full", tmp_path)
    assert status == 2
    assert err.strip().count(b"\n") == 0
    assert b"no space left" in err


@pytest.mark.parametrize(
    ("number", "status"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["int", "term"]
)
def test_a_signal_ends_the_run_and_frees_its_folder(
    number: int, status: int, tmp_path: Path
) -> None:
    with start("name=wait paths.run=x", tmp_path) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.stdout.readline() == b"waiting\n"
        again, _, err = run("paths.run=x", tmp_path)
        assert again == 2
        assert b"is in use by another lrsr command" in err
        process.send_signal(number)
        told = process.stderr.read()
    assert process.returncode == status
    assert b"run the same command again" in told
    assert run("paths.run=x", tmp_path)[0] == 0


def test_two_commands_of_one_second_have_a_folder_each(tmp_path: Path) -> None:
    processes = [start("", tmp_path) for _ in range(3)]
    folders = [process.communicate()[0] for process in processes]
    assert [process.returncode for process in processes] == [0, 0, 0]
    assert len(set(folders)) == 3


def test_a_multirun_leaves_nothing_but_its_runs(tmp_path: Path) -> None:
    status, out, err = run("-m seed=0,1", tmp_path)
    assert status == 0, err
    assert len(set(out.splitlines())) == 2
    assert {path.name for path in tmp_path.iterdir()} == {"stub.py", "runs"}
    assert {path.name for path in (tmp_path / "runs").iterdir()} == {"score"}
    assert run("-m seed=0,1 paths.run=x", tmp_path)[0] == 0
    assert {path.name for path in (tmp_path / "x").iterdir()} == {"0", "1"}


def test_a_multirun_may_be_asked_for_in_hydras_words(tmp_path: Path) -> None:
    status, _, err = run("hydra.mode=MULTIRUN paths.run=x", tmp_path)
    assert status == 0, err
    assert [path.name for path in (tmp_path / "x").iterdir()] == ["0"]


@pytest.mark.parametrize(
    ("names", "status", "told"),
    [
        ("wrong,out", 2, ["job 0 (name=wrong seed=0): name=wrong: seed 0 is refused"]),
        (
            "wrong,out,broken",
            1,
            [
                "job 0 (name=wrong seed=0): name=wrong: seed 0 is refused",
                "job 2 (name=broken seed=0): a fault of ours: ValueError: seed 0 (the same command"
                " with --debug shows where)",
            ],
        ),
    ],
    ids=["one", "two"],
)
def test_every_failure_of_a_multirun_is_told(
    names: str, status: int, told: list[str], tmp_path: Path
) -> None:
    ended, out, err = run(f"-m name={names} seed=0", tmp_path)
    assert (ended, len(out.splitlines())) == (status, 1)
    lines = [line for line in err.decode().splitlines() if line.startswith("lrsr: ")]
    assert lines == [f"lrsr: {line}" for line in told]


@pytest.mark.parametrize(
    ("shell", "says"),
    [
        ("paths.run=stub.py", b"stub.py: File exists; choose another"),
        ("paths.run=stub.py/x", b"Not a directory"),
        ("paths.runs=stub.py", b"stub.py/score: Not a directory"),
        (f"paths.run={'x' * 300}", b"File name too long"),
        ("paths.run=/proc/x", b"cannot make folder /proc/x: No such file or directory"),
        ("paths.run=~nobody-here/x", b"write the whole path"),
    ],
    ids=["file", "below", "runs", "long", "proc", "home"],
)
def test_a_folder_that_cannot_be_made_is_named(shell: str, says: bytes, tmp_path: Path) -> None:
    status, _, err = run(shell, tmp_path)
    assert status == 2
    assert says in err
    assert err.count(b"\n") == 1


def test_a_working_folder_that_is_gone_is_told(tmp_path: Path) -> None:
    (tmp_path / "gone").mkdir()
    stub = tmp_path / "stub.py"
    stub.write_text(STUB)
    command = f"cd gone; rmdir ../gone; exec {sys.executable} {stub} score"
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, capture_output=True, check=False)
    assert done.returncode == 2
    assert b"cannot use the working folder" in done.stderr


def test_help_is_there_before_anything_is_loaded() -> None:
    code = "import sys, lrsr.cli; lrsr.cli.main(['help']); print(*sys.modules, file=sys.stderr)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True)
    assert b"usage: lrsr COMMAND" in done.stdout
    assert not {b"hydra", b"omegaconf", b"numpy", b"torch"} & {*done.stderr.split()}
