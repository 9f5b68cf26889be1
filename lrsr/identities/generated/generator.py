"""What does somebody's generator of faces take and return? Declared beside it, never sniffed.

``synthesis.onnx`` needs ``synthesis.toml``::

    sha256 = "…"                # of synthesis.onnx
    licence = "…"
    source = "StyleGAN2, FFHQ, 1024 px, exported by …"

    [latent]
    z = 512                     # independent normal numbers that a face is drawn by
    w = 512                     # numbers of the intermediate space; left out: it takes z itself
    layers = 18                 # it takes (N, 18, 512), one w for all; left out: (N, 512)
    mapping = "mapping.onnx"    # beside it, makes (N, w) of (N, z), or (N, any, w), all rows alike
    mapping_sha256 = "…"

    [output]
    channels = "RGB"            # or "BGR"
    layout = "NCHW"             # or "NHWC"
    range = "-1..1"             # or "0..1", "0..255"; what is beyond is clipped

Each network has one input and one output of floats, so StyleGAN2's noise, class and truncation are
exported as constants (``noise_mode="const"``, ``truncation_psi=1``).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.onnx import (
    check_graph,
    contract_path,
    open_session,
    providers_on,
    read_declared,
    run_session,
    sha256_of,
)

Latents = NDArray[np.float32]

_TABLES = {
    "": ("sha256", "licence", "source"),
    "latent": ("z", "w", "layers", "mapping", "mapping_sha256"),
    "output": ("channels", "layout", "range"),
}
_CHOICES = {
    "latent.z": range(1, 65537),
    "latent.w": range(65537),
    "latent.layers": range(1025),
    "output.channels": ("RGB", "BGR"),
    "output.layout": ("NCHW", "NHWC"),
    "output.range": ("-1..1", "0..1", "0..255"),
}
_BLACK_WHITE = {"-1..1": (-1.0, 1.0), "0..1": (0.0, 1.0), "0..255": (0.0, 255.0)}
_MEAN_OF, _BATCH = 10_000, 1000
"""Of how many w the mean is taken, as StyleGAN2's own projector does; how many at once."""
_MEAN_SEED = 123
_ALIKE = 1e-4
"""Rows of a w that differ by no more of its standard deviation are the same but for rounding."""
_REPEATED = 0.01
"""The same of two pictures of one w, of the way from black to white."""


@dataclass(frozen=True, kw_only=True)
class _GeneratorContract:
    """A generator's declared contract; see the module for the meaning of each field."""

    sha256: str
    licence: str
    source: str
    z: int
    w: int = 0
    layers: int = 0
    mapping: str = ""
    mapping_sha256: str = ""
    channels: str
    layout: str
    range: str


