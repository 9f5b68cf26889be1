import csv
import json
import os
import signal
import time
from collections.abc import Callable
from functools import partial
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import onnxruntime
import pytest
import torch
from fakes.elsewhere import begin
from fakes.lessons import (
    FaceLessons,
    PaintedFaces,
    RedrawnPairs,
    SyntheticPairs,
    make_arcface,
    make_edsr,
    make_srcnn,
    make_told,
    quiet,
    train_by_command,
    train_fake,
)
from lightning.pytorch import LightningDataModule
from lightning.pytorch.loggers import CSVLogger
from skimage.metrics import peak_signal_noise_ratio

from lrsr.errors import DivergenceError, InputError, NonFiniteError
from lrsr.images import luminance
from lrsr.paths import asset
from lrsr.recognition import Engine
from lrsr.sr import load_upscaler
from lrsr.sr.weights import read_weights
from lrsr.training import identification, lessons, restoration
from lrsr.training.learner import Learner, try_optimizer
from lrsr.training.patches import Pair, RgbPatches
from lrsr.training.restoration import Restoration
from lrsr.training.run import train

pytestmark = [
    # Lightning and PyTorch about themselves; what they say changes nothing here.
    pytest.mark.filterwarnings("ignore:.*lr_scheduler.step.*"),
]


def run(
    data: LightningDataModule,
    folder: Path,
    *,
    epochs: int = 1,
    module: Learner | None = None,
    **settings: Any,
) -> Any:
    module = module or make_srcnn()
    given = {"depends_on": {"epochs": epochs}, **settings}
    return module, train(
        module, data, folder=folder, trainer=partial(quiet, max_epochs=epochs), **given
    )


def lack_torch_xla(**_: object) -> NoReturn:
    raise ModuleNotFoundError("No module named 'torch_xla'")


@pytest.fixture
def _no_export(monkeypatch: pytest.MonkeyPatch) -> None:
    """Spare seconds where the ONNX file is not the question."""
    monkeypatch.setattr(restoration, "export_onnx", lambda *_, **__: 0.0)
    monkeypatch.setattr(identification.Identification, "ship", lambda *_: {})


without_export = pytest.mark.usefixtures("_no_export")


@pytest.fixture(scope="module")
def finished(many_pairs: SyntheticPairs, tmp_path_factory: pytest.TempPathFactory) -> Any:
    """A module and its run folder after two epochs of some 90 steps."""
    folder = tmp_path_factory.mktemp("finished") / "run"
    return run(many_pairs, folder, epochs=2, loggers=[partial(CSVLogger, name="csv")])


def test_two_epochs_gain_over_bicubic_on_pictures_not_seen(
    finished: tuple[Restoration, Path],
) -> None:
    _, folder = finished
    best = json.loads((folder / "metrics.json").read_text())["best"]
    assert best["val/gain_over_bicubic_db"] > 0.1


def test_run_folder_holds_what_the_stable_surface_promises(
    finished: tuple[Restoration, Path],
) -> None:
    _, folder = finished
    names = {path.name for path in folder.iterdir()}
    assert {"best.ckpt", "last.ckpt", "model.onnx", "model.safetensors", "metrics.json"} <= names
    assert not {name for name in names if name.endswith(".part")}


def test_best_epoch_is_kept_by_validation_psnr(finished: tuple[Restoration, Path]) -> None:
    module, folder = finished
    best = max(module.history, key=lambda epoch: epoch["val/psnr_y_db"])
    checkpoint = torch.load(folder / "best.ckpt", weights_only=True)
    assert checkpoint["epoch"] == best["epoch"]
    assert json.loads((folder / "metrics.json").read_text())["best"] == best


def test_metrics_say_what_made_them(finished: tuple[Restoration, Path]) -> None:
    module, folder = finished
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["finished"] is True
    assert metrics["card"]["scale"] == 2
    assert metrics["settings"] == {"epochs": 2}
    assert metrics["history"] == module.history
    assert metrics["seed"] == 0
    assert metrics["precision"] in {"32-true", "bf16-mixed"}
    assert metrics["versions"]["torch"]
    assert metrics["validation_batches"] == 2
    assert metrics["steps"] == 2 * metrics["steps_per_epoch"]


