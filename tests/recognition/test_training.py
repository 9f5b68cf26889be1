import json
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import torch
from lrsr.data.cache import RenderCache

import lrsr.recognition.training as training
from lrsr.errors import InputError
from lrsr.recognition import Engine
from lrsr.recognition.arcface import ArcFaceModule
from lrsr.recognition.faces import FaceSettings
from lrsr.recognition.training import (
    TrainingSettings,
    has_bfloat16,
    read_checkpoint,
    train_embedder,
)

if TYPE_CHECKING:
    from lrsr.data.maker import Maker

pytestmark = [
    # Lightning and PyTorch about themselves; what they say changes nothing here.
    pytest.mark.filterwarnings("ignore:.*lr_scheduler.step.*"),
]

FACES = FaceSettings(identities=4, validation_identities=3, sharp_views=2, small_views=1)
TRAINING = TrainingSettings(epochs=2, views=1, batch_size=2, precision="32-true")


def train(folder: Path, cache: RenderCache, maker: "Maker", **changes: Any) -> dict[str, Any]:
    settings = {"faces": FACES, "training": TRAINING, **changes}
    train_embedder(folder, cache, progress=False, maker=maker, **settings)
    record: dict[str, Any] = json.loads((folder / "metrics.json").read_text())
    return record


def test_a_run_leaves_a_model_a_checkpoint_and_a_record(
    tmp_path: Path, cache: RenderCache, maker: "Maker"
) -> None:
    folder = tmp_path / "run"
    record = train(folder, cache, maker)
    assert record["finished"] is True
    assert [entry["epoch"] for entry in record["history"]] == [0, 1]
    wanted = {"train/loss", "train/accuracy", "val/auc", "val/auc_ipd64", "val/auc_ipd8"}
    assert wanted <= set(record["history"][0])
    assert 0 <= record["onnx"]["val/auc_ipd8"] <= 1
    assert Engine(folder / "model.onnx").describe()["sha256"] == record["model_sha256"]
    loaded = torch.load(folder / "best.ckpt", weights_only=True)
    assert loaded["hyper_parameters"]["people"] == 4
    assert read_checkpoint(folder / "best.ckpt").hparams["seed"] == 0


def test_an_interrupted_run_goes_on_and_ends_like_an_uninterrupted_one(
    tmp_path: Path, cache: RenderCache, maker: "Maker", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(training, "_finish", lambda folder, *_: folder)  # no export here
    whole = train(tmp_path / "whole", cache, maker)
    healthy = ArcFaceModule.training_step

    def dying(self: ArcFaceModule, batch: Any, batch_idx: int) -> torch.Tensor:
        if self.global_step == 3:
            raise MemoryError
        return healthy(self, batch, batch_idx)

    monkeypatch.setattr(ArcFaceModule, "training_step", dying)
    with pytest.raises(MemoryError):
        train(tmp_path / "halved", cache, maker)
    halfway = json.loads((tmp_path / "halved" / "metrics.json").read_text())
    assert (halfway["finished"], len(halfway["history"])) == (False, 1)

    monkeypatch.setattr(ArcFaceModule, "training_step", healthy)
    resumed = train(tmp_path / "halved", cache, maker)
    assert resumed["history"] == whole["history"]


def test_ctrl_c_is_an_interruption_and_not_an_exit(
    tmp_path: Path, cache: RenderCache, maker: "Maker", monkeypatch: pytest.MonkeyPatch
) -> None:
    def pressed(self: ArcFaceModule, batch: Any, batch_idx: int) -> torch.Tensor:
        raise KeyboardInterrupt

    monkeypatch.setattr(ArcFaceModule, "training_step", pressed)
    with pytest.raises(KeyboardInterrupt):
        train(tmp_path / "run", cache, maker)


def test_a_folder_of_another_run_is_left_alone(
    tmp_path: Path, cache: RenderCache, maker: "Maker"
) -> None:
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "settings.json").write_text('{"faces": {}}')
    with pytest.raises(InputError, match="holds a run of other settings: choose another folder"):
        train(folder, cache, maker)


def test_unless_the_user_begins_anew(
    tmp_path: Path, cache: RenderCache, maker: "Maker", monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(training, "_finish", lambda folder, *_: folder)
    folder = tmp_path / "run"
    folder.mkdir()
    (folder / "settings.json").write_text('{"faces": {}}')
    (folder / "last.ckpt").write_bytes(b"of another run")
    short = replace(TRAINING, epochs=1)
    assert len(train(folder, cache, maker, resume=False, training=short)["history"]) == 1


def test_a_file_that_is_no_checkpoint_is_named(tmp_path: Path) -> None:
    path = tmp_path / "best.ckpt"
    path.write_bytes(b"no checkpoint")
    with pytest.raises(InputError, match=r"best\.ckpt: no checkpoint of lrsr train"):
        read_checkpoint(path)


@pytest.mark.parametrize(
    "wrong",
    [{"epochs": 0}, {"views": 0}, {"batch_size": 1}, {"margin": 2.0}, {"precision": "16"}],
    ids=str,
)
def test_impossible_settings_are_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match=r"training\.\w+=.*: out of its range"):
        TrainingSettings(**wrong)


def test_bfloat16_is_known_from_the_processor() -> None:
    assert isinstance(has_bfloat16(), bool)
