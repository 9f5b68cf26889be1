"""How fast is the camera? Images a second, against the codec alone and against Pillow's.

The aim: 1000 probes of 32 x 32 through the full chain (no H.264) in under 5 s on two cores. On one
thread: 0.37 to 0.87 s.
"""

import io
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf
from PIL import Image
from pytest_benchmark.fixture import BenchmarkFixture

from lrsr.calibration.picture_statistics import describe
from lrsr.camera import Camera
from lrsr.camera.codec import COMPRESSIONS, jpeg
from lrsr.paths import config_folder
from lrsr.spectra import Spectrum, band_edges, daylight

BATCH = 64
LIGHT = torch.rand(BATCH, 3, 32, 32, generator=torch.Generator().manual_seed(0))
METERED = torch.ones(BATCH)


@pytest.fixture
def one_thread() -> Iterator[None]:
    """On busy cores several threads wait for each other: it is then slower by ten times."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


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
@pytest.mark.usefixtures("one_thread")
def test_statistics_that_a_camera_is_fitted_by(benchmark: BenchmarkFixture) -> None:
    assert len(benchmark(describe, LIGHT)) == BATCH


@pytest.mark.benchmark(group="camera, 64 images of 32x32")
def test_reference_opencv_alone(benchmark: BenchmarkFixture) -> None:
    assert benchmark(jpeg, LIGHT, 15).shape == LIGHT.shape


@pytest.mark.benchmark(group="camera, 64 images of 32x32")
def test_reference_pillow(benchmark: BenchmarkFixture) -> None:
    assert benchmark(by_pillow, LIGHT, 15).shape == LIGHT.shape


@pytest.mark.usefixtures("one_thread")
@pytest.mark.benchmark(group="camera, full chain: 1000 probes of 32x32, batches of 64 as in use")
@pytest.mark.parametrize(
    "preset", ["ideal", "phone", "webcam", "scface_cam1", "scface_cam3", "nikon_d5100"]
)
def test_full_chain(benchmark: BenchmarkFixture, preset: str) -> None:
    camera = instantiate(OmegaConf.load(config_folder() / "camera" / f"{preset}.yaml"))
    side = 32 * camera.supersampling
    channels, spectrum = camera.bands or 3, None
    if camera.bands:
        edges = band_edges(camera.bands)
        spectrum = Spectrum(edges, (tuple(daylight(edges).tolist()),) * BATCH)
    light = torch.rand(BATCH, channels, side, side, generator=torch.Generator().manual_seed(0))

    def thousand() -> int:
        done = 0
        while done < 1000:
            size = min(BATCH, 1000 - done)
            own = spectrum and replace(spectrum, whites=spectrum.whites[:size])
            done += len(camera(light[:size], METERED[:size], range(done, done + size), own))
        return done

    with torch.no_grad():
        assert benchmark.pedantic(thousand, rounds=3, warmup_rounds=1) == 1000


@pytest.mark.usefixtures("one_thread")
@pytest.mark.benchmark(group="camera, full chain: 16 probes of 32x32 with H.264 of three frames")
def test_full_chain_with_video(benchmark: BenchmarkFixture) -> None:
    camera = instantiate(OmegaConf.load(config_folder() / "camera" / "axis_p1435le.yaml"))
    light = torch.rand(16, 3, 128, 128, generator=torch.Generator().manual_seed(0))
    with torch.no_grad():
        assert benchmark(camera, light, METERED[:16], range(16)).shape == (16, 3, 32, 32)
