"""``lrsr models`` as a user types it."""

from pathlib import Path

import pytest
from fakes.networks import write_tones

from lrsr.cli import main


@pytest.fixture(autouse=True)
def models(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LRSR_MODELS", str(tmp_path / "models"))
    (tmp_path / "it's here, now").mkdir()
    monkeypatch.chdir(tmp_path / "it's here, now")
    write_tones(Path("mine.onnx"))
    return tmp_path / "models"


def said(capsys: pytest.CaptureFixture[str]) -> list[str]:
    return capsys.readouterr().out.splitlines()


@pytest.mark.parametrize("words", [[], ["list"], ["action=list"]])
def test_without_more_they_are_listed(
    words: list[str], models: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["models", *words]) == 0
    lines = said(capsys)
    assert any(line.startswith("auraface") and "Apache-2.0" in line for line in lines)
    assert lines[-1] == str(models)


def test_a_file_is_added_verified_used_by_name_and_removed(
    models: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(Path("mine.onnx").resolve())
    assert main(["models", "add", file, "contract=insightface", "licence=CC0 1.0"]) == 0
    assert main(["models", "verify", "mine"]) == 0
    assert said(capsys)[2:] == ["mine: as it was recorded", str(models)]
    assert main(["eval", "recognition=mine", "--cfg", "job"]) == 0
    assert "recognisers: mine" in capsys.readouterr().out
    assert main(["models", "remove", "mine"]) == 0
    assert said(capsys) == ["mine: removed", str(models)]
    assert list(models.iterdir()) == []


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["models", "lost"], "action=lost: wanted one of list, verify, pull, add, remove"),
        (["models", "pull"], "names=[]: wanted lrsr models pull NAME"),
        (["models", "list", "x"], "names=['x']: wanted none"),
        (["models", "pull", "buffalo_l"], "add accept=research-only"),
        (["models", "pull", "buffalo_l", "accept=yes"], "accept=yes: wanted one of research-only"),
        (["models", "pull", "deepface_arcface"], "no checksum of it is known"),
        (["models", "pull", "buffalo"], "no model 'buffalo' to pull"),
        (["models", "remove", "mine"], "mine is not here"),
        (["models", "add", "gone.onnx"], "gone.onnx is missing"),
        (["models", "add", "mine.onnx", "mirror=x"], "no setting 'mirror'"),
        (["eval", "recognition=buffalo_l"], "buffalo_l is not here: lrsr models pull buffalo_l"),
        (["eval", "recognition=[shipped,mime]"], "no recogniser 'mime'"),
        (["identities", "recognition=lbp"], "encoder= says who compares"),
    ],
    ids=" ".join,
)
def test_a_mistake_is_told_in_one_line(
    words: list[str], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert says in line
    assert [path.name for path in Path.cwd().iterdir()] == ["mine.onnx"]