def test_csv_log_has_a_line_for_each_epoch(finished: tuple[Restoration, Path]) -> None:
    module, folder = finished
    with (folder / "csv" / "version_0" / "metrics.csv").open() as file:
        logged = [row["val/psnr_y_db"] for row in csv.DictReader(file) if row["val/psnr_y_db"]]
    assert [float(value) for value in logged] == pytest.approx(
        [epoch["val/psnr_y_db"] for epoch in module.history]
    )


def test_shipped_weights_checkpoint_and_onnx_are_the_same_network(
    finished: tuple[Restoration, Path], many_pairs: SyntheticPairs
) -> None:
    module, folder = finished
    small, _ = many_pairs.val_pairs
    from_weights, from_checkpoint, from_onnx = (
        load_upscaler(folder / name)(small)
        for name in ("model.safetensors", "best.ckpt", "model.onnx")
    )
    assert read_weights(folder / "model.safetensors")[1] == module.card
    torch.testing.assert_close(from_weights, from_checkpoint, rtol=0, atol=0)
    torch.testing.assert_close(from_weights, from_onnx, rtol=0, atol=1e-5)


def test_logged_psnr_is_the_one_of_the_shipped_weights(
    finished: tuple[Restoration, Path], many_pairs: SyntheticPairs
) -> None:
    """Validation is of the upscaler that is shipped, with a border of `scale` left out."""
    _, folder = finished
    small, true = many_pairs.val_pairs
    restored = luminance(load_upscaler(folder / "model.safetensors")(small)).numpy()[:, 0]
    psnr_db = [
        peak_signal_noise_ratio(t[2:-2, 2:-2], r[2:-2, 2:-2], data_range=1.0)
        for t, r in zip(luminance(true).numpy()[:, 0], restored, strict=True)
    ]
    best = json.loads((folder / "metrics.json").read_text())["best"]
    assert best["val/psnr_y_db"] == pytest.approx(np.mean(psnr_db), abs=1e-4)


def test_a_network_of_colours_goes_the_same_way(tmp_path: Path) -> None:
    data = SyntheticPairs(batch_size=8, count=8, patches=RgbPatches(16, 8))
    _, folder = run(data, tmp_path, module=make_edsr(turned=True), epochs=1)
    small, true = data.val_pairs
    assert load_upscaler(folder / "model.onnx")(small).shape == true.shape
    (value,) = onnxruntime.InferenceSession(folder / "model.onnx").get_inputs()
    assert (value.name, value.shape) == ("rgb", ["N", 3, "H", "W"])


def test_an_embedder_leaves_a_model_with_its_contract_and_what_it_measures(tmp_path: Path) -> None:
    _, folder = run(PaintedFaces(), tmp_path, module=make_arcface(), epochs=2)
    record = json.loads((folder / "metrics.json").read_text())
    assert [entry["epoch"] for entry in record["history"]] == [0, 1]
    assert {"train/loss", "train/accuracy", "val/auc", "val/auc_ipd8"} <= set(record["history"][0])
    assert 0 <= record["onnx"]["val/auc_ipd8"] <= 1
    assert Engine(folder / "model.onnx").describe()["sha256"] == record["model_sha256"]


class PowerCutError(Exception):
    """Not Lightning's to catch."""


@without_export
@pytest.mark.parametrize(
    ("make", "lessons"),
    [
        (make_srcnn, SyntheticPairs),
        (make_srcnn, RedrawnPairs),
        (make_told, FaceLessons),
        (make_arcface, PaintedFaces),
    ],
    ids=["srcnn", "srcnn, redrawn in every epoch", "losses", "arcface"],
)
def test_resumed_run_ends_where_the_uninterrupted_one_does(
    make: Callable[[], Learner], lessons: type[LightningDataModule], tmp_path: Path
) -> None:
    straight, _ = run(lessons(), tmp_path / "straight", epochs=3, module=make())
    stopping = make()
    loss = stopping.loss

    def cut_off(batch: Any) -> torch.Tensor:
        if stopping.current_epoch == 2:
            raise PowerCutError
        return loss(batch)

    stopping.loss = cut_off  # type: ignore[method-assign]
    with pytest.raises(PowerCutError):
        run(lessons(), tmp_path / "cut", epochs=3, module=stopping)
    resumed, _ = run(lessons(), tmp_path / "cut", epochs=3, module=make())
    assert [epoch["epoch"] for epoch in resumed.history] == [0, 1, 2]
    assert resumed.history == straight.history
    for name, value in straight.state_dict().items():
        torch.testing.assert_close(resumed.state_dict()[name], value, rtol=0, atol=0, msg=name)


