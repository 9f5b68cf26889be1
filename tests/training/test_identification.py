from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from fakes.lessons import make_arcface

from lrsr.errors import InputError, NonFiniteError
from lrsr.training.degradation import Degradation
from lrsr.training.identification import Identification, _verification_aucs
from lrsr.training.shrinking.clean import Clean


def toy_batch(people: int = 6, views: int = 2) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    tones = torch.rand(people, 3, 5, 5, generator=generator)
    faces = torch.nn.functional.interpolate(tones, size=(112, 112), mode="bilinear")
    crops = faces.mul(255).to(torch.uint8).repeat_interleave(views, dim=0)
    who = torch.arange(people).repeat_interleave(views)
    return crops, who, torch.ones(len(who), dtype=torch.bool)


def step(module: Identification) -> torch.Tensor:
    module.log = lambda *_, **__: None  # type: ignore[method-assign]  # there is no trainer here
    return module.training_step(toy_batch(), 0)


def test_training_steps_reduce_the_loss() -> None:
    module = make_arcface(6, seed=1)
    module.trainer = SimpleNamespace(estimated_stepping_batches=10, global_step=0)  # type: ignore[assignment]
    made: Any = module.configure_optimizers()
    optimiser, schedule = made["optimizer"], made["lr_scheduler"]["scheduler"]
    losses = []
    for _ in range(10):
        loss = step(module)
        optimiser.zero_grad()
        loss.backward()
        optimiser.step()
        schedule.step()
        losses.append(float(loss.detach()))
    assert losses[-1] < 0.7 * losses[0]


def test_the_seed_makes_the_weights_and_leaves_the_worlds_randomness_alone() -> None:
    torch.manual_seed(5)
    before = torch.get_rng_state()
    one, two = make_arcface(3, seed=1), make_arcface(3, seed=1)
    assert torch.equal(torch.get_rng_state(), before)
    for (name, a), b in zip(one.state_dict().items(), two.state_dict().values(), strict=True):
        assert torch.equal(a, b), name


def test_norms_and_biases_do_not_decay() -> None:
    module = make_arcface(3)
    groups = module.make_optimizer(module.parameter_groups()).param_groups
    assert [group["weight_decay"] for group in groups] == [0.05, 0.0]
    assert all(p.ndim > 1 for p in groups[0]["params"])
    assert all(p.ndim == 1 for p in groups[1]["params"])


def test_a_loss_that_is_no_number_stops_the_training() -> None:
    module = make_arcface(6)
    with torch.no_grad():
        module.head.directions.fill_(torch.nan)
    with pytest.raises(NonFiniteError, match="loss is nan at epoch 0, step 0"):
        step(module)


def test_aucs_are_of_everybody_against_everybody() -> None:
    gallery = np.eye(3, dtype=np.float32)
    swapped = gallery[[1, 0, 2]]
    aucs = _verification_aucs({"gallery": gallery, "ipd64": gallery, "ipd8": swapped})
    # genuine 0, 0, 1; impostor 1, 1, 0, 0, 0, 0: (4/2 + 4/2 + 4 + 2/2) of 18 pairs
    assert aucs["auc_ipd8"] == pytest.approx(9 / 18)
    assert aucs["auc"] == pytest.approx((1 + 9 / 18) / 2)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"scale": 0}, "module.scale=0: wanted a number > 0"),
        ({"margin": 2.0}, "module.margin=2.0: wanted 0 to 1.57"),
    ],
    ids=str,
)
def test_an_impossible_margin_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Identification(
            people=3, optimizer=partial(torch.optim.Adam), degradation=Degradation(), **wrong
        )


def test_a_degradation_for_super_resolution_is_refused() -> None:
    wrong: Any = Clean()
    with pytest.raises(InputError, match="degradation=Clean: wanted photographs, for recognition"):
        Identification(people=3, optimizer=partial(torch.optim.Adam), degradation=wrong)