class Generator:
    """A network that draws faces, and the space in which they are changed: w, or z without a w.

    Args:
        model: The ONNX file that makes pictures, with its contract beside it.
        device: Where it runs; see :func:`lrsr.onnx.providers_on`.

    Raises:
        InputError: A file or the contract is missing, broken or about something else, or the same
            numbers make another picture each time.
    """

    def __init__(self, model: Path, *, device: str = "cpu") -> None:
        self.model, providers = model, providers_on(device)
        self.contract = contract = _read_generator_contract(model)
        self.size = contract.w or contract.z
        rows = (contract.layers,) if contract.layers else ()
        self._session = open_session(model, providers)
        sides = (3, None, None) if contract.layout == "NCHW" else (None, None, 3)
        words = (f"(N, {', '.join(map(str, (*rows, self.size)))})", contract.layout)
        takes = (None, *rows, self.size)
        check_graph(self._session, model, "a generator", takes, (None, *sides), words)
        self._mapping: tuple[Any, Path] | None = None
        if contract.w:
            self._mapping = self._open_mapping(model.with_name(contract.mapping), providers)
        self._check_repeats()

    def _open_mapping(self, file: Path, providers: Sequence[str]) -> tuple[Any, Path]:
        session, contract = open_session(file, providers), self.contract
        if (digest := sha256_of(file)) != contract.mapping_sha256:
            raise InputError(
                f"{file}: sha256 is {digest[:12]}…, latent.mapping_sha256 of"
                f" {contract_path(self.model)} says {contract.mapping_sha256[:12] or 'nothing'}"
            )
        layered = len(session.get_outputs()[0].shape) == 3
        returns = (None, None, contract.w) if layered else (None, contract.w)
        words = (f"z = {contract.z}", f"w = {contract.w}")
        check_graph(session, file, "a mapping network", (None, contract.z), returns, words)
        return session, file

    def _check_repeats(self) -> None:
        latent = self.sample([(0, 0)])
        first, second = self._run(latent), self._run(latent)
        black, white = _BLACK_WHITE[self.contract.range]
        if np.abs(second - first).max() > _REPEATED * (white - black):
            raise InputError(
                f"{self.model}: makes another picture of the same numbers each time; export it"
                ' without random noise, such as StyleGAN2 with noise_mode="const"'
            )

    def sample(self, seeds: Sequence[tuple[int, ...]], truncation: float = 1.0) -> Latents:
        """Draw people.

        Args:
            seeds: For each person the numbers that seed :func:`numpy.random.default_rng`.
            truncation: Psi: how far each is from the mean w, 1 as drawn, 0 at it.

        Returns:
            ``(n, D)`` in the space in which faces are changed.

        Raises:
            InputError: There is a truncation and no w.
        """
        drawn = [np.random.default_rng(seed).standard_normal(self.contract.z) for seed in seeds]
        latents = self._mapped(np.stack(drawn).astype(np.float32), 1)
        if truncation == 1:
            return latents
        if self._mapping is None:
            raise InputError(
                f"truncation={truncation:g}: wanted 1, as {self.model} has no mapping network"
            )
        return (self._mean + np.float32(truncation) * (latents - self._mean)).astype(np.float32)

    @cached_property
    def _mean(self) -> Latents:
        """The mean w, ``(D,)``."""
        drawn = np.random.default_rng(_MEAN_SEED).standard_normal((_MEAN_OF, self.contract.z))
        mapped = self._mapped(drawn.astype(np.float32), _BATCH)
        mean: Latents = mapped.mean(axis=0, dtype=np.float64).astype(np.float32)
        return mean

    def _mapped(self, drawn: Latents, batch_size: int) -> Latents:
        """Return w of z; a batch's size decides about last digits, so people are mapped singly.

        Raises:
            InputError: The mapping network returns something else.
        """
        if self._mapping is None:
            return drawn
        session, file = self._mapping
        mapped = run_session(session, file, drawn, batch_size=batch_size)
        if mapped.ndim == 2:
            return mapped
        if np.ptp(mapped, axis=1).max() > _ALIKE * mapped.std():
            raise InputError(
                f"{file}: returns another w for each layer; export it with truncation_psi=1"
            )
        return mapped[:, 0]

    def pictures(self, latents: Latents) -> NDArray[np.uint8]:
        """Make pictures ``(n, H, W, 3)``, RGB, srgb, of latents ``(n, D)``; n > 0.

        Raises:
            InputError: The network cannot take them.
        """
        black, white = _BLACK_WHITE[self.contract.range]
        made = (self._run(latents) - black) * (255 / (white - black))
        if self.contract.layout == "NCHW":
            made = made.transpose(0, 2, 3, 1)
        if self.contract.channels == "BGR":
            made = made[..., ::-1]
        return np.ascontiguousarray(np.clip(np.rint(made), 0, 255).astype(np.uint8))

    def _run(self, latents: Latents) -> NDArray[np.float32]:
        if layers := self.contract.layers:
            latents = np.repeat(latents[:, None], layers, axis=1)
        return run_session(self._session, self.model, latents, batch_size=1)

    def describe(self) -> dict[str, object]:
        """Return what a report must say of it; JSON-serialisable."""
        names = ("sha256", "mapping_sha256", "licence", "source")
        return {"model": self.model.name} | {name: getattr(self.contract, name) for name in names}


def _read_generator_contract(model: Path) -> _GeneratorContract:
    """Read the contract beside ``model`` and check the model's bytes against its sha256.

    Raises:
        InputError: Model or contract is missing or unreadable; a field is missing, unknown or out
            of range; or the model is not the one that the contract was written for.
    """
    contract = read_declared(_GeneratorContract, model, _TABLES, _CHOICES)
    path = contract_path(model)
    if bool(contract.w) != bool(contract.mapping):
        raise InputError(f"{path}: latent.w and latent.mapping go together; give both or neither")
    if contract.layers and not contract.w:
        raise InputError(f"{path}: latent.layers = {contract.layers}; wanted none without a w")
    if Path(contract.mapping).name != contract.mapping:
        raise InputError(f"{path}: latent.mapping = {contract.mapping!r}; wanted a file beside it")
    return contract
