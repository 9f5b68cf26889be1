"""The command line as a user meets it: help, overrides, one-line errors, exit status."""

import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hydra._internal.config_loader_impl import ConfigLoaderImpl
from omegaconf import DictConfig

from lrsr.cli import _COMMANDS, _mended, _with_operands, main
from lrsr.errors import InputError


def test_help_lists_every_command(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    page = capsys.readouterr().out
    assert all(f"\n  {name} " in page for name in _COMMANDS)


def test_no_word_at_all_is_help(capsys: pytest.CaptureFixture[str]) -> None:
    assert main([]) == 0
    assert "usage: lrsr COMMAND" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["demo", "render", "train", "eval", "identities", "fit-camera"])
def test_cfg_job_prints_the_configuration_from_an_empty_folder(
    command: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main([command, "--cfg", "job"]) == 0
    assert "identities:" in capsys.readouterr().out
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["evla"], "did you mean 'eval'"),
        (["fly"], "choose one of demo"),
        (["identities", "encoder=facenet"], "auto, dlib, shipped"),
        (["modles"], "no command"),
        (["eval", "idnetities.count=3"], "idnetities"),
        (["eval", "identities=nobody"], "nobody"),
        (["eval", "identities.count=many"], "count"),
        (["eval", "identities.count=0"], "identities.count"),
        (["eval", "identities.count=[1"], "input '[1'"),
        (["eval", "methods=[magic]"], "magic"),
        (["eval", "options=[7]"], "options"),
        (["eval", "ipd_px=-1"], "ipd_px"),
        (["train"], "sr=srcnn4x"),
        (["train", "sr=srcnn2x", "data=images"], "data.root must be given"),
        (["train", "sr=srcnn2x", "degradation=photographs"], "for recognition=arcface"),
        (["train", "sr=srcnn2x", "degradation=none", "camera=webcam"], "only degradation=camera"),
        (["train", "sr=srcnn2x", "degradation=best"], "degradation=best"),
        (["calibrate-reconstructor"], "model"),
        (["calibrate-reconstructor", "model=theirs.onnx"], "theirs.onnx is missing"),
        (["eval", "experiment=training_study"], "runs must be given"),
        (["eval", "experiment=training_study", "runs=x", "sr.a.weights=b"], "does not read it"),
        (["render"], "out"),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else None,
)
def test_wrong_input_is_one_line_and_status_2(
    words: list[str],
    says: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
    caplog: pytest.LogCaptureFixture,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(words) == 2
    said = capfd.readouterr().err
    assert len(said.strip().splitlines()) == 1, said
    assert said.startswith("lrsr: ")
    assert says in said
    assert caplog.messages == []  # of which a process would make lines
    assert list(tmp_path.iterdir()) == []


def test_a_process_ends_with_that_line_and_status(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "lrsr", "eval", "magic=1"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith("lrsr: ")


@pytest.mark.parametrize("words", [["lost"], ["list", "seed=3"]], ids=" ".join)
def test_settings_are_composed_once_to_know_the_keys_and_to_run(
    words: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    composed, load = [], ConfigLoaderImpl.load_configuration

    def counted(*args: Any, **options: Any) -> DictConfig:
        composed.append(options)
        return load(*args, **options)

    monkeypatch.setattr(ConfigLoaderImpl, "load_configuration", counted)
    monkeypatch.chdir(tmp_path)
    applies = ConfigLoaderImpl._apply_overrides_to_config
    assert main(["models", *words]) == 2
    assert len(composed) == 1
    assert ConfigLoaderImpl._apply_overrides_to_config is applies


def test_debug_shows_the_traceback() -> None:
    with pytest.raises(InputError, match="did you mean 'eval'"):
        main(["evla", "--debug"])


def test_a_fault_of_ours_is_status_1(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(name: str, overrides: list[str]) -> None:
        raise RuntimeError("two\nlines")

    monkeypatch.setattr("lrsr.cli._run", fail)
    assert main(["eval"]) == 1
    assert capsys.readouterr().err.startswith("lrsr: a fault of ours: RuntimeError: two; lines")


def test_ctrl_c_is_status_130(monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(name: str, overrides: list[str]) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("lrsr.cli._run", interrupt)
    assert main(["eval"]) == 130


def test_a_reader_that_stops_early_is_no_fault(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "lrsr", "eval", "--help"]
    with subprocess.Popen(
        command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as writer:
        assert writer.stdout is not None
        assert writer.stderr is not None
        writer.stdout.close()
        assert writer.stderr.read() == ""


@pytest.mark.parametrize(
    ("words", "folders"),
    [
        (["hydra/launcher=submitit_slurm"], ["{}/runs/submitit/%j"]),
        (["hydra/launcher=submitit_local", "hydra.launcher.submitit_folder=x/%j"], ["x/%j"]),
        (["hydra/launcher=joblib"], []),
    ],
    ids=["slurm", "given", "joblib"],
)
def test_what_submitits_jobs_print_stays_where_all_machines_see_it(
    words: list[str], folders: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    line = {"config_path": None, "config_dir": None, "config_name": None, "multirun": True}
    mended, _ = _mended(SimpleNamespace(overrides=words, **line), "eval", tmp_path)
    given = [word.partition("=")[2].strip('"') for word in mended if "submitit_folder" in word]
    assert given == [folder.format(tmp_path) for folder in folders]


def test_a_file_with_an_equals_sign_is_one_where_a_slash_tells_it_from_a_setting(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "h").mkdir()
    (tmp_path / "h" / "a=b.png").touch()
    settings = ["sr=srcnn2", "rendering/skin=tone"]
    assert _with_operands(["h/a=b.png", *settings], "upscale") == [
        *settings,
        'images=["h/a=b.png"]',
    ]