@without_export
def test_each_term_of_the_loss_has_its_figure(tmp_path: Path) -> None:
    module, _ = run(FaceLessons(), tmp_path, module=make_told())
    figures = module.history[0]
    terms = figures["train/identity"], figures["train/adversarial"]
    assert figures["train/loss"] == pytest.approx(
        figures["train/pixel"] + 0.1 * terms[0] + 0.01 * terms[1], rel=1e-4
    )
    assert 0 < terms[0] < 2


def wait_for_epochs(process: BaseProcess, folder: Path, count: int) -> None:
    while process.is_alive() and epochs_of(folder) < count:
        time.sleep(0.01)


@without_export
@pytest.mark.parametrize("network", ["srcnn", "arcface"])
def test_four_epochs_killed_after_two_end_with_the_same_weights(
    network: str, tmp_path: Path
) -> None:
    process = begin(tmp_path / "told", train_fake, network, tmp_path / "killed", 4)
    wait_for_epochs(process, tmp_path / "killed", 2)
    process.kill()
    process.join(timeout=60)
    assert process.exitcode == -signal.SIGKILL
    assert "epoch 2/4: " in (tmp_path / "told" / "err").read_text()
    assert (tmp_path / "told" / "out").read_text() == "", "progress belongs to stderr"
    for name in ("whole", "killed"):
        train_fake(network, tmp_path / name, 4)
    one, other = (
        torch.load(tmp_path / name / "last.ckpt", weights_only=True) for name in ("whole", "killed")
    )
    assert one["epoch"] == other["epoch"] == 3
    assert one["history"] == other["history"]
    assert all(torch.equal(one["state_dict"][name], t) for name, t in other["state_dict"].items())


def test_of_two_commands_in_one_folder_the_later_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module, name in ((lessons, "read_lessons"), (restoration, "export_onnx")):
        monkeypatch.setattr(module, name, getattr(module, name))  # to be as it was again
    folder = tmp_path / "run"
    first = begin(tmp_path / "told", train_by_command, folder, 12)
    assert first.pid is not None
    wait_for_epochs(first, folder, 1)
    os.kill(first.pid, signal.SIGSTOP)  # it works in the folder, however fast it is
    assert train_by_command(folder, 12) == 2
    told = capsys.readouterr()
    os.kill(first.pid, signal.SIGCONT)
    assert told.out == ""
    line = f"lrsr: {folder} is in use by another lrsr command: wait for it or choose another"
    assert told.err.splitlines()[-1] == line
    first.join(timeout=120)
    assert (first.exitcode, epochs_of(folder)) == (0, 12)
    assert train_by_command(folder, 14) == 0
    assert capsys.readouterr().out.split() == [str(folder)]
    history = json.loads((folder / "metrics.json").read_text())["history"]
    assert [epoch["epoch"] for epoch in history] == [*range(14)]


def test_a_run_goes_on_only_from_what_it_began_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    for module, name in ((lessons, "read_lessons"), (restoration, "export_onnx")):
        monkeypatch.setattr(module, name, getattr(module, name))  # to be as it was again
    folder, shipped = tmp_path / "run", asset("weights/srcnn2x.safetensors")
    (tmp_path / "moved.safetensors").write_bytes(shipped.read_bytes())
    assert train_by_command(folder, 1, f"module.start={shipped}") == 0
    assert train_by_command(folder, 2, f"module.start={tmp_path}/moved.safetensors") == 0
    assert epochs_of(folder) == 2
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    other = asset("weights/srcnn2x_camera.safetensors")
    for words in ([], [f"module.start={other}"]):
        assert train_by_command(folder, 3, *words) == 2
        assert "was trained with module.start=" in capsys.readouterr().err.splitlines()[-1]
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def epochs_of(folder: Path) -> int:
    path = folder / "metrics.json"
    return len(json.loads(path.read_text())["history"]) if path.is_file() else 0


@without_export
def test_a_finished_run_is_left_as_it_is(pairs: SyntheticPairs, tmp_path: Path) -> None:
    _, folder = run(pairs, tmp_path, epochs=2)
    before = json.loads((folder / "metrics.json").read_text())
    run(pairs, tmp_path, epochs=2)
    after = json.loads((folder / "metrics.json").read_text())
    assert after["history"] == before["history"]
    assert after["steps"] == before["steps"]


