import hashlib
import math
import shutil
from functools import partial
from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.lessons import SyntheticPairs, make_edsr, make_srcnn
from lightning.pytorch import Trainer
from safetensors.torch import load_file

from lrsr.errors import DivergenceError, InputError
from lrsr.paths import asset
from lrsr.presets import preset, presets
from lrsr.training.losses.term import Term
from lrsr.training.restoration import Restoration


class Brightness(Term):
    """How much brighter the restored picture is, and whether landmarks came along."""

    def __init__(self, weight: float) -> None:
        super().__init__("brightness", weight)
        self.seen: list[torch.Tensor | None] = []

    def forward(
        self,
        restored: torch.Tensor,
        targets: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> torch.Tensor:
        self.seen.append(landmarks_px)
        return restored.mean() - targets.mean()


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


def test_the_papers_rates_are_one_tenth_in_the_last_layer() -> None:
    optimizer: Any = make_srcnn(scheduler=None).configure_optimizers()
    rates = {id(p): group["lr"] for group in optimizer.param_groups for p in group["params"]}
    network: Any = make_srcnn().network
    assert sorted(group["lr"] for group in optimizer.param_groups) == [1e-4, 1e-3]
    assert len(rates) == len(list(network.parameters()))


def test_same_seed_gives_the_same_first_weights_whatever_ran_before() -> None:
    first: Any = make_srcnn(seed=5)
    torch.rand(100)
    second: Any = make_srcnn(seed=5)
    other: Any = make_srcnn(seed=6)
    assert torch.equal(first.network.map.weight, second.network.map.weight)
    assert not torch.equal(first.network.map.weight, other.network.map.weight)


def test_making_a_module_leaves_the_global_generator_alone() -> None:
    torch.manual_seed(0)
    expected = torch.rand(1)
    torch.manual_seed(0)
    make_srcnn(seed=9)
    assert torch.equal(torch.rand(1), expected)


@pytest.mark.filterwarnings("ignore:.*many workers|.*LeafSpec|.*logging interval")
def test_rates_fall_by_a_cosine_to_zero(pairs: SyntheticPairs) -> None:
    rates = []

    class Recording(Restoration):
        def on_train_batch_start(self, batch: object, batch_idx: int) -> None:
            optimizer: Any = self.optimizers()
            rates.append([group["lr"] for group in optimizer.param_groups])

    trainer, module = make_trainer(max_epochs=2), make_srcnn()
    module.__class__ = Recording
    trainer.fit(module, datamodule=pairs)
    steps = trainer.global_step
    expected = [0.5 * (1 + math.cos(math.pi * step / steps)) for step in range(steps)]
    assert [first for first, _ in rates] == pytest.approx([1e-3 * e for e in expected])
    assert [last for _, last in rates] == pytest.approx([1e-4 * e for e in expected])


def test_rates_stay_where_no_decay_is_asked_for() -> None:
    optimizer = make_srcnn(scheduler=None).configure_optimizers()
    assert isinstance(optimizer, torch.optim.Adam)
    assert [group["lr"] for group in optimizer.param_groups] == [1e-3, 1e-4]


def test_a_schedule_of_a_length_of_its_own_keeps_it() -> None:
    module = make_srcnn(scheduler=partial(torch.optim.lr_scheduler.CosineAnnealingLR, T_max=7))
    module.trainer = make_trainer(max_epochs=1)
    made: Any = module.configure_optimizers()
    assert made["lr_scheduler"]["scheduler"].T_max == 7


def test_nan_in_validation_stops_the_run() -> None:
    module: Any = make_srcnn()
    module.trainer = make_trainer(max_epochs=1)
    with torch.no_grad():
        module.network.map.bias.fill_(float("nan"))
    module.on_validation_start()
    with pytest.raises(DivergenceError, match=r"restored image is NaN at epoch 0.*lower the"):
        module.validation_step((torch.rand(1, 3, 16, 16), torch.rand(1, 3, 32, 32)), 0)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"loss": "l3"}, "module.loss=l3: wanted one of mse, l1"),
        ({"architecture": "swinir"}, "module.architecture=swinir: wanted one of"),
        ({"losses": {"new": Brightness(2)}}, "module.losses.new: wanted a network of colours"),
        ({"losses": [1]}, r"module.losses=\[1\]: wanted module.losses.SETTING"),
        ({"slower": {"tail": 0.1}}, "module.slower=tail: srcnn has no such part"),
    ],
    ids=["loss", "network", "luminance", "losses", "part"],
)
def test_an_impossible_setting_is_refused(wrong: dict[str, Any], message: str) -> None:
    settings: dict[str, Any] = {"architecture": "srcnn", "scale": 2, "loss": "mse"}
    with pytest.raises(InputError, match=message):
        Restoration(optimizer=partial(torch.optim.Adam, lr=1.0), **{**settings, **wrong})


