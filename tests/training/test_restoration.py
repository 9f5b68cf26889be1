import math

import pytest
import torch
from lightning.pytorch import LightningDataModule, Trainer
from lrsr.sr.module import SRCNNModule

from lrsr.errors import NonFiniteError


@pytest.fixture
def module() -> SRCNNModule:
    return SRCNNModule(scale=2)


def make_trainer(**settings: object) -> Trainer:
    return Trainer(
        accelerator="cpu",
        logger=False,
        enable_checkpointing=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        num_sanity_val_steps=0,
        **settings,
    )


def test_defaults_are_the_papers_rates_one_tenth_in_the_last_layer(module: SRCNNModule) -> None:
    assert module.learning_rates == (1e-3, 1e-4)


def test_hyper_parameters_are_numbers_and_strings(module: SRCNNModule) -> None:
    assert all(isinstance(value, int | float | str) for value in module.hparams.values())


def test_same_seed_gives_the_same_first_weights_whatever_ran_before() -> None:
    first = SRCNNModule(scale=2, seed=5)
    torch.rand(100)
    second = SRCNNModule(scale=2, seed=5)
    other = SRCNNModule(scale=2, seed=6)
    assert torch.equal(first.network.map.weight, second.network.map.weight)
    assert not torch.equal(first.network.map.weight, other.network.map.weight)


def test_making_a_module_leaves_the_global_generator_alone() -> None:
    torch.manual_seed(0)
    expected = torch.rand(1)
    torch.manual_seed(0)
    SRCNNModule(scale=2, seed=9)
    assert torch.equal(torch.rand(1), expected)


@pytest.mark.filterwarnings("ignore:.*many workers|.*LeafSpec|.*logging interval")
def test_rates_fall_by_a_cosine_to_zero(module: SRCNNModule, pairs: LightningDataModule) -> None:
    rates = []

    class Recording(SRCNNModule):
        def on_train_batch_start(self, batch: object, batch_idx: int) -> None:
            rates.append([group["lr"] for group in self.optimizers().param_groups])

    trainer = make_trainer(max_epochs=2)
    trainer.fit(Recording(scale=2), datamodule=pairs)
    steps = trainer.global_step
    expected = [0.5 * (1 + math.cos(math.pi * step / steps)) for step in range(steps)]
    assert [first for first, _ in rates] == pytest.approx([1e-3 * e for e in expected])
    assert [last for _, last in rates] == pytest.approx([1e-4 * e for e in expected])


def test_rates_stay_where_no_decay_is_asked_for() -> None:
    optimizer = SRCNNModule(scale=2, decay="none").configure_optimizers()
    assert isinstance(optimizer, torch.optim.Adam)
    assert [group["lr"] for group in optimizer.param_groups] == [1e-3, 1e-4]


def test_nan_in_validation_stops_the_run(module: SRCNNModule) -> None:
    make_trainer(max_epochs=1).strategy.connect(module)
    module.trainer = make_trainer(max_epochs=1)
    with torch.no_grad():
        module.network.map.bias.fill_(float("nan"))
    with pytest.raises(NonFiniteError, match="a restored image is NaN at epoch 0"):
        module.validation_step((torch.rand(1, 1, 32, 32), torch.rand(1, 1, 32, 32)), 0)