@without_export
def test_a_longer_run_goes_on_from_a_finished_one(pairs: SyntheticPairs, tmp_path: Path) -> None:
    def constant(folder: str, epochs: int) -> Learner:
        depends_on = {"trainer.max_epochs": epochs}
        module = make_srcnn(scheduler=None)
        run(pairs, tmp_path / folder, epochs=epochs, module=module, depends_on=depends_on)
        return module

    whole = constant("whole", 4)
    constant("longer", 2)
    longer = constant("longer", 4)
    assert longer.history == whole.history
    for name, value in whole.state_dict().items():
        assert torch.equal(longer.state_dict()[name], value), name


@pytest.mark.parametrize(
    ("scheduler", "follows"),
    [
        (None, False),
        (partial(torch.optim.lr_scheduler.StepLR, step_size=3), False),
        (partial(torch.optim.lr_scheduler.CosineAnnealingLR, T_max=7), False),
        (partial(torch.optim.lr_scheduler.CosineAnnealingLR), True),
        (partial(torch.optim.lr_scheduler.OneCycleLR, max_lr=1e-3), True),
    ],
    ids=["none", "steps", "cosine-of-seven", "cosine", "one-cycle"],
)
def test_rates_follow_the_length_where_the_scheduler_does_not_say_it(
    scheduler: Any, follows: bool
) -> None:
    assert make_srcnn(scheduler=scheduler).follows_length is follows


@without_export
def test_a_moved_folder_still_knows_its_best_epoch(pairs: SyntheticPairs, tmp_path: Path) -> None:
    class EverWorse(Restoration):
        def validation_step(self, batch: Pair, batch_idx: int) -> None:
            self.log("val/psnr_y_db", 30.0 - self.current_epoch)

    def worse() -> Restoration:
        module = make_srcnn()
        module.__class__ = EverWorse
        return module

    run(pairs, tmp_path / "a", epochs=2, module=worse(), depends_on={})
    assert torch.load(tmp_path / "a" / "last.ckpt", weights_only=True)["epoch"] == 1
    (tmp_path / "a").rename(tmp_path / "b")
    run(pairs, tmp_path / "b", epochs=3, module=worse(), depends_on={})
    assert torch.load(tmp_path / "b" / "last.ckpt", weights_only=True)["epoch"] == 2
    assert torch.load(tmp_path / "b" / "best.ckpt", weights_only=True)["epoch"] == 0


@without_export
def test_resume_false_begins_again(pairs: SyntheticPairs, tmp_path: Path) -> None:
    begun, _ = run(pairs, tmp_path / "run")
    again, _ = run(pairs, tmp_path / "run", resume=False)
    assert again.history == begun.history


