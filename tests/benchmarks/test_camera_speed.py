"""How fast is the camera? Images a second, against the codec alone and against Pillow's."""

import io

import numpy as np
import pytest
import torch
from PIL import Image
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.camera import Camera
from lrsr.camera.codec import COMPRESSIONS, jpeg

BATCH = 64
LIGHT = torch.rand(BATCH, 3, 32, 32, generator=torch.Generator().manual_seed(0))
METERED = torch.ones(BATCH)


def by_pillow(srgb: torch.Tensor, quality: int) -> torch.Tensor:
    decoded = []
    for pixels in (srgb * 255).round().byte().permute(0, 2, 3, 1).numpy():
        file = io.BytesIO()
        Image.fromarray(pixels).save(file, "JPEG", quality=quality, subsampling="4:2:0")
        decoded.append(np.asarray(Image.open(file)))
    return torch.from_numpy(np.stack(decoded)).permute(0, 3, 1, 2) / 255


@pytest.mark.benchmark(group="camera, 64 images of 32x32")
@pytest.mark.parametrize("codec", ["true", "differentiable"])
@pytest.mark.parametrize("compression", list(COMPRESSIONS))
def test_camera(benchmark: BenchmarkFixture, compression: str, codec: str) -> None:
    camera = Camera(compression, codec=codec)
    with torch.no_grad():
        assert benchmark(camera, LIGHT, METERED).shape == LIGHT.shape


@pytest.mark.benchmark(group="camera, 64 images of 32x32")
def test_reference_opencv_alone(benchmark: BenchmarkFixture) -> None:
    assert benchmark(jpeg, LIGHT, 15).shape == LIGHT.shape


@pytest.mark.benchmark(group="camera, 64 images of 32x32")
def test_reference_pillow(benchmark: BenchmarkFixture) -> None:
    assert benchmark(by_pillow, LIGHT, 15).shape == LIGHT.shape
