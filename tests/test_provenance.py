import json
import platform
import subprocess
from pathlib import Path

import numpy as np
import pytest
from omegaconf import OmegaConf

import lrsr
from lrsr import provenance
from lrsr.errors import InputError
from lrsr.provenance import _git_hash, versions, write_provenance


def test_versions_are_those_that_run() -> None:
    found = versions()
    assert found["lrsr"] == lrsr.__version__
    assert found["numpy"] == np.__version__
    assert found["python"] == platform.python_version()
    assert {"torch", "mitsuba", "drjit", "kornia", "onnxruntime"} <= set(found)


def checkout(folder: Path, monkeypatch: pytest.MonkeyPatch) -> str:
    """Make a checkout with one commit, let lrsr think it runs from there, return the commit."""
    (folder / "lrsr").mkdir()
    (folder / "lrsr" / "a.py").write_text("1\n")
    git = ["git", "-C", str(folder), "-c", "user.name=t", "-c", "user.email=t@example.org"]
    for words in (["init", "-q"], ["add", "."], ["commit", "-qm", "one"]):
        subprocess.run([*git, *words], check=True)
    monkeypatch.setattr(provenance, "PACKAGE", folder / "lrsr")
    done = subprocess.run([*git, "rev-parse", "HEAD"], check=True, capture_output=True, text=True)
    return done.stdout.strip()


def test_git_hash_is_that_of_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _git_hash()
    assert checkout(tmp_path, monkeypatch).startswith(_git_hash())
    assert len(_git_hash()) == 12


def test_a_changed_checkout_has_a_plus(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checkout(tmp_path, monkeypatch)
    (tmp_path / "lrsr" / "a.py").write_text("2\n")
    assert _git_hash().endswith("+")


def test_an_installed_package_has_no_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "lrsr")
    assert _git_hash() == "installed"


def test_a_checkout_without_git_is_unknown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / ".git").mkdir()
    monkeypatch.setattr(provenance, "PACKAGE", tmp_path / "lrsr")
    assert _git_hash() == "unknown"


def test_a_run_folder_says_what_made_it(tmp_path: Path) -> None:
    write_provenance(tmp_path, OmegaConf.create({"seed": 7, "again": "${seed}"}))
    assert OmegaConf.load(tmp_path / "config.yaml") == {"seed": 7, "again": 7}
    assert json.loads((tmp_path / "versions.json").read_text())["lrsr"] == lrsr.__version__


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="file"):
        write_provenance(tmp_path / "file", OmegaConf.create({"seed": 7}))


@pytest.mark.parametrize(
    "error",
    [
        FileNotFoundError(2, "No such file or directory", "git"),
        subprocess.TimeoutExpired("git", 3),
        subprocess.CalledProcessError(128, "git", stderr="dubious ownership"),
    ],
    ids=["absent", "slow", "anothers"],
)
def test_a_git_that_does_not_answer_is_unknown(
    error: Exception, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*args: object, **options: object) -> None:
        raise error

    monkeypatch.setattr(subprocess, "run", fail)
    assert _git_hash() in {"unknown", "installed"}


def test_a_hooks_variables_name_no_other_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    commit = checkout(tmp_path, monkeypatch)
    monkeypatch.setenv("GIT_DIR", "/nowhere")
    assert commit.startswith(_git_hash())


def test_a_library_under_another_name_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "_RECORDED", ("no-such-distribution",))
    assert versions()["no-such-distribution"] == "unknown"
