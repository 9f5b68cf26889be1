"""``lrsr fit-camera`` and ``camera=PATH`` as a user types them, without rendering anybody."""

from pathlib import Path

import pytest
import torch

from lrsr.cli import main
from lrsr.paths import config_folder
from lrsr.pictures.image_files import write_png


@pytest.fixture(autouse=True)
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "cache"))
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path / "empty")


def folder_of(tmp_path: Path, *sizes: int) -> Path:
    folder = tmp_path / "real"
    folder.mkdir()
    for k, side in enumerate(sizes):
        write_png(folder / f"{k}.png", torch.full((3, side, side), 0.5))
    return folder


@pytest.mark.parametrize(
    ("sizes", "says"),
    [
        ((), "holds no pictures: put files in it"),
        ((32, 32), "holds 2 pictures: give at least 20"),
        ((32,) * 20 + (33,), "20.png has 33 x 33 px, most others 32 x 32: crop all"),
    ],
    ids=["none", "few", "sizes"],
)
def test_pictures_that_cannot_be_used_are_one_line(
    sizes: tuple[int, ...], says: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit-camera", f"images={folder_of(tmp_path, *sizes)}"]) == 2
    lines = capsys.readouterr().err.strip().splitlines()
    assert len(lines) == 1
    assert says in lines[0]


def test_images_must_be_given(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fit-camera"]) == 2
    assert "add images=" in capsys.readouterr().err


def test_a_preset_is_taken_from_its_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = (config_folder() / "camera" / "webcam.yaml").read_text()
    path = tmp_path / "lobby.yaml"
    path.write_text(text.replace("name: webcam", "name: lobby"))
    assert main(["render", "out=x", f"camera={path}", "--cfg", "job"]) == 0
    assert "  name: lobby\n" in capsys.readouterr().out


def test_a_preset_that_is_not_there_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["render", "out=x", "camera=nowhere.yaml"]) == 2
    assert "nowhere.yaml is missing" in capsys.readouterr().err


@pytest.mark.parametrize(
    "line",
    [
        "_target_: os.system",
        '"\\x5ftarget_": os.system',
        "_target_: lrsr.camera.Camera\nsensor: [{_target_: lrsr.cli.main}]",
        "_target_: lrsr.camera.Camera\nsensor: {_target_: lrsr.camera.sensor.torch.save, f: x}",
        "_target_: lrsr.camera.Camera\noptics: ${oc.env:HOME}",
    ],
)
def test_a_preset_from_outside_builds_nothing_but_parts_of_a_camera(
    line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "trap.yaml"
    path.write_text(line + "\n")
    assert main(["render", "out=x", f"camera={path}"]) == 2
    said = capsys.readouterr().err
    assert "builds no part of lrsr.camera" in said or "write the value itself" in said
