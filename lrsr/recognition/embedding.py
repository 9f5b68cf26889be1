"""What does an ONNX model say about an aligned face? A unit vector per crop."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.images import check_images
from lrsr.recognition.contract import Contract, read_contract


class Embedder:
    """An ONNX face embedder and its contract, on the CPU.

    Args:
        model: Path of the ``.onnx`` file; its contract lies beside it.
        batch_size: Crops per run of the model; a graph with a fixed batch overrules it.

    Raises:
        InputError: The contract is missing, broken or about another file; the file is no ONNX
            model; or its graph disagrees with the contract.
    """

    def __init__(self, model: Path, *, batch_size: int = 64) -> None:
        self.model = model
        self.contract: Contract = read_contract(model)
        self._session = _open_session(model)
        self._input, fixed = _check_graph(self._session, self.contract, model)
        self._fixed = fixed is not None
        self.batch_size = fixed or batch_size

    def __call__(self, crops: torch.Tensor) -> NDArray[np.float32]:
        """Embed aligned faces.

        Args:
            crops: ``(B, 3, height_px, width_px)`` float32, srgb, [0, 1].

        Returns:
            ``(B, dimension)`` float32, each row of length 1.

        Raises:
            ImageContractError: The crops break the contract of :mod:`lrsr.images`.
        """
        if len(crops) == 0:
            return np.empty((0, self.contract.dimension), dtype=np.float32)
        inputs = self._normalise(check_images(crops, name="crops"))
        if self._fixed and (spare := -len(inputs) % self.batch_size):
            inputs = np.concatenate([inputs, np.repeat(inputs[-1:], spare, axis=0)])
        rows = [
            self._run(inputs[start : start + self.batch_size])
            for start in range(0, len(inputs), self.batch_size)
        ]
        return unit_rows(np.concatenate(rows)[: len(crops)])

    def _normalise(self, crops: torch.Tensor) -> NDArray[np.float32]:
        """Turn srgb [0, 1] into what the contract declares."""
        values = (crops.numpy(force=True) * 255.0 - self.contract.mean) / self.contract.scale
        if self.contract.channels == "BGR":
            values = values[:, ::-1]
        if self.contract.layout == "NHWC":
            values = values.transpose(0, 2, 3, 1)
        return np.ascontiguousarray(values, dtype=np.float32)

    def _run(self, batch: NDArray[np.float32]) -> NDArray[np.float32]:
        return np.asarray(self._session.run(None, {self._input: batch})[0], dtype=np.float32)


def unit_rows(vectors: NDArray[np.float32]) -> NDArray[np.float32]:
    """Divide each row by its length; a row of zeros stays zero.

    Example:
        >>> unit_rows(np.array([[3.0, 4.0]], dtype=np.float32)).round(3).tolist()
        [[0.6000000238418579, 0.800000011920929]]
    """
    lengths = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.maximum(lengths, np.finfo(np.float32).tiny), dtype=np.float32)


def _open_session(model: Path) -> Any:
    onnxruntime = importlib.import_module("onnxruntime")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = torch.get_num_threads()
    options.log_severity_level = 3
    try:
        return onnxruntime.InferenceSession(
            str(model), sess_options=options, providers=["CPUExecutionProvider"]
        )
    except Exception as error:  # onnxruntime's own classes share no public base
        reason = " ".join(str(error).split())[:160]
        raise InputError(f"{model}: not a usable ONNX model ({reason}); get it again") from error


def _check_graph(session: Any, contract: Contract, model: Path) -> tuple[str, int | None]:
    """Hold the graph against the contract; return the input's name and its batch, if fixed.

    Raises:
        InputError: They disagree.
    """
    inputs, outputs = session.get_inputs(), session.get_outputs()
    if len(inputs) != 1 or len(outputs) != 1:
        raise InputError(
            f"{model}: has {len(inputs)} inputs and {len(outputs)} outputs; "
            "an embedder has one of each"
        )
    got = inputs[0].shape
    if inputs[0].type != "tensor(float)" or not _agree(got, (None, *contract.input_shape)):
        raise InputError(
            f"{model}: takes {inputs[0].type} {got}, its contract says float {contract.layout} "
            f"{contract.input_shape}; mend the contract or give the model it was written for"
        )
    got = outputs[0].shape
    if not _agree(got, (None, contract.dimension)):
        raise InputError(
            f"{model}: returns {got}, its contract says dimension {contract.dimension}; "
            "mend the contract or give the model it was written for"
        )
    batch = inputs[0].shape[0]
    return inputs[0].name, batch if isinstance(batch, int) and batch > 0 else None


def _agree(got: list[int | str | None], wanted: tuple[int | None, ...]) -> bool:
    """Tell whether a graph's shape (numbers, or names where it is free) can be the wanted one."""
    if len(got) != len(wanted):
        return False
    return all(
        w is None or not isinstance(g, int) or g == w for g, w in zip(got, wanted, strict=True)
    )
