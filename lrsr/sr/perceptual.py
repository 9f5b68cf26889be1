"""How far apart do two pictures look? By a network of the user's, such as LPIPS; none ships.

Zhang et al., *The unreasonable effectiveness of deep features as a perceptual metric* (2018). The
network is an ONNX file of two inputs, the pictures, and one output, a number a pair; ``lpips.onnx``
needs ``lpips.toml``::

    sha256 = "…"                # of lpips.onnx
    licence = "BSD-2-Clause"
    source = "https://…"

    [input]
    channels = "RGB"            # or "BGR"
    mean = 127.5                # the network sees (255 srgb - mean) / scale, each a number or
    scale = 127.5               # three, in the order of `channels`; LPIPS itself takes -1 to 1
"""

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import ImageContractError, InputError
from lrsr.images import check_srgb
from lrsr.onnx import PerChannel, contract_path, open_session, providers_on, read_declared

_TABLES = {"": ("sha256", "licence", "source"), "input": ("channels", "mean", "scale")}
_CHOICES = {"input.channels": ("RGB", "BGR")}


@dataclass(frozen=True)
class _Contract:
    """What the network declares; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    channels: str
    mean: PerChannel
    scale: PerChannel


class PerceptualDistance:
    """An ONNX network that says how far apart two pictures look.

    Args:
        model: Path of the ``.onnx`` file; its contract lies beside it.
        device: See :func:`lrsr.onnx.providers_on`.

    Raises:
        InputError: The file or its contract is missing or broken, or it has not two inputs and one
            output of floats.
    """

    def __init__(self, model: Path, *, device: str = "cpu") -> None:
        self.model = model
        self.contract = read_declared(_Contract, model, _TABLES, _CHOICES)
        if np.min(self.contract.scale) <= 0:
            raise InputError(f"{contract_path(model)}: input.scale must be above 0")
        self._session = open_session(model, providers_on(device))
        ends = [*self._session.get_inputs(), *self._session.get_outputs()]
        pictures = [end for end in ends[:2] if len(end.shape) == 4]
        if len(ends) != 3 or len(pictures) != 2 or any(e.type != "tensor(float)" for e in ends):
            told = ", ".join(f"{end.name} {end.type} {end.shape}" for end in ends)
            raise InputError(
                f"{model}: has {told}; wanted two inputs N3HW and one output of floats"
            )

    def __call__(self, srgb_a: torch.Tensor, srgb_b: torch.Tensor) -> NDArray[np.float64]:
        """Measure the distance of each picture from the other of its pair.

        Args:
            srgb_a: ``(B, 3, H, W)`` float32, srgb, [0, 1].
            srgb_b: The same shape.

        Returns:
            ``(B,)``, 0 for equal pictures.

        Raises:
            ImageContractError: The shapes differ, or see :func:`lrsr.images.check_srgb`.
            InputError: The network cannot take pictures of this size, or returns no number a pair.
        """
        if srgb_a.shape != srgb_b.shape:
            got = f"{tuple(srgb_a.shape)} and {tuple(srgb_b.shape)}"
            raise ImageContractError(f"got images of {got}, wanted one shape")
        sides = [self._normalised(images) for images in (srgb_a, srgb_b)]
        return np.array([self._distance(*pair) for pair in zip(*sides, strict=True)])

    def _distance(self, a: NDArray[np.float32], b: NDArray[np.float32]) -> float:
        """Run one pair: graphs for one image at a time take it, too.

        Raises:
            InputError: The network cannot take it, or returns no number.
        """
        names = [end.name for end in self._session.get_inputs()]
        try:
            found = self._session.run(None, dict(zip(names, (a[None], b[None]), strict=True)))[0]
        except Exception as error:  # onnxruntime's own classes share no public base
            why = " ".join(str(error).split())[:160]
            raise InputError(f"{self.model}: cannot take two of {a.shape} ({why})") from error
        if np.size(found) != 1 or not np.isfinite(found).all():
            raise InputError(f"{self.model}: returned {np.shape(found)} for a pair, not a number")
        return float(np.ravel(found)[0])

    def _normalised(self, srgb: torch.Tensor) -> NDArray[np.float32]:
        values = check_srgb(srgb).numpy(force=True) * np.float32(255)
        if self.contract.channels == "BGR":
            values = values[:, ::-1]
        mean, scale = (
            np.asarray(each, dtype=np.float32).reshape(1, -1, 1, 1)
            for each in (self.contract.mean, self.contract.scale)
        )
        return np.ascontiguousarray((values - mean) / scale)

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it; JSON-serialisable."""
        return {"model": self.model.name, **asdict(self.contract)}
