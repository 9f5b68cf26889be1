"""How does an ONNX network enlarge? As its contract says, in tiles where it takes one size only."""

from collections.abc import Mapping
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.configuration import as_mapping
from lrsr.errors import InputError
from lrsr.onnx import check_graph, open_session, providers_on, run_session
from lrsr.sr.contract import read_contract
from lrsr.sr.tiles import run_in_tiles
from lrsr.sr.upscaler import OfNetwork
from lrsr.sr.weights import ENLARGED_BY

_FARTHEST = 4.0
"""No restored value lies so far from black, where white is 1: it overshoots by a tenth."""


class Onnx(OfNetwork):
    """An ONNX network: somebody's with its contract, or one that ``lrsr train`` made.

    Args:
        model: The ``.onnx`` file; see :mod:`lrsr.sr.contract`.
        label: Its name in tables; the file's when None.
        contract: Fields of a contract by name, where none lies beside the file.
        device: "cpu", or "cuda" where onnxruntime has it.

    Raises:
        InputError: The file or its contract is missing or broken, or they disagree.
    """

    def __init__(
        self,
        model: Path | str,
        label: str | None = None,
        contract: Mapping[str, Any] | None = None,
        *,
        device: str = "cpu",
    ) -> None:
        self._model = Path(str(model)).expanduser()
        self._session = open_session(self._model, providers_on(device))
        properties = self._session.get_modelmeta().custom_metadata_map
        typed = as_mapping(contract or {}, "sr.contract")
        self.contract = told = read_contract(self._model, properties, typed)
        words = f"float {told.layout} of {told.channels}"
        check_graph(
            self._session, self._model, "an upscaler", told.shape, told.shape, (words, words)
        )
        self._on_luminance, self._enlarged = told.channels == "Y", told.enlarged
        kernel = ENLARGED_BY if self._enlarged or self._on_luminance else ""
        about = {"kind": "onnx", "file": self._model.name, "sha256": told.sha256, "kernel": kernel}
        about |= {"architecture": told.source, "lr_made_by": told.lr_made_by}
        super().__init__(label or self._model.stem, told.scale, "cpu", **about)
        shape = self._session.get_inputs()[0].shape
        self._fixed = shape[2:] if told.layout == "NCHW" else shape[1:3]
        sides = [size for size in self._fixed if isinstance(size, int)]
        self.reach_px = self._reach(max(sides) // 4 if sides else told.reach_px)
        self.multiple_of = told.multiple_of

    def _restore(self, images: torch.Tensor) -> torch.Tensor:
        many = self.contract.multiple_of
        height, width = (
            size if isinstance(size, int) else many * ceil(have / many)
            for size, have in zip(self._fixed, images.shape[-2:], strict=True)
        )
        factor = 1 if self._enlarged else self.scale
        return run_in_tiles(images, self._run, tile_px=(height, width), factor=factor)

    def _run(self, images: torch.Tensor) -> torch.Tensor:
        """Run the network on (B, C, h, w), as the contract says.

        Raises:
            InputError: What it returns is no picture of the declared range.
        """
        told = self.contract
        given = images.flip(1) if told.channels == "BGR" else images
        given = given.permute(0, 2, 3, 1) if told.layout == "NHWC" else given
        values = np.ascontiguousarray((given * told.white).numpy())
        got = run_session(self._session, self._model, values, batch_size=self.batch_size)
        result = torch.from_numpy(got) / told.white
        if not result.abs().max() <= _FARTHEST:
            raise InputError(
                f"{self._model}: returned values to {float(np.abs(got).max()):g}, its contract says"
                f" {told.range}; mend the contract's range or give another network"
            )
        result = result.permute(0, 3, 1, 2) if told.layout == "NHWC" else result
        return result.flip(1) if told.channels == "BGR" else result
