import numpy as np
import pytest
import torch
from oracles.bicubic import resize

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.training.shrinking.clean import Clean


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_a_picture_is_shrunk_as_by_matlab_to_8_bits(scale: int, pictures: torch.Tensor) -> None:
    ((small, true),) = Clean()(pictures[:1], scale, [0], Camera())
    wanted = resize(pictures[0, 1].numpy().astype(np.float64), 1 / scale).clip(0, 1)
    assert np.abs(small[0, 1].numpy() * 255 - (wanted * 255).round()).max() <= 1
    assert np.abs(small[0, 1].numpy() - wanted).max() < 0.5001 / 255
    assert true is not small
    assert torch.equal(true, pictures[:1])


def test_a_scene_is_taken_without_the_cameras_flaws_in_its_exposure() -> None:
    (camera,) = Clean().cameras(Camera("heavy", 0.5, name="mine", sensor=Sensor()))
    assert camera.flawless
    assert (camera.compression, camera.exposure_ev) == ("none", 0.5)
