import json
from pathlib import Path
from typing import Any

import pytest
import torch

from lrsr.errors import InputError
from lrsr.training import resume
from lrsr.training.resume import forget, refuse_other_run, what_matters

CONFIG: dict[str, Any] = {
    "seed": 0,
    "resume": True,
    "paths": {"run": "a", "cache": None},
    "identities": {"count": 3, "roster": "x.json"},
    "data": {"ipd_px": [8, 11], "compressions": ["none"]},
    "logger": {"csv": {"name": "csv"}},
    "callbacks": {"progress": {}, "stopping": {"patience": 3}},
    "trainer": {
        "max_epochs": 4,
        "precision": "auto",
        "accelerator": "cpu",
        "log_every_n_steps": 10,
    },
    "module": {"start": "a.ckpt", "scheduler": None, "optimizer": {"lr": 1e-3}},
}


def test_everything_matters_but_what_is_listed() -> None:
    assert set(what_matters(CONFIG)) == {
        "seed",
        "identities.count",
        "data.ipd_px",
        "data.compressions",
        "callbacks.stopping.patience",
        "trainer.max_epochs",
        "trainer.precision",
        "trainer.accelerator",
        "module.scheduler",
        "module.optimizer.lr",
    }


@pytest.mark.parametrize("chosen", ["bf16-mixed", "32-true"])
def test_the_precision_is_the_one_that_this_machine_chooses(
    chosen: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(resume, "choose_precision", lambda _: (chosen, ""))
    assert what_matters(CONFIG)["trainer.precision"] == chosen


def begun(folder: Path, depends_on: dict[str, Any]) -> None:
    torch.save({"state_dict": {}, "depends_on": depends_on}, folder / "last.ckpt")


def test_the_same_run_may_go_on(tmp_path: Path) -> None:
    refuse_other_run(tmp_path, {"a": 1})
    begun(tmp_path, {"a": [8, 11]})
    refuse_other_run(tmp_path, {"a": (8, 11)})


@pytest.mark.parametrize(
    ("now", "message"),
    [
        ({"data.compressions": ["heavy"]}, r"compressions=\['none'\], .*compressions=\['heavy'\]"),
        ({}, r"data.compressions=\['none'\], this run has data.compressions=\(none\)"),
        ({"data.compressions": ["none"], "new": 1}, r"new=\(none\), this run has new=1"),
    ],
    ids=["changed", "gone", "new"],
)
def test_another_run_is_told_in_one_line(tmp_path: Path, now: Any, message: str) -> None:
    begun(tmp_path, {"data.compressions": ["none"]})
    with pytest.raises(
        InputError, match=rf"last.ckpt was trained with .*{message}: choose"
    ) as told:
        refuse_other_run(tmp_path, now)
    assert "\n" not in str(told.value)
    assert "resume=false" in str(told.value)


def test_a_checkpoint_that_does_not_say_is_another_run(tmp_path: Path) -> None:
    torch.save({"state_dict": {}}, tmp_path / "last.ckpt")
    with pytest.raises(InputError, match=r"trained with a=\(none\), this run has a=1"):
        refuse_other_run(tmp_path, {"a": 1})


def test_a_run_without_a_checkpoint_is_known_by_its_metrics(tmp_path: Path) -> None:
    (tmp_path / "metrics.json").write_text(json.dumps({"settings": {"a": 1}}))
    refuse_other_run(tmp_path, {"a": 1})
    with pytest.raises(InputError, match=r"metrics.json was trained with a=1, this run has a=2"):
        refuse_other_run(tmp_path, {"a": 2})


@pytest.mark.parametrize(
    "content",
    ["", "[]", '{"x": 1}', '{"settings": {"a": 1}, "history": []}'],
    ids=["empty", "list", "foreign", "no epoch"],
)
def test_what_is_no_record_of_ours_does_not_count(tmp_path: Path, content: str) -> None:
    (tmp_path / "metrics.json").write_text(content)
    refuse_other_run(tmp_path, {"a": 2})


def test_forgotten_is_what_a_run_left_and_nothing_else(tmp_path: Path) -> None:
    for name in ("last.ckpt", "best.ckpt", "model.onnx", "metrics.json", "notes.txt"):
        (tmp_path / name).touch()
    forget(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize(
    ("epochs", "follows_length", "message"),
    [
        (6, False, None),
        (6, True, r"max_epochs=4, .*max_epochs=6, and its scheduler is as long as the run: choose"),
        (2, False, r"max_epochs=4, this run has trainer.max_epochs=2: choose"),
        (None, False, r"max_epochs=4, this run has trainer.max_epochs=None: choose"),
    ],
    ids=["longer", "longer-schedule", "shorter", "none"],
)
def test_only_a_run_whose_rates_do_not_follow_from_its_length_may_be_longer(
    tmp_path: Path, epochs: int | None, follows_length: bool, message: str | None
) -> None:
    begun(tmp_path, {"trainer.max_epochs": 4})
    now = {"trainer.max_epochs": epochs}
    if message is None:
        refuse_other_run(tmp_path, now, follows_length=follows_length)
    else:
        with pytest.raises(InputError, match=message):
            refuse_other_run(tmp_path, now, follows_length=follows_length)
