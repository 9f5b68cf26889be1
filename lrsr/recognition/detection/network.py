"""What does an ONNX network find on images that are large enough?"""

from pathlib import Path

import numpy as np
import torch

from lrsr.errors import InputError
from lrsr.onnx import open_session, providers_on, run_lists
from lrsr.recognition.detection.contract import DetectorContract
from lrsr.recognition.detection.decoding import decode
from lrsr.recognition.detection.faces import Array, Detection

_PIXELS = 1 << 21
"""Of all images that go through the network together."""

_INCLUSIVE = ("scrfd", "retinaface_deepface")
"""Kinds whose suppression counts a box's last pixel as part of it."""


class Network:
    """An ONNX detector and its contract.

    Args:
        model: The ``.onnx`` file.
        contract: What it declares.
        device: "cpu", or "cuda" where onnxruntime has it.

    Raises:
        InputError: The file is no ONNX model, or its graph disagrees with the contract.
    """

    def __init__(self, model: Path, contract: DetectorContract, *, device: str = "cpu") -> None:
        self.model, self.contract = model, contract
        self._session = open_session(model, providers_on(device))
        outputs = {output.name: output for output in self._session.get_outputs()}
        for name in contract.names:
            if name not in outputs:
                there = ", ".join(outputs)
                raise InputError(f"{model}: has no output {name}, only {there}; mend its contract")
        inputs = self._session.get_inputs()
        place = 1 if contract.layout == "NCHW" else 3
        shape = inputs[0].shape
        fixed = len(shape) == 4 and isinstance(shape[place], int)
        if len(inputs) != 1 or len(shape) != 4 or (fixed and shape[place] != 3):
            raise InputError(
                f"{model}: takes {[one.shape for one in inputs]}, its contract says one input of"
                f" {contract.layout}; mend the contract or give the model it was written for"
            )
        self._alone = any(len(outputs[name].shape) < 3 for name in contract.names)

    def __call__(self, srgb: torch.Tensor, score_threshold: float) -> list[list[Detection]]:
        """Find faces on images ``(B, 3, H, W)``; the surest first.

        Raises:
            InputError: The network cannot take images of this size.
        """
        contract, (height, width) = self.contract, srgb.shape[-2:]
        batch_size = 1 if self._alone else max(1, _PIXELS // (height * width))
        lists = run_lists(
            self._session,
            self.model,
            self._normalise(srgb),
            contract.names,
            batch_size=batch_size,
        )
        try:
            candidates = decode(contract, lists, height, width)
        except InputError as error:
            raise InputError(f"{self.model}: {error}") from error
        inclusive = contract.kind in _INCLUSIVE
        return candidates.kept(score_threshold, contract.nms_iou, inclusive=inclusive)

    def _normalise(self, srgb: torch.Tensor) -> Array:
        """Turn srgb [0, 1] into what the contract declares."""
        values = srgb.numpy(force=True) * 255.0
        if self.contract.channels == "BGR":
            values = values[:, ::-1]
        mean = np.array(self.contract.mean, dtype=np.float32)[:, None, None]
        values = (values - mean) / self.contract.scale
        if self.contract.layout == "NHWC":
            values = values.transpose(0, 2, 3, 1)
        return np.ascontiguousarray(values, dtype=np.float32)
