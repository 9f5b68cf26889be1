import csv
import json
import signal
import subprocess
import sys
import textwrap
import time
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import onnxruntime
import pytest
import torch
from lightning.pytorch import LightningDataModule, Trainer
from lrsr.sr.module import Pair, SRCNNModule
from lrsr.sr.training import EPOCHS, train
from skimage.metrics import peak_signal_noise_ratio

from lrsr.errors import InputError, NonFiniteError
from lrsr.sr import Upscaler, training
from lrsr.sr.weights import read_weights

quiet = partial(Trainer, accelerator="cpu", devices=1, log_every_n_steps=1)


def run(pairs: LightningDataModule, folder: Path, *, epochs: int = 1, **settings: Any) -> Any:
    module = SRCNNModule(scale=2, **settings)
    return module, train(pairs, module, folder=folder, trainer=partial(quiet, max_epochs=epochs))


@pytest.fixture
def _no_export(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare seconds where the ONNX file is not the question."""
    monkeypatch.setattr(training, "export_onnx", lambda *_: 0.0)


without_export = pytest.mark.usefixtures("_no_export")


@pytest.fixture(scope="module")
def finished(many_pairs: LightningDataModule, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A module and its run folder after two epochs of some 90 steps."""
    return run(many_pairs, tmp_path_factory.mktemp("finished") / "run", epochs=2)


def test_paper_trains_160_epochs_for_2x_and_40_for_4x() -> None:
    assert EPOCHS == {2: 160, 4: 40}


def test_two_epochs_gain_over_bicubic_on_pictures_not_seen(
    finished: tuple[SRCNNModule, Path],
) -> None:
    _, folder = finished
    best = json.loads((folder / "metrics.json").read_text())["best"]
    assert best["val/gain_over_bicubic_db"] > 0.1


def test_run_folder_holds_what_the_stable_surface_promises(
    finished: tuple[SRCNNModule, Path],
) -> None:
    _, folder = finished
    names = {path.name for path in folder.iterdir()}
    assert {"best.ckpt", "last.ckpt", "model.onnx", "model.safetensors", "metrics.json"} <= names
    assert not {name for name in names if name.endswith(".part")}


def test_best_epoch_is_kept_by_validation_psnr(finished: tuple[SRCNNModule, Path]) -> None:
    module, folder = finished
    best = max(module.history, key=lambda epoch: epoch["val/psnr_y_db"])
    checkpoint = torch.load(folder / "best.ckpt", weights_only=True)
    assert checkpoint["epoch"] == best["epoch"]
    assert json.loads((folder / "metrics.json").read_text())["best"] == best


def test_metrics_say_what_made_them(finished: tuple[SRCNNModule, Path]) -> None:
    module, folder = finished
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["recipe"]["scale"] == 2
    assert metrics["hyper_parameters"] == dict(module.hparams)
    assert metrics["history"] == module.history
    assert metrics["seed"] == 0
    assert metrics["validation_images"] == 2
    assert metrics["steps"] == 2 * metrics["steps_per_epoch"]


def test_csv_log_has_a_line_for_each_epoch(finished: tuple[SRCNNModule, Path]) -> None:
    module, folder = finished
    with (folder / "csv" / "version_0" / "metrics.csv").open() as file:
        logged = [row["val/psnr_y_db"] for row in csv.DictReader(file) if row["val/psnr_y_db"]]
    assert [float(value) for value in logged] == pytest.approx(
        [epoch["val/psnr_y_db"] for epoch in module.history]
    )


def test_shipped_weights_checkpoint_and_onnx_are_the_same_network(
    finished: tuple[SRCNNModule, Path], many_pairs: LightningDataModule
) -> None:
    module, folder = finished
    enlarged, _ = many_pairs.val_pairs
    network, recipe = read_weights(folder / "model.safetensors")
    assert recipe == module.recipe
    from_checkpoint, _ = read_weights(folder / "best.ckpt")
    torch.testing.assert_close(network(enlarged), from_checkpoint(enlarged), rtol=0, atol=0)
    session = onnxruntime.InferenceSession(folder / "model.onnx")
    (restored,) = session.run(None, {"luminance": enlarged.numpy()})
    np.testing.assert_allclose(restored, network(enlarged).numpy(), atol=1e-5)


def test_logged_psnr_is_the_one_of_the_shipped_weights(
    finished: tuple[SRCNNModule, Path], many_pairs: LightningDataModule
) -> None:
    """Validation pads as inference does, in float32, with a border of `scale` left out."""
    _, folder = finished
    target = many_pairs.val_pairs[1].numpy()[:, 0]
    network, _ = read_weights(folder / "model.safetensors")
    restored = network(many_pairs.val_pairs[0]).numpy()[:, 0].clip(0, 1)
    psnr_db = [
        peak_signal_noise_ratio(t[2:-2, 2:-2], r[2:-2, 2:-2], data_range=1.0)
        for t, r in zip(target, restored, strict=True)
    ]
    best = json.loads((folder / "metrics.json").read_text())["best"]
    assert best["val/psnr_y_db"] == pytest.approx(np.mean(psnr_db), abs=1e-4)


def test_upscaler_takes_the_checkpoint_of_a_run(finished: tuple[SRCNNModule, Path]) -> None:
    _, folder = finished
    assert Upscaler("srcnn2", folder / "best.ckpt")(torch.zeros(1, 3, 4, 5)).shape == (1, 3, 8, 10)


@without_export
def test_resumed_run_ends_where_the_uninterrupted_one_does(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    straight, _ = run(pairs, tmp_path / "straight", epochs=3)

    class StopAfterTwo(SRCNNModule):
        def on_train_epoch_start(self) -> None:
            if self.current_epoch == 2:
                raise RuntimeError("power cut")

    with pytest.raises(RuntimeError, match="power cut"):
        train(
            pairs,
            StopAfterTwo(scale=2),
            folder=tmp_path / "cut",
            trainer=partial(quiet, max_epochs=3),
        )
    resumed, _ = run(pairs, tmp_path / "cut", epochs=3)
    assert [epoch["epoch"] for epoch in resumed.history] == [0, 1, 2]
    assert resumed.history == straight.history
    for name, value in straight.network.state_dict().items():
        torch.testing.assert_close(resumed.network.state_dict()[name], value, rtol=0, atol=0)


@without_export
def test_resume_false_begins_again(pairs: LightningDataModule, tmp_path: Path) -> None:
    begun, _ = run(pairs, tmp_path / "run", epochs=1)
    module = SRCNNModule(scale=2)
    trainer = partial(quiet, max_epochs=1)
    train(pairs, module, folder=tmp_path / "run", trainer=trainer, resume=False)
    assert module.history == begun.history


@without_export
def test_last_checkpoint_is_written_after_a_worse_epoch_too(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    class EverWorse(SRCNNModule):
        def validation_step(self, batch: Pair, batch_idx: int) -> None:
            self.log("val/psnr_y_db", 30.0 - self.current_epoch)
            self.log("val/gain_over_bicubic_db", 0.0 - self.current_epoch)

    folder = tmp_path / "run"
    train(pairs, EverWorse(scale=2), folder=folder, trainer=partial(quiet, max_epochs=2))
    assert torch.load(folder / "last.ckpt", weights_only=True)["epoch"] == 1
    assert torch.load(folder / "best.ckpt", weights_only=True)["epoch"] == 0


@without_export
def test_other_settings_in_the_same_folder_are_refused(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    run(pairs, tmp_path / "run", epochs=1)
    with pytest.raises(InputError, match=r"last.ckpt was trained with learning_rate=0.001, this"):
        run(pairs, tmp_path / "run", epochs=2, learning_rate=1e-2)


def test_broken_last_checkpoint_is_the_users_to_remove(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    (tmp_path / "last.ckpt").write_bytes(b"half a file")
    with pytest.raises(InputError, match=r"last.ckpt is no checkpoint of lrsr train"):
        run(pairs, tmp_path, epochs=1)


def test_nan_in_a_patch_stops_the_run_and_says_where(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    pairs.train_pairs[0][2, 0, 30, 30] = float("nan")
    with pytest.raises(
        NonFiniteError, match=r"loss is nan at epoch 0, step \d+: the input of patch"
    ):
        run(pairs, tmp_path, epochs=1)


def test_diverging_weights_stop_the_run_and_name_the_learning_rate(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    with pytest.raises(NonFiniteError, match=r"at epoch \d+.*lower the learning rate"):
        run(pairs, tmp_path, epochs=3, learning_rate=1e30, last_layer_learning_rate=1e30)


def test_run_without_validation_images_is_refused(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    trainer = partial(quiet, max_epochs=1, limit_val_batches=0)
    with pytest.raises(InputError, match="no image to validate on"):
        train(pairs, SRCNNModule(scale=2), folder=tmp_path, trainer=trainer)


def test_interrupted_run_reaches_the_caller_as_an_interrupt(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    class Impatient(SRCNNModule):
        def on_train_epoch_start(self) -> None:
            if self.current_epoch == 1:
                raise KeyboardInterrupt

    handler = signal.getsignal(signal.SIGINT)
    trainer = partial(quiet, max_epochs=2)
    with pytest.raises(KeyboardInterrupt):
        train(pairs, Impatient(scale=2), folder=tmp_path, trainer=trainer)
    assert signal.getsignal(signal.SIGINT) is handler
    assert (tmp_path / "last.ckpt").is_file()


LONG_RUN = """
    import sys
    from functools import partial
    from pathlib import Path
    sys.path.insert(0, {tests!r})
    import torch
    from conftest import SyntheticPairs
    from lightning.pytorch import Trainer
    from lrsr.sr.module import SRCNNModule
    from lrsr.sr.training import train
    torch.set_num_threads(1)
    trainer = partial(Trainer, max_epochs=100_000, accelerator="cpu", log_every_n_steps=1)
    module = SRCNNModule(scale=2, decay="none")
    train(SyntheticPairs(), module, folder=Path({folder!r}), trainer=trainer)
"""


@without_export
def test_run_killed_at_any_moment_goes_on_where_it_stood(
    pairs: LightningDataModule, tmp_path: Path
) -> None:
    folder = tmp_path / "run"
    code = LONG_RUN.format(tests=str(Path(__file__).parent), folder=str(folder))
    command = [sys.executable, "-c", textwrap.dedent(code)]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        while not (folder / "best.ckpt").is_file() and process.poll() is None:
            time.sleep(0.05)
        time.sleep(0.3)
        process.kill()
        stdout, stderr = process.communicate(timeout=60)
    assert b"dB over bicubic" in stderr
    assert stdout == b"", "progress belongs to stderr"
    done = len(torch.load(folder / "last.ckpt", weights_only=True)["history"])
    resumed, _ = run(pairs, folder, epochs=done + 1, decay="none")
    assert [epoch["epoch"] for epoch in resumed.history] == list(range(done + 1))
