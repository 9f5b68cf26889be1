from types import SimpleNamespace

import pytest
import torch
from lrsr.sr.progress import GainProgress


def trainer_at(epoch: int, gain_db: float) -> SimpleNamespace:
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
    progress = GainProgress()
    progress.on_validation_end(trainer_at(0, 0.25), None)
    progress.on_validation_end(trainer_at(1, -0.5), None)
    captured = capsys.readouterr()
    assert captured.out == ""
    assert captured.err.splitlines() == [
        "epoch 1/40: PSNR-Y 30.25 dB, +0.25 dB over bicubic (best so far)",
        "epoch 2/40: PSNR-Y 29.50 dB, -0.50 dB over bicubic",
    ]


def test_resumed_run_remembers_its_best(capsys: pytest.CaptureFixture[str]) -> None:
    before, after = GainProgress(), GainProgress()
    before.on_validation_end(trainer_at(0, 0.25), None)
    after.load_state_dict(before.state_dict())
    after.on_validation_end(trainer_at(1, 0.1), None)
    assert capsys.readouterr().err.count("best so far") == 1


def test_bar_of_a_resumed_run_begins_where_it_stood(capsys: pytest.CaptureFixture[str]) -> None:
    progress = GainProgress()
    progress.on_train_start(trainer_at(20, 0.0), None)
    progress.on_exception(trainer_at(20, 0.0), None, RuntimeError())
    assert "2000/4000" in capsys.readouterr().err
