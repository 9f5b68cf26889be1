"""Every file that ``lrsr train sr=...`` and the experiments read builds what it names."""

from pathlib import Path
from typing import Any

import pytest
from hydra import compose, initialize_config_dir
from hydra.utils import instantiate
from lightning.pytorch.callbacks import ModelCheckpoint
from lrsr.sr.module import SRCNNModule
from lrsr.sr.training import EPOCHS
from omegaconf import DictConfig, OmegaConf

from lrsr.paths import config_folder


def compose_training(sr: str) -> DictConfig:
    """Compose the groups of a training run without the rest of the configuration."""
    with initialize_config_dir(str(config_folder()), version_base="1.3"):
        groups = [f"+sr={sr}", "+trainer=default", "+callbacks=default", "+logger=csv"]
        return compose(overrides=[*groups, "+seed=3"])


@pytest.mark.parametrize(
    ("name", "method"),
    [
        ("none", "base"),
        ("bicubic2", "bicubic2"),
        ("bicubic4", "bicubic4"),
        ("srcnn2x", "srcnn2"),
        ("srcnn2x2", "srcnn2x2"),
        ("srcnn4x", "srcnn4"),
    ],
)
def test_every_sr_option_builds_its_upscaler(name: str, method: str) -> None:
    assert instantiate(compose_training(name).sr.upscaler).method == method


def test_every_sr_option_is_tested() -> None:
    names = {path.stem for path in Path(config_folder(), "sr").glob("*.yaml")}
    assert names == {"none", "bicubic2", "bicubic4", "srcnn2x", "srcnn2x2", "srcnn4x"}


@pytest.mark.parametrize(("name", "scale"), [("srcnn2x", 2), ("srcnn4x", 4)])
def test_training_options_are_the_papers(name: str, scale: int) -> None:
    config = compose_training(name)
    assert config.sr.epochs == EPOCHS[scale]
    assert config.sr.batch_size == 128
    module = instantiate(config.sr.module)
    assert module.recipe.scale == scale
    assert module.hparams["seed"] == 3


@pytest.mark.parametrize("name", ["srcnn2x", "srcnn4x"])
def test_training_options_repeat_the_modules_own_defaults(name: str) -> None:
    config = OmegaConf.to_container(compose_training(name).sr.module, resolve=True)
    assert isinstance(config, dict)
    given: dict[str, Any] = {str(key): value for key, value in config.items()}
    defaults = dict(SRCNNModule(scale=given["scale"], seed=3).hparams)
    assert {key: defaults[key] for key in given if key != "_target_"} == {
        key: value for key, value in given.items() if key != "_target_"
    }


def test_callbacks_keep_the_best_and_the_last_epoch() -> None:
    callbacks = instantiate(compose_training("srcnn4x").callbacks)
    kept = [c.filename for c in callbacks.values() if isinstance(c, ModelCheckpoint)]
    assert kept == ["best", "last"]
    assert callbacks["best"].monitor == "val/psnr_y_db"


def test_trainer_runs_the_options_number_of_epochs(tmp_path: Path) -> None:
    config = compose_training("srcnn4x")
    trainer = instantiate(config.trainer)(
        accelerator="cpu", logger=False, default_root_dir=str(tmp_path), enable_progress_bar=False
    )
    assert trainer.max_epochs == 40


def test_logger_writes_below_the_run_folder(tmp_path: Path) -> None:
    logger = instantiate(compose_training("srcnn4x").logger)["csv"](save_dir=str(tmp_path))
    assert Path(logger.log_dir) == tmp_path / "csv" / "version_0"
