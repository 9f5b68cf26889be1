"""What does an ONNX model say about an aligned face? A unit vector per crop."""

from pathlib import Path

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.images import check_srgb
from lrsr.onnx import check_graph, open_session, providers_on, run_session
from lrsr.recognition.contract import Contract, read_contract


class Embedder:
    """An ONNX face embedder and its contract.

    Args:
        model: Path of the ``.onnx`` file; its contract lies beside it.
        batch_size: Crops per run of the model; a graph with a fixed batch overrules it.
        device: See :func:`lrsr.onnx.providers_on`.

    Raises:
        InputError: The contract is missing, broken or about another file; the file is no ONNX
            model; or its graph disagrees with the contract.
    """

    def __init__(self, model: Path, *, batch_size: int = 64, device: str = "cpu") -> None:
        self.model = Path(model)  # a notebook may give a word
        self.contract: Contract = read_contract(self.model)
        self.batch_size = batch_size
        self._session = open_session(self.model, providers_on(device))
        shape, dimension = self.contract.input_shape, self.contract.dimension
        words = f"float {self.contract.layout} {shape}", f"dimension {dimension}"
        ends = (None, *shape), (None, dimension)
        check_graph(self._session, self.model, "an embedder", *ends, words, self.contract.name)

    @property
    def providers(self) -> tuple[str, ...]:
        """Who computes, by onnxruntime's names, in order of preference."""
        return tuple(self._session.get_providers())

    def __call__(self, crops: torch.Tensor) -> NDArray[np.float32]:
        """Embed aligned faces.

        Args:
            crops: ``(B, 3, height_px, width_px)`` float32, srgb, [0, 1].

        Returns:
            ``(B, dimension)`` float32, each row of length 1.

        Raises:
            ImageContractError: The crops break the contract of :mod:`lrsr.images`, lie outside
                [0, 1] or need a gradient, which would end here.
            InputError: The model cannot take them.
        """
        if len(crops) == 0:
            return np.empty((0, self.contract.dimension), dtype=np.float32)
        inputs = self._normalise(check_srgb(crops, name="crops"))
        size, output = self.batch_size, self.contract.name
        rows = run_session(self._session, self.model, inputs, batch_size=size, output=output)
        return _unit_rows(rows)

    def _normalise(self, crops: torch.Tensor) -> NDArray[np.float32]:
        """Turn srgb [0, 1] into what the contract declares."""
        return np.ascontiguousarray(self.contract.prepare(crops).numpy(force=True))


def _unit_rows(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Divide each row by its length; a row of zeros stays zero.

    Example:
        >>> _unit_rows(np.array([[3.0, 4.0]], dtype=np.float32)).round(3).tolist()
        [[0.6000000238418579, 0.800000011920929]]
    """
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, np.finfo(np.float32).tiny), dtype=np.float32)
