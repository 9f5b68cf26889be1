"""Rendered faces, so that no test of the camera needs the renderer; one thread for small sums."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch

FACES = Path(__file__).parents[1] / "data" / "faces_linear.png"


@pytest.fixture
def faces() -> torch.Tensor:
    """Return four faces ``(4, 3, 52, 52)``, linear light of the exposed film in [0, 1].

    ``ProbeRecipe("test", i, ipd_px=13, scale=4, samples_per_pixel=64, lighting=...)``, i = 0..3, in
    light from the front, the side, above, the front; exposed at 0 EV, binned 4 x 4, 16 bits.
    """
    row = cv2.imread(str(FACES), cv2.IMREAD_UNCHANGED)[..., ::-1].astype(np.float32) / 65535
    return torch.from_numpy(np.stack(np.split(row, 4, axis=1))).permute(0, 3, 1, 2).contiguous()


@pytest.fixture
def one_thread() -> Iterator[None]:
    """Thousands of tiny sums: on busy cores several threads would wait for each other."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
