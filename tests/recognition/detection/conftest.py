"""A picture of a rendered face."""

from pathlib import Path

import cv2
import pytest
import torch

DATA = Path(__file__).parents[2] / "data"


@pytest.fixture(scope="session")
def rendered_face() -> torch.Tensor:
    levels = cv2.imread(str(DATA / "rendered_face.png"))[..., ::-1]
    return torch.from_numpy(levels.copy()).permute(2, 0, 1)[None].float() / 255