def starting(start: str, **settings: Any) -> Restoration:
    known: dict[str, Any] = {"architecture": "srcnn", "scale": 2, "loss": "mse"}
    adam: Any = partial(torch.optim.Adam, lr=1e-4)
    return Restoration(optimizer=adam, start=start, **{**known, **settings})


def test_a_start_is_what_the_network_has_learned_before(tmp_path: Path) -> None:
    name = "weights/srcnn2x.safetensors"
    path = asset(name)
    shutil.copy(path, tmp_path / "moved.safetensors")
    shipped, moved = starting(name), starting(str(tmp_path / "moved.safetensors"))
    learned = load_file(path)
    assert learned.keys() == shipped.network.state_dict().keys()
    for name, value in shipped.network.state_dict().items():
        assert torch.equal(value, learned[name]), name
    assert all(p.requires_grad for p in shipped.network.parameters())
    content = hashlib.sha256(path.read_bytes()).hexdigest()
    assert shipped.about() == moved.about() == {"module.start": content}
    assert make_srcnn().about() == {}


@pytest.mark.parametrize(
    ("start", "settings", "message"),
    [
        (
            "none.ckpt",
            {},
            r"none\.ckpt is missing: give a \.safetensors or \.ckpt file of lrsr",
        ),
        ("weights/srcnn4x.safetensors", {}, r"module\.start=.*4x.*: wanted scale 2, it has 4"),
        ("weights/fsrcnn2x_camera.safetensors", {}, "wanted architecture srcnn, it has fsrcnn"),
        (
            "weights/srcnn2x.safetensors",
            {"arguments": {"mapping_px": 5}},
            r"module\.start=.*: wanted the sizes of module\.arguments=.*5.*, got",
        ),
    ],
    ids=["missing", "scale", "network", "sizes"],
)
def test_a_start_of_another_network_is_refused(
    start: str, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        starting(start, **settings)


def test_the_absolute_error_is_a_choice() -> None:
    zeros = torch.zeros(1, 3, 16, 16)
    module = make_edsr()
    module.network = torch.nn.Upsample(scale_factor=2)  # type: ignore[assignment]
    assert float(module.loss((zeros, torch.full((1, 3, 32, 32), 0.5)))) == pytest.approx(0.5)


def test_the_sum_is_weighted_and_each_term_is_logged_as_it_is(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    term, logged = Brightness(0.25), {}
    monkeypatch.setattr(
        Restoration, "log", lambda _, name, value, **__: logged.update({name: value})
    )
    module = make_edsr(losses={"brightness": term})
    module.network = torch.nn.Upsample(scale_factor=2)  # type: ignore[assignment]
    landmarks_px = torch.zeros(1, 5, 2)
    batch = (torch.full((1, 3, 8, 8), 0.75), torch.full((1, 3, 16, 16), 0.25), landmarks_px)
    assert float(module.loss(batch)) == pytest.approx(0.5 + 0.25 * 0.5)
    assert logged == {"train/pixel": pytest.approx(0.5), "train/brightness": pytest.approx(0.5)}
    module.loss(batch[:2])
    assert [seen is landmarks_px for seen in term.seen] == [True, False]


def test_the_network_sees_eight_views_and_is_judged_on_the_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    seen: list[torch.Tensor] = []

    class Doubling(torch.nn.Module):
        def forward(self, images: torch.Tensor) -> torch.Tensor:
            seen.append(images)
            return images.repeat_interleave(2, 2).repeat_interleave(2, 3)

    module = make_edsr(turned=True)
    module.network = Doubling()  # type: ignore[assignment]
    small = torch.rand(2, 3, 4, 6, generator=torch.Generator().manual_seed(0))
    true = small.repeat_interleave(2, 2).repeat_interleave(2, 3)
    for step in range(40):
        monkeypatch.setattr(Restoration, "global_step", step)
        assert float(module.loss((small, true))) == 0
        assert float(module.loss((small, true.flip(-1)))) > 0
    views = {(tuple(one.shape), *one.flatten().tolist()) for one in seen}
    assert len(views) == 8
    torch.testing.assert_close(seen[0], seen[1])  # of the same step


@pytest.mark.parametrize(
    ("network", "takes"), [("srcnn", {"luminance"}), ("edsr", {"rgb", "faces"})]
)
def test_patches_of_another_network_are_refused(network: str, takes: set[str]) -> None:
    module = {"srcnn": make_srcnn, "edsr": make_edsr}[network]()
    before = {name: weight.clone() for name, weight in module.state_dict().items()}
    for name in presets("patches"):
        patches = preset("patches", name)
        if name in takes:
            module.try_patches(patches)
            continue
        with pytest.raises(InputError, match=f"{network} learns from others; give patches="):
            module.try_patches(patches)
    assert module.network.training
    assert all(bool((before[k] == weight).all()) for k, weight in module.state_dict().items())
