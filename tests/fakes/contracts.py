"""What a test's own ONNX embedder expects and returns."""

from pathlib import Path
from typing import Any

from lrsr.onnx import contract_path, sha256_of
from lrsr.recognition.contract import Contract, write_contract


def declare(model: Path, dimension: int, **changes: Any) -> Path:
    """Write a contract beside a model, insightface's but for what is changed; return the model."""
    usual: dict[str, Any] = {
        "sha256": sha256_of(model),
        "licence": "MIT",
        "source": "a test",
        "layout": "NCHW",
        "channels": "RGB",
        "height_px": 112,
        "width_px": 112,
        "mean": 127.5,
        "scale": 127.5,
        "dimension": dimension,
        "template": "arcface5",
        "antialias": False,
    }
    contract_path(model).write_text(write_contract(Contract(**{**usual, **changes})))
    return model
