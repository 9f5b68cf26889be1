"""Weights and somebody's ONNX files, written on the spot."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import onnx
import pytest
import torch
from onnx import TensorProto, helper

from lrsr.onnx import contract_path, sha256_of
from lrsr.sr.networks import NETWORKS
from lrsr.sr.weights import ENLARGED_BY, Card, write_weights

SMALL: dict[str, dict[str, object]] = {
    "srcnn": {},
    "fsrcnn": {"features": 4, "shrunken": 2, "maps": 1},
    "edsr": {"blocks": 1, "features": 8},
    "imdn": {"blocks": 1, "features": 16},
    "sparnet": {"blocks": 1, "features": 8, "large_features": 4, "depth": 1},
    "fusion": {"features": 4},
}
"""Arguments that make a network quick."""


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    """Two threads on a busy machine are slower than one, and round differently."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


def card_of(architecture: str, times: int, **arguments: object) -> Card:
    """A card without errors."""
    kind = NETWORKS[architecture]
    by = "" if kind.enlarges else ENLARGED_BY
    return Card(architecture, arguments, times, kind.input, lr_made_by="test", enlarged_by=by)


@pytest.fixture
def weights_file(tmp_path: Path) -> Callable[..., Path]:
    """Write random weights for a scale; near the identity unless told otherwise."""

    def write(scale: int, initialisation: str = "near-identity") -> Path:
        torch.manual_seed(scale)
        path = tmp_path / f"srcnn{scale}x.safetensors"
        card = card_of("srcnn", scale, initialisation=initialisation)
        write_weights(path, NETWORKS["srcnn"](**card.arguments), card)
        return path

    return write


def _somebodys(
    layout: str, channels: int, scale: int, size: tuple[int | str, int | str], batch: int | str
) -> onnx.ModelProto:
    """Nearest neighbour, and 1, 1/2 and 1/4 of the first, second and third channel."""
    first = layout == "NCHW"
    shape = [batch, channels, *size] if first else [batch, *size, channels]
    times = [1, 1, scale, scale] if first else [1, scale, scale, 1]
    out = [s * t if isinstance(s, int) else f"{s}{t}" for s, t in zip(shape, times, strict=True)]
    gain = np.float32([1.0, 0.5, 0.25])[:channels].reshape((channels, 1, 1) if first else -1)
    graph = helper.make_graph(
        [
            helper.make_node(
                "Resize",
                ["x", "", "times"],
                ["large"],
                mode="nearest",
                nearest_mode="floor",
                coordinate_transformation_mode="asymmetric",
            ),
            helper.make_node("Mul", ["large", "gain"], ["y"]),
        ],
        "somebodys",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, shape)],
        [helper.make_tensor_value_info("y", TensorProto.FLOAT, out)],
        [
            onnx.numpy_helper.from_array(np.float32(times), "times"),
            onnx.numpy_helper.from_array(gain, "gain"),
        ],
    )
    return helper.make_model(graph, opset_imports=[helper.make_opsetid("", 18)], ir_version=9)


@pytest.fixture
def somebodys(tmp_path: Path) -> Callable[..., Path]:
    """Write somebody's network (:func:`_somebodys`) and its contract."""

    def write(
        *,
        size: tuple[int | str, int | str] = ("H", "W"),
        batch: int | str = "N",
        grows: int = 2,
        **declared: Any,
    ) -> Path:
        told = {"channels": "RGB", "layout": "NCHW", "range": "0..1", "enlarged": False}
        told |= {"scale": 2} | declared
        path = tmp_path / "theirs.onnx"
        channels = 1 if told["channels"] == "Y" else 3
        onnx.save(_somebodys(told["layout"], channels, grows, size, batch), path)
        scale = told.pop("scale")
        lines = [f'sha256 = "{sha256_of(path)}"', 'licence = "MIT"', 'source = "a test"']
        fields = [
            f"{k} = {str(v).lower() if v in (True, False) else repr(v)}" for k, v in told.items()
        ]
        contract = [*lines, "[input]", *fields, "[output]", f"scale = {scale}"]
        contract_path(path).write_text("\n".join(contract))
        return path

    return write


@pytest.fixture
def network_file(tmp_path: Path) -> Callable[..., Path]:
    """Write a small network of the list with random weights."""

    def write(architecture: str, scale: int, **arguments: object) -> Path:
        torch.manual_seed(scale)
        path = tmp_path / f"{architecture}{scale}x.safetensors"
        given = SMALL[architecture] | ({"scale": scale} if architecture != "srcnn" else {})
        card = card_of(architecture, scale, **{**given, **arguments})
        write_weights(path, NETWORKS[architecture](**card.arguments), card)
        return path

    return write


@pytest.fixture
def edsr_file(network_file: Callable[..., Path]) -> Callable[..., Path]:
    """Write a small EDSR with random weights."""
    return partial(network_file, "edsr")
