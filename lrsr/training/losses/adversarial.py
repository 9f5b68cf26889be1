"""Can the restored picture be told from a true one? A second network learns to, and is deceived."""

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.configuration import as_whole, require
from lrsr.pictures.recipe import derived_seed
from lrsr.training.learner import MakeOptimizer, try_optimizer
from lrsr.training.losses.term import Term

_LEAK = 0.2


class AdversarialLoss(Term):
    """Relativistic average loss (Jolicoeur-Martineau 2018, arXiv:1807.00734) of patches.

    The discriminator says of each patch (Isola et al. 2016, arXiv:1611.07004) how much more real it
    looks than those of the other kind do on average. It learns once in each training step, before
    it judges; its weights and its optimiser's state are part of the checkpoint, so that a resumed
    run goes on bit for bit. It invents what the small picture does not hold: nothing for evidence.

    Args:
        weight: In the sum.
        optimizer: Makes the discriminator's optimiser from its parameters.
        features: Channels of its first layer; the next have two and four times as many.
        seed: Of its first weights, any whole number.

    Raises:
        InputError: A number is out of range, or the optimiser cannot be made.
    """

    def __init__(
        self, *, weight: float, optimizer: MakeOptimizer, features: int = 32, seed: int = 0
    ) -> None:
        super().__init__("adversarial", weight)
        width = as_whole(features, "module.losses.adversarial.features")
        require(width >= 1, "module.losses.adversarial.features", width, "at least 1")
        with torch.random.fork_rng(devices=[]):
            seed = as_whole(seed, "module.losses.adversarial.seed")
            torch.manual_seed(derived_seed(seed, "discriminator"))
            self.discriminator = _discriminator(width)
        try_optimizer(optimizer, "module.losses.adversarial.optimizer")
        self.optimizer = optimizer(self.discriminator.parameters())

    def forward(
        self,
        restored: torch.Tensor,
        targets: torch.Tensor,
        landmarks_px: torch.Tensor | None = None,
    ) -> torch.Tensor:
        """Let the discriminator learn, then return how well it tells; see the base."""
        loss = _relativistic(self.discriminator(targets), self.discriminator(restored.detach()))
        self.optimizer.zero_grad()
        loss.backward()  # type: ignore[no-untyped-call]
        self.optimizer.step()
        self.discriminator.requires_grad_(False)
        judged = _relativistic(self.discriminator(restored), self.discriminator(targets))
        self.discriminator.requires_grad_(True)
        return judged

    def get_extra_state(self) -> dict[str, object]:
        """Return the optimiser's state, which goes into the checkpoint."""
        return self.optimizer.state_dict()

    def set_extra_state(self, state: dict[str, object]) -> None:
        """Take up the optimiser where it stopped."""
        self.optimizer.load_state_dict(state)


def _relativistic(real: torch.Tensor, fake: torch.Tensor) -> torch.Tensor:
    """Return the cross-entropy of what should look more real, and of what should look less so.

    Example:
        >>> round(float(_relativistic(torch.zeros(1), torch.zeros(1))), 4)
        0.6931
    """
    more, less = real - fake.mean(), fake - real.mean()
    return (F.softplus(-more).mean() + F.softplus(less).mean()) / 2


def _discriminator(features: int) -> nn.Sequential:
    """Return a network that judges patches 15 pixels wide, one every fourth pixel."""
    layers: list[nn.Module] = []
    channels = 3
    for width, stride in ((features, 2), (2 * features, 2), (4 * features, 1)):
        layers += [nn.Conv2d(channels, width, 3, stride, 1), nn.LeakyReLU(_LEAK)]
        channels = width
    return nn.Sequential(*layers, nn.Conv2d(channels, 1, 1))
