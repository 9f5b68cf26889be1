from types import SimpleNamespace
from typing import Any

import pytest
import torch
from fakes.lessons import make_srcnn

from lrsr.training.progress import Progress


def trainer_at(epoch: int, gain_db: float) -> Any:
    """What the callback reads of a Trainer."""
    return SimpleNamespace(
        current_epoch=epoch,
        max_epochs=40,
        global_step=100 * epoch,
        estimated_stepping_batches=4000,
        callback_metrics={
            "val/psnr_y_db": torch.tensor(30.0 + gain_db),
            "val/gain_over_bicubic_db": torch.tensor(gain_db),
        },
    )


def test_epoch_line_tells_psnr_gain_and_whether_it_is_the_best(
    capsys: pytest.CaptureFixture[str],
) -> None:
    progress, module = Progress(), make_srcnn()
    for epoch, gain_db in enumerate((0.25, -0.5)):
        progress.on_train_epoch_end(trainer_at(epoch, gain_db), module)
        module.history.append({"val/psnr_y_db": 30.0 + gain_db})
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == [
        "epoch 1/40: PSNR-Y 30.25 dB, +0.25 dB over bicubic (best so far)",
        "epoch 2/40: PSNR-Y 29.50 dB, -0.50 dB over bicubic",
    ]


def test_resumed_run_remembers_its_best(capsys: pytest.CaptureFixture[str]) -> None:
    before, after = make_srcnn(), make_srcnn()
    before.history.append({"val/psnr_y_db": 30.25})
    checkpoint: dict[str, Any] = {}
    before.on_save_checkpoint(checkpoint)
    after.on_load_checkpoint(checkpoint)
    Progress().on_train_epoch_end(trainer_at(1, 0.1), after)
    assert capsys.readouterr().err.count("best so far") == 0


def test_bar_of_a_resumed_run_begins_where_it_stood(capsys: pytest.CaptureFixture[str]) -> None:
    progress = Progress()
    progress.on_train_start(trainer_at(20, 0.0), None)
    progress.on_exception(trainer_at(20, 0.0), None, RuntimeError())
    assert "2000/4000" in capsys.readouterr().err