@without_export
def test_another_run_is_refused_and_left_alone(pairs: SyntheticPairs, tmp_path: Path) -> None:
    _, folder = run(pairs, tmp_path / "run", depends_on={"epochs": 1, "people": 3})
    before = {path: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(InputError, match=r"last.ckpt was trained with people=3, .* people=4"):
        run(pairs, folder, depends_on={"epochs": 1, "people": 4})
    assert {path: path.read_bytes() for path in folder.iterdir()} == before


@without_export
def test_half_a_checkpoint_is_refused(pairs: SyntheticPairs, tmp_path: Path) -> None:
    (tmp_path / "last.ckpt").write_bytes(b"half a file")
    with pytest.raises(InputError, match=r"last.ckpt is no checkpoint of lrsr train"):
        run(pairs, tmp_path)


@without_export
def test_last_checkpoint_survives_a_full_disk(
    pairs: SyntheticPairs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run(pairs, tmp_path, depends_on={})
    write = Path.write_bytes

    def fill_the_disk(path: Path, content: bytes) -> int:
        if ".ckpt" in path.name:
            raise OSError(28, "No space left on device")
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", fill_the_disk)
    with pytest.raises(InputError, match=r"cannot write .*\.ckpt: No space left on device; free"):
        run(pairs, tmp_path, epochs=2, depends_on={})
    assert torch.load(tmp_path / "last.ckpt", weights_only=True)["epoch"] == 0


@without_export
def test_a_logger_on_a_full_disk_says_so(
    pairs: SyntheticPairs, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fill_the_disk(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(CSVLogger, "save", fill_the_disk)
    with pytest.raises(InputError, match=r"cannot write .*: No space left on device; free space"):
        run(pairs, tmp_path, loggers=[partial(CSVLogger, name="csv")])


def test_nan_in_a_patch_stops_the_run_and_says_where(pairs: SyntheticPairs, tmp_path: Path) -> None:
    pairs.train_pairs[0][2, 0, 30, 30] = float("nan")
    with pytest.raises(
        NonFiniteError, match=r"loss is nan at epoch 0, step \d+: the input of patch"
    ):
        run(pairs, tmp_path)


@pytest.mark.parametrize(
    ("trainer", "says"),
    [
        (partial(quiet, max_epochs=0), "trainer.max_epochs=0: wanted more than 0"),
        (partial(quiet, max_epochs=-1), "trainer.max_epochs=-1: wanted a number above 0, as the"),
        (partial(lack_torch_xla), "trainer: No module named 'torch_xla'"),
    ],
)
def test_a_refused_trainer_leaves_nothing_that_stands_in_the_way(
    pairs: SyntheticPairs, tmp_path: Path, trainer: Any, says: str
) -> None:
    recorded: list[Path] = []
    more: Any = {"depends_on": {"x": 1}, "record": recorded.append, "resume": False}
    (tmp_path / "last.ckpt").write_bytes(b"of a run before")
    with pytest.raises(InputError, match=says):
        train(make_srcnn(), pairs, folder=tmp_path, trainer=trainer, **more)
    assert [path.name for path in tmp_path.iterdir()] == ["last.ckpt"]
    assert recorded == []


def test_diverging_weights_stop_the_run_and_name_the_learning_rate(
    pairs: SyntheticPairs, tmp_path: Path
) -> None:
    with pytest.raises(DivergenceError, match=r"at epoch \d+.*lower the learning rate"):
        run(pairs, tmp_path, epochs=3, module=make_srcnn(lr=1e30))


def test_run_without_validation_images_is_refused(pairs: SyntheticPairs, tmp_path: Path) -> None:
    trainer = partial(quiet, max_epochs=1, limit_val_batches=0)
    with pytest.raises(InputError, match="no image to validate on"):
        train(make_srcnn(), pairs, folder=tmp_path, trainer=trainer, depends_on={})


@pytest.mark.parametrize("name", ["max_epochs", "max_steps", "limit_train_batches"])
def test_a_run_that_would_learn_nothing_is_refused(
    name: str, pairs: SyntheticPairs, tmp_path: Path
) -> None:
    trainer = partial(quiet, **{"max_epochs": 1, name: 0})
    with pytest.raises(InputError, match=rf"trainer\.{name}=0: wanted more than 0"):
        train(make_srcnn(), pairs, folder=tmp_path, trainer=trainer, depends_on={})


def test_no_optimizer_is_refused() -> None:
    with pytest.raises(
        InputError, match=r"module\.optimizer=null: wanted module\.optimizer\._targ"
    ):
        try_optimizer(None, "module.optimizer")  # type: ignore[arg-type]  # as the line may say it


def test_a_setting_that_lightning_refuses_is_told(pairs: SyntheticPairs, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"trainer: .*max_epochs"):
        train(
            make_srcnn(),
            pairs,
            folder=tmp_path,
            trainer=partial(quiet, max_epochs=-3),
            depends_on={},
        )


def test_interrupted_run_reaches_the_caller_as_an_interrupt(
    pairs: SyntheticPairs, tmp_path: Path
) -> None:
    module = make_srcnn()
    loss = module.loss

    def impatient(batch: Pair) -> torch.Tensor:
        if module.current_epoch == 1:
            raise KeyboardInterrupt
        return loss(batch)

    module.loss = impatient  # type: ignore[method-assign]
    handler = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        run(pairs, tmp_path, epochs=2, module=module)
    assert signal.getsignal(signal.SIGINT) is handler
    assert (tmp_path / "last.ckpt").is_file()


@pytest.mark.parametrize("seed", [-1, 2**32, 10**20])
@without_export
def test_any_whole_number_is_a_seed(pairs: SyntheticPairs, tmp_path: Path, seed: int) -> None:
    run(pairs, tmp_path, seed=seed, module=make_srcnn(seed=seed))
