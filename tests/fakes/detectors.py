"""Detectors of constants: ONNX files that return seeded random numbers whatever they see."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

Lists = Mapping[str, np.ndarray]


def scrfd_lists(side: int, strides: Sequence[int], per_cell: int, *, landmarks: bool) -> Lists:
    """What insightface's networks return: scores, boxes and landmarks of all strides."""
    rng = np.random.default_rng(len(strides) + per_cell)
    counts = {stride: per_cell * (side // stride) ** 2 for stride in strides}
    lists = {f"score_{s}": rng.random((n, 1)) for s, n in counts.items()}
    lists |= {f"bbox_{s}": rng.uniform(0.5, 3, (n, 4)) for s, n in counts.items()}
    if landmarks:
        lists |= {f"kps_{s}": rng.uniform(-1, 1, (n, 10)) for s, n in counts.items()}
    return {name: values.astype(np.float32) for name, values in lists.items()}


def deepface_lists(side: int) -> Lists:
    """What DeepFace's RetinaFace returns: by stride, two anchors a cell in the last axis."""
    rng = np.random.default_rng(7)
    lists = {}
    for stride in (32, 16, 8):
        cells = (1, side // stride, side // stride)
        lists[f"cls_{stride}"] = rng.random((*cells, 4))
        lists[f"box_{stride}"] = rng.normal(0, 0.1, (*cells, 8))
        lists[f"points_{stride}"] = rng.normal(0, 0.3, (*cells, 20))
    return {name: values.astype(np.float32) for name, values in lists.items()}


def write_constants(
    path: Path, lists: Lists, shape: Sequence[int | str] = (1, 3, "height", "width")
) -> Path:
    """Write an ONNX file that takes images of ``shape`` and returns ``lists``."""
    image = helper.make_tensor_value_info("image", TensorProto.FLOAT, shape)
    outputs = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, values.shape)
        for name, values in lists.items()
    ]
    nodes = [
        helper.make_node("Constant", [], [name], value=numpy_helper.from_array(values))
        for name, values in lists.items()
    ]
    graph = helper.make_graph(nodes, "constants", [image], outputs)
    opset = helper.make_opsetid("", 18)
    onnx.save(helper.make_model(graph, opset_imports=[opset], ir_version=9), path)
    return path


def declare(model: Path, kind: str, sha256: str, **fields: Any) -> Path:
    """Write the contract beside a detector."""
    told = {
        "": {"sha256": sha256, "licence": "MIT", "source": "a test", "kind": kind},
        "input": {"layout": "NCHW", "channels": "RGB", "mean": [127.5] * 3, "scale": 128},
        "output": {},
        "detection": {"score_threshold": 0.5, "nms_iou": 0.4},
    }
    for name, value in fields.items():
        table, _, field = name.partition("__")
        told[table if field else ""][field or name] = value
    lines = []
    for table, values in told.items():
        lines += [f"[{table}]"] if table else []
        lines += [f"{name} = {_toml(value)}" for name, value in values.items() if value is not None]
    path = model.with_suffix(".toml")
    path.write_text("\n".join(lines))
    return path


def _toml(value: Any) -> str:
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    return f'"{value}"' if isinstance(value, str) else str(value)


def yunet_lists(side: int) -> Lists:
    """What YuNet returns: by stride of 8, 16 and 32 class, objectness, box and points."""
    lists: dict[str, np.ndarray] = {}
    for name, width in (("cls", 1), ("obj", 1), ("bbox", 4), ("kps", 10)):
        for stride in (8, 16, 32):
            lists[f"{name}_{stride}"] = np.zeros((1, (side // stride) ** 2, width), np.float32)
    return lists
