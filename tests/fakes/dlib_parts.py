"""dlib as a wheel would install it, or not at all: seen from the import system."""

import sys
from collections.abc import Callable
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.recognition.dlib_encoder import _NETWORK, _POINTS

Box = tuple[int, int, int, int]


class FakeDlib(ModuleType):
    """Describes a face by the mean colour within its box; notes what it was given."""

    __version__ = "0"

    def __init__(self) -> None:
        super().__init__("dlib")
        self.__spec__ = ModuleSpec("dlib", None)
        self.loaded: list[str] = []
        self.images: list[NDArray[np.uint8]] = []

    def rectangle(self, left: int, top: int, right: int, bottom: int) -> Box:
        return left, top, right, bottom

    def shape_predictor(self, path: str) -> Callable[[NDArray[np.uint8], Box], Box]:
        self.loaded.append(Path(path).name)
        return lambda image, box: box

    def face_recognition_model_v1(self, path: str) -> "FakeDlib":
        self.loaded.append(Path(path).name)
        return self

    def compute_face_descriptor(self, image: NDArray[np.uint8], box: Box) -> list[float]:
        self.images.append(image)
        left, top, right, bottom = box
        mean = image[max(top, 0) : bottom + 1, max(left, 0) : right + 1].mean(axis=(0, 1))
        return np.resize(mean, 128).tolist()


def install_dlib(monkeypatch: pytest.MonkeyPatch, folder: Path) -> FakeDlib:
    """Let dlib and its models look installed, whether they are or not."""
    models = folder / "models"
    models.mkdir(parents=True)
    for name in (_POINTS, _NETWORK):
        (models / name).write_bytes(name.encode())
    package: Any = ModuleType("face_recognition_models")
    package.__spec__ = ModuleSpec(package.__name__, None, origin=str(folder / "__init__.py"))
    dlib = FakeDlib()
    monkeypatch.setitem(sys.modules, "dlib", dlib)
    monkeypatch.setitem(sys.modules, package.__name__, package)
    return dlib


def remove_dlib(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let dlib look as if it were not installed, whether it is or not."""
    monkeypatch.setitem(sys.modules, "dlib", None)
