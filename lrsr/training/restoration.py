"""How does any super-resolution network learn? From pairs, by a weighted sum; judged in use."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path
from types import MappingProxyType
from typing import Any, ClassVar

import numpy as np
import torch
from numpy.typing import NDArray
from torch.nn import functional as F

from lrsr.configuration import as_flag, as_mapping, as_number, as_whole, as_word, require
from lrsr.errors import DivergenceError, InputError, NonFiniteError
from lrsr.evaluation.quality import psnr_y
from lrsr.onnx import sha256_of
from lrsr.pictures.recipe import derived_seed
from lrsr.presets import preset, presets
from lrsr.sr.loading import find_weights
from lrsr.sr.networks import NETWORKS
from lrsr.sr.networks.network import Network
from lrsr.sr.upscaler import Bicubic, Luminance, Rgb
from lrsr.sr.weights import ENLARGED_BY, Card, read_weights, write_weights
from lrsr.training.export import export_onnx
from lrsr.training.learner import Learner, MakeOptimizer, MakeScheduler
from lrsr.training.losses.term import Term
from lrsr.training.patches import Patches

_LOSSES: Mapping[str, Callable[[torch.Tensor, torch.Tensor], torch.Tensor]] = {
    "mse": F.mse_loss,
    "l1": F.l1_loss,
}
Pair = tuple[torch.Tensor, torch.Tensor]


class Restoration(Learner):
    """Any network of :mod:`lrsr.sr.networks`, validated through the upscaler that is made of it.

    A training batch is what the network takes and should return, and landmarks where the patches
    tell them, see :mod:`lrsr.training.patches`;
    a validation batch is srgb, ``(1, 3, H, W)`` small and ``(1, 3, scale H, scale W)`` true.

    Args:
        architecture: Name of the network.
        scale: How much larger the result is.
        loss: Of pixels, "mse" or "l1".
        losses: What is added to it, by name; for networks of colours. Each is logged, not weighted.
        optimizer: See :class:`Learner`.
        scheduler: See :class:`Learner`.
        arguments: Of the network's class; they travel with the weights.
        slower: Parts of the network that learn at a fraction of the rate, and the fraction.
        turned: Show each batch turned and mirrored at random; for networks without a border.
        start: Weights to begin with, a file as :func:`lrsr.sr.weights.read_weights` takes it or one
            that ships; None: random ones.
        lr_made_by: How the small images were made, in words; kept with the weights, for they serve
            no other input.
        seed: Of the first weights and of the turning, any whole number.

    Raises:
        InputError: There is no such network, loss or part of the network, it cannot be told more
            than its pixels, or the weights are missing or of another network.
    """

    monitor = "val/psnr_y_db"
    lessons: ClassVar[tuple[str, ...]] = ("rendered", "images", "mixed")
    inputs: ClassVar[tuple[str, ...]] = ("luminance", "rgb")
    """What its networks may take."""
    free: ClassVar[Mapping[int, str]] = MappingProxyType({0: "N", 2: "H", 3: "W"})
    """The sizes of that which may differ."""

    def __init__(
        self,
        *,
        architecture: str,
        scale: int,
        loss: str,
        optimizer: MakeOptimizer,
        scheduler: MakeScheduler | None = None,
        losses: Mapping[str, Term] = MappingProxyType({}),
        arguments: Mapping[str, Any] = MappingProxyType({}),
        slower: Mapping[str, float] = MappingProxyType({}),
        turned: bool = False,
        start: str | None = None,
        lr_made_by: str = "rendered",
        seed: int = 0,
    ) -> None:
        super().__init__(optimizer, scheduler)
        for name, value, known in (
            ("architecture", architecture, NETWORKS),
            ("loss", loss, _LOSSES),
        ):
            if not isinstance(value, str) or value not in known:
                raise InputError(f"module.{name}={value}: wanted one of {', '.join(known)}")
        self.distance, self.turned = _LOSSES[loss], as_flag(turned, "module.turned")
        self.losses = torch.nn.ModuleDict(as_mapping(losses, "module.losses"))
        self.weights = {name: term.weight for name, term in losses.items()}
        self.slower = {part: as_number(s, f"module.slower.{part}") for part, s in slower.items()}
        self.seed = as_whole(seed, "module.seed")
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(derived_seed(seed, "weights"))
            network = NETWORKS[architecture](**arguments)
        if network.input not in self.inputs:
            wish = f"a network of {' or '.join(self.inputs)}"
            raise InputError(f"module.architecture={architecture}: wanted {wish}")
        self.network = network.to(memory_format=torch.channels_last)
        self.card = Card(
            architecture=architecture,
            arguments=dict(arguments),
            scale=as_whole(scale, "module.scale"),
            input=network.input,
            lr_made_by=as_word(lr_made_by, "module.lr_made_by"),
            enlarged_by="" if network.enlarges else ENLARGED_BY,
        )
        if losses and network.input != "rgb":
            got = f"module.losses.{next(iter(losses))}"
            raise InputError(f"{got}: wanted a network of colours; {architecture} has none")
        for part in slower:
            if part not in dict(network.named_children()):
                raise InputError(f"module.slower={part}: {architecture} has no such part")
        self.start = None
        if start is not None:
            self.start = find_weights(Path(as_word(start, "module.start")))
            self._begin_with(self.start)

    def _begin_with(self, path: Path) -> None:
        """Take the weights of a file.

        Raises:
            InputError: They cannot be read, or are of another network.
        """
        network, card = read_weights(path)
        for name in ("architecture", "scale"):
            got, wanted = getattr(card, name), getattr(self.card, name)
            require(got == wanted, "module.start", path, f"{name} {wanted}, it has {got}")
        try:
            self.network.load_state_dict(network.state_dict())
        except RuntimeError as error:
            wish = f"the sizes of module.arguments={dict(self.card.arguments)}"
            raise InputError(
                f"module.start={path}: wanted {wish}, got {dict(card.arguments)}"
            ) from error

    def about(self) -> dict[str, Any]:
        """Return what the weights begin with, by its content."""
        return {} if self.start is None else {"module.start": sha256_of(self.start)}

    def try_patches(self, patches: Patches) -> None:
        """See on random pictures that the network makes what patches want of what they show.

        Raises:
            InputError: It does not.
        """
        if self._takes(patches):
            return
        fit = [name for name in presets("patches") if self._takes(preset("patches", name))]
        name, network = type(patches).__name__, self.card.architecture
        raise InputError(
            f"data.patches._target_={name}: {network} learns from others; give"
            f" patches={' or '.join(fit)}"
        )

    def _takes(self, patches: Patches) -> bool:
        random, scale = torch.Generator().manual_seed(0), self.card.scale
        frames = (2,) if "burst" in self.inputs else ()
        side = patches.least_px(scale)
        small = torch.rand(1, *frames, 3, side, side, generator=random)
        large = torch.rand(1, 3, scale * side, scale * side, generator=random)
        points = torch.full((1, 5, 2), scale * side / 2)
        self.network.eval()
        try:
            with torch.no_grad():
                shown, wanted, *_ = patches.cut(small, large, points)
                return bool(self.network(shown).shape == wanted.shape)
        except (InputError, RuntimeError, ValueError):  # such as of another number of channels
            return False
        finally:
            self.network.train()

    def loss(self, batch: tuple[torch.Tensor, ...]) -> torch.Tensor:
        """Return the pixel loss of ``(B, C, h, w)`` inputs and their targets, and what is added."""
        inputs, targets, *landmarks_px = batch
        shown = self._turn(inputs) if self.turned else inputs
        restored = self.restore(shown).float()
        restored = self._turn(restored, back=True) if self.turned else restored
        total: torch.Tensor = self.distance(restored, targets)
        if not self.losses:
            return total
        with torch.autocast(self.device.type, enabled=False):
            found = {
                name: term(restored, targets, *landmarks_px) for name, term in self.losses.items()
            }
        for name, value in {"pixel": total, **found}.items():
            self.log(f"train/{name}", value, on_step=False, on_epoch=True, batch_size=len(inputs))
        for name, value in found.items():
            total = total + self.weights[name] * value
        return total

    def restore(self, inputs: torch.Tensor) -> torch.Tensor:
        """Run the network on inputs of a batch."""
        restored: torch.Tensor = self.network(inputs.contiguous(memory_format=torch.channels_last))
        return restored

    def _turn(self, images: torch.Tensor, *, back: bool = False) -> torch.Tensor:
        """Turn by quarters and mirror as the step says, or take it back."""
        quarters, mirrored = divmod(derived_seed(self.seed, "turned", self.global_step) % 8, 2)
        if back:
            return torch.rot90(images.flip(-1) if mirrored else images, -quarters, (2, 3))
        turned = torch.rot90(images, quarters, (2, 3))
        return turned.flip(-1) if mirrored else turned

    def parameter_groups(self) -> list[dict[str, Any]]:
        """Return a group for each part that learns more slowly, and one for the rest."""
        rate = as_number(self.make_optimizer.keywords.get("lr"), "module.optimizer.lr")
        groups: list[dict[str, Any]] = [
            {"params": [*self.network.get_submodule(part).parameters()], "lr": rate * share}
            for part, share in self.slower.items()
        ]
        apart = {id(p) for group in groups for p in group["params"]}
        rest = [p for p in self.network.parameters() if id(p) not in apart]
        return [{"params": rest}, *groups]

    def on_validation_start(self) -> None:
        """Make of the network what is made of it in use."""
        kind = type(self.network)
        with torch.device(self.device), torch.random.fork_rng(devices=[]):
            used = kind(**{**self.card.arguments, **kind.in_use})
        used.load_state_dict(self.network.state_dict())
        self._upscaler = self.in_use(used.eval())

    def in_use(self, network: Network) -> Callable[[torch.Tensor], torch.Tensor]:
        """Return what enlarges srgb by a network."""
        wrapper = Luminance if network.input == "luminance" else Rgb
        return wrapper(network, self.card, device=str(self.device))

    def rivals(self, small: torch.Tensor) -> dict[str, torch.Tensor]:
        """Return by name what is made of small pictures without a network, bicubic first."""
        return {"bicubic": Bicubic(self.card.scale)(small)}

    def validation_step(self, batch: Pair, batch_idx: int) -> None:
        """Log PSNR and the gain over bicubic, both on luminance, means over images.

        Raises:
            DivergenceError: A restored image holds a NaN.
            InputError: The pictures cannot be enlarged.
        """
        small, true = batch
        try:
            with torch.autocast(self.device.type, enabled=False):
                restored = self._upscaler(small)
        except InputError as error:
            if not isinstance(error.__cause__, NonFiniteError):
                raise
            raise DivergenceError(
                f"a restored image is NaN at epoch {self.current_epoch}, so the weights diverged;"
                " lower the learning rate"
            ) from error
        figures = {"psnr_y_db": self._psnr_y_db(restored, true)}
        for name, image in self.rivals(small).items():
            figures[f"{name}_psnr_y_db"] = self._psnr_y_db(image, true)
        figures["gain_over_bicubic_db"] = figures["psnr_y_db"] - figures["bicubic_psnr_y_db"]
        for name, value in figures.items():
            self.log(f"val/{name}", float(np.mean(value)), batch_size=len(true))

    def _psnr_y_db(self, image: torch.Tensor, true: torch.Tensor) -> NDArray[np.float64]:
        return psnr_y(image.numpy(force=True), true.numpy(force=True), shave=self.card.scale)

    def in_words(self, figures: Mapping[str, float]) -> str:
        """Tell the PSNR and the gain over bicubic."""
        gain_db = figures["val/gain_over_bicubic_db"]
        return f"PSNR-Y {figures['val/psnr_y_db']:.2f} dB, {gain_db:+.2f} dB over bicubic"

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the history and what the weights are for."""
        super().on_save_checkpoint(checkpoint)
        checkpoint["card"] = self.card.as_text()

    def ship(self, folder: Path, best: Path) -> dict[str, Any]:
        """Write model.safetensors and model.onnx."""
        network, card = read_weights(best)
        write_weights(folder / "model.safetensors", network, card)
        several, one = ((count, *network.takes(24, 20)[1:]) for count in (2, 1))
        export_onnx(
            folder / "model.onnx",
            network,
            shapes=[several, (*one[:-2], 32, 32), (*several[:-2], 13, 40)],
            names=(card.input, "restored"),
            free=self.free,
            about=card.as_text(),
        )
        return {"card": asdict(card)}
