import numpy as np
import pytest
import torch
from lrsr.recognition.arcface import ArcFaceModule, verification_aucs

from lrsr.errors import NonFiniteError


def toy_batch(people: int = 6, views: int = 2) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    generator = torch.Generator().manual_seed(0)
    tones = torch.rand(people, 3, 5, 5, generator=generator)
    faces = torch.nn.functional.interpolate(tones, size=(112, 112), mode="bilinear")
    crops = faces.mul(255).to(torch.uint8).repeat_interleave(views, dim=0)
    who = torch.arange(people).repeat_interleave(views)
    return crops, who, torch.ones(len(who), dtype=torch.bool)


def step(module: ArcFaceModule) -> torch.Tensor:
    module.log = lambda *_, **__: None  # type: ignore[method-assign]  # there is no trainer here
    return module.training_step(toy_batch(), 0)


def test_training_steps_reduce_the_loss() -> None:
    module = ArcFaceModule(6, steps=10, seed=1)
    made = module.configure_optimizers()
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
    one, two = ArcFaceModule(3, 9, seed=1), ArcFaceModule(3, 9, seed=1)
    assert torch.equal(torch.get_rng_state(), before)
    for (name, a), b in zip(one.state_dict().items(), two.state_dict().values(), strict=True):
        assert torch.equal(a, b), name


def test_norms_and_biases_do_not_decay() -> None:
    groups = ArcFaceModule(3, 9).configure_optimizers()["optimizer"].param_groups
    assert [group["weight_decay"] for group in groups] == [0.05, 0.0]
    assert all(p.ndim > 1 for p in groups[0]["params"])
    assert all(p.ndim == 1 for p in groups[1]["params"])


def test_a_loss_that_is_no_number_stops_the_training() -> None:
    module = ArcFaceModule(6, steps=9)
    with torch.no_grad():
        module.head.directions.fill_(torch.nan)
    with pytest.raises(NonFiniteError, match="training loss is nan at step 0"):
        step(module)


def test_aucs_are_of_everybody_against_everybody() -> None:
    gallery = np.eye(3, dtype=np.float32)
    swapped = gallery[[1, 0, 2]]
    aucs = verification_aucs({"gallery": gallery, "ipd64": gallery, "ipd8": swapped})
    # genuine 0, 0, 1; impostor 1, 1, 0, 0, 0, 0: (4/2 + 4/2 + 4 + 2/2) of 18 pairs
    assert aucs["auc_ipd8"] == pytest.approx(9 / 18)
    assert aucs["auc"] == pytest.approx((1 + 9 / 18) / 2)
