import io
import math
from functools import partial
from typing import Any

import numpy as np
import pytest
import torch

from lrsr.errors import InputError
from lrsr.training.losses.adversarial import AdversarialLoss, _relativistic


def made(**changes: Any) -> AdversarialLoss:
    adam = partial(torch.optim.Adam, lr=1e-3)
    return AdversarialLoss(**{"weight": 1, "optimizer": adam, "features": 8, **changes})


def pictures(seed: int, blurred: bool = False) -> torch.Tensor:
    noise = torch.rand(4, 3, 16, 16, generator=torch.Generator().manual_seed(seed))
    return torch.nn.functional.avg_pool2d(noise, 3, 1, 1) if blurred else noise


def test_the_loss_is_equation_14_of_the_paper() -> None:
    """Cross-entropy of D(real) - E[D(fake)] against 1 and of D(fake) - E[D(real)] against 0."""
    real, fake = np.array([0.3, -1.2, 2.0]), np.array([0.5, 0.1, -0.7])
    as_real = 1 / (1 + np.exp(-(real - fake.mean())))
    as_fake = 1 / (1 + np.exp(-(fake - real.mean())))
    expected = -(np.log(as_real).mean() + np.log(1 - as_fake).mean()) / 2
    found = _relativistic(torch.from_numpy(real), torch.from_numpy(fake))
    assert float(found) == pytest.approx(expected)


def test_who_cannot_tell_says_the_logarithm_of_two() -> None:
    loss = made()
    for parameter in loss.discriminator.parameters():
        torch.nn.init.zeros_(parameter)
    assert float(loss(pictures(0), pictures(0))) == pytest.approx(math.log(2), abs=1e-6)


def test_the_discriminator_learns_to_tell_blurred_from_sharp() -> None:
    loss = made()
    losses = [float(loss(pictures(2 * n, blurred=True), pictures(2 * n + 1))) for n in range(60)]
    assert losses[-1] > 2 * math.log(2)  # of the network that is to deceive it


def test_only_the_picture_gets_a_gradient_of_the_network() -> None:
    loss, restored = made(), pictures(0).requires_grad_()
    judged = loss(restored, pictures(1))
    before = [p.grad.clone() for p in loss.discriminator.parameters() if p.grad is not None]
    judged.backward()
    after = [p.grad for p in loss.discriminator.parameters()]
    assert restored.grad is not None
    assert float(restored.grad.abs().max()) > 0
    assert all(torch.equal(a, b) for a, b in zip(before, after, strict=True) if b is not None)
    assert all(p.requires_grad for p in loss.discriminator.parameters())


def test_from_a_checkpoint_it_goes_on_bit_for_bit() -> None:
    straight, other = made(), made(seed=9)
    for step in range(3):
        straight(pictures(step, blurred=True), pictures(step))
    content = io.BytesIO()
    torch.save(straight.state_dict(), content)
    content.seek(0)
    other.load_state_dict(torch.load(content, weights_only=True))
    for step in range(3, 6):
        expected = straight(pictures(step, blurred=True), pictures(step))
        assert torch.equal(other(pictures(step, blurred=True), pictures(step)), expected)


def test_first_weights_follow_from_the_seed_alone() -> None:
    first, again, other = made(seed=3), made(seed=3), made(seed=4)
    assert torch.equal(first.discriminator[0].weight, again.discriminator[0].weight)
    assert not torch.equal(first.discriminator[0].weight, other.discriminator[0].weight)


def test_it_judges_patches_of_15_pixels() -> None:
    picture = torch.rand(1, 3, 48, 48, requires_grad=True)
    made().discriminator(picture)[0, 0, 6, 6].backward()
    assert picture.grad is not None
    columns = picture.grad.abs().sum((0, 1, 2)).nonzero().flatten()
    assert int(columns.max() - columns.min()) + 1 == 15


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"weight": "much"}, "module.losses.adversarial.weight=much: wanted a number"),
        ({"features": 0}, "module.losses.adversarial.features=0: wanted at least 1"),
        ({"seed": 1.5}, "module.losses.adversarial.seed=1.5: wanted a whole number"),
        (
            {"optimizer": partial(torch.optim.Adam, lr=-1.0)},
            "module.losses.adversarial.optimizer: Invalid learning rate",
        ),
        (
            {"optimizer": partial(torch.optim.Adam, lr="fast")},
            "module.losses.adversarial.optimizer.lr=fast: wanted a number",
        ),
    ],
    ids=["weight", "features", "seed", "rate", "word"],
)
def test_a_wrong_setting_is_named(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        made(**wrong)
