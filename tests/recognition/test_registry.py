"""What is known by name, and which file is meant by one."""

import json
import re
from pathlib import Path

import pytest

from lrsr.errors import InputError
from lrsr.recognition.alignment import TEMPLATES
from lrsr.recognition.registry import contracts, model_file, records, sources

SHA256 = re.compile(r"[0-9a-f]{64}")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LRSR_MODELS", str(tmp_path))
    return tmp_path


def record(folder: Path, name: str, kind: str = "recogniser") -> None:
    told = {"kind": kind, "files": {f"{name}.onnx": "0" * 64}}
    (folder / f"{name}.json").write_text(json.dumps(told))


@pytest.mark.parametrize("name", sources())
def test_a_source_says_all_that_can_be_known(name: str) -> None:
    source = sources()[name]
    assert source.licence
    assert bool(source.url) != bool(source.package)
    assert source.url.startswith("https://") or "==" in source.package
    assert not source.sha256 or SHA256.fullmatch(source.sha256)
    assert source.research_only == ("research only" in source.licence)
    for model in source.models:
        assert model.trained_on
        assert set(model.sha256) <= set(model.files.values())
        assert all(map(SHA256.fullmatch, model.sha256.values()))
        assert model.contract in contracts() or model.name == "dlib_resnet"
        recognises = "alignment" in contracts().get(model.contract, {"alignment": 0})
        assert model.kind == ("recogniser" if recognises else "detector")


def test_the_same_name_means_the_same_bytes_in_every_source() -> None:
    known: dict[str, object] = {}
    for source in sources().values():
        for model in source.models:
            assert known.setdefault(model.name, model.sha256) == model.sha256


def test_no_package_index_is_named() -> None:
    hosts = {source.url.split("/")[2] for source in sources().values() if source.url}
    assert hosts == {"github.com", "huggingface.co"}


def test_alignments_are_those_there_are() -> None:
    named = {c["alignment"]["template"] for c in contracts().values() if "alignment" in c}
    assert named <= {*TEMPLATES, "deepface"}


def test_what_is_here_is_found_by_its_name_and_by_its_source(folder: Path) -> None:
    record(folder, "w600k_r50")
    record(folder, "det_10g", "detector")
    assert model_file("w600k_r50", "recogniser") == folder / "w600k_r50.onnx"
    assert model_file("buffalo_l", "recogniser") == folder / "w600k_r50.onnx"
    assert model_file("buffalo_l", "detector") == folder / "det_10g.onnx"


def test_a_path_is_a_file(folder: Path) -> None:
    assert model_file(str(folder / "x.onnx"), "recogniser") == folder / "x.onnx"
    assert model_file("x.onnx", "detector") == Path.cwd() / "x.onnx"


@pytest.mark.parametrize(
    ("name", "kind", "says"),
    [
        ("yunet", "detector", "yunet is not here: lrsr models pull yunet"),
        ("buffalo_l", "detector", "buffalo_l is not here: lrsr models pull buffalo_l"),
        ("mine", "detector", "mine is a recogniser; wanted a detector"),
        ("minee", "recogniser", "no recogniser 'minee': did you mean mine"),
        ("q", "detector", "no detector 'q': lrsr models list"),
    ],
)
def test_what_is_not_here_is_told_with_the_remedy(
    folder: Path, name: str, kind: str, says: str
) -> None:
    record(folder, "mine")
    with pytest.raises(InputError, match=says):
        model_file(name, kind)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "content",
    ["{", "[]", '{"kind": "recogniser"}', '{"kind": 1, "files": {"a": "b"}}',
     '{"kind": "recogniser", "files": {"../a": "b"}}', '{"kind": "recogniser", "files": {"a": 1}}'],
)  # fmt: skip
def test_a_record_of_another_kind_is_refused(folder: Path, content: str) -> None:
    (folder / "x.json").write_text(content)
    with pytest.raises(InputError, match=r"x\.json: no record of a model"):
        records()
