import pytest
import torch

from lrsr.camera import Camera
from lrsr.camera.codec import jpeg
from lrsr.camera.encoding import encode
from lrsr.camera.sensor import Sensor
from lrsr.errors import InputError
from lrsr.images import srgb_to_linear
from lrsr.presets import preset
from lrsr.training.shrinking.one_camera import OneCamera


def test_the_reference_camera_averages_linear_light_over_its_pixels() -> None:
    """A pixel of two white and two black ones is half the light: 188 of 255 in sRGB."""
    true = torch.zeros(1, 3, 2, 4)
    true[..., 0, :] = 1
    ((small, same),) = OneCamera()(true, 2, [0], Camera())
    assert small.mul(255).flatten().tolist() == [188.0] * 6
    assert torch.equal(same, true)


def test_each_compression_is_that_of_the_codec(pictures: torch.Tensor) -> None:
    degradation = OneCamera(["none", "heavy"])
    (plain, _), (heavy, true) = degradation(pictures, 2, [0] * 4, Camera())
    assert torch.equal(heavy, jpeg(plain, 15))
    assert torch.equal(true, pictures)


def test_exposure_is_that_of_both_pictures(pictures: torch.Tensor) -> None:
    ((_, plain),) = OneCamera()(pictures, 2, [0] * 4, Camera())
    ((small, darker),) = OneCamera()(pictures, 2, [0] * 4, Camera(exposure_ev=-1))
    assert torch.equal(plain, pictures)
    assert torch.equal(darker, encode(srgb_to_linear(pictures) / 2))
    assert float(small.mean()) == pytest.approx(float(darker.mean()), abs=0.02)


@pytest.mark.parametrize("supersampling", [1, 2, 4])
@pytest.mark.parametrize("scale", [2, 3, 4])
def test_a_camera_with_a_finer_film_sees_the_same(
    scale: int, supersampling: int, pictures: torch.Tensor
) -> None:
    finer = Camera(supersampling=supersampling)
    ((small, _),) = OneCamera()(pictures, scale, [0] * 4, finer)
    ((plain, _),) = OneCamera()(pictures, scale, [0] * 4, Camera())
    assert small.shape == plain.shape
    assert float((small - plain).square().mean()) < 1e-3


def test_lens_mosaic_noise_and_file_are_those_of_the_preset(pictures: torch.Tensor) -> None:
    camera = preset("camera", "axis_p1435le")
    ((small, _),) = OneCamera()(pictures, 2, [1, 2, 3, 4], camera)
    ((plain, _),) = OneCamera()(pictures, 2, [1, 2, 3, 4], Camera())
    assert 0.01 < float((small - plain).square().mean().sqrt()) < 0.2


def test_the_seed_of_a_picture_is_that_of_its_noise(pictures: torch.Tensor) -> None:
    noisy = Camera(sensor=Sensor(500.0))
    ((few, _),) = OneCamera()(pictures, 2, [5, 6, 7, 8], noisy)
    ((alone, _),) = OneCamera()(pictures[2:3], 2, [7], noisy)
    assert torch.equal(few[2:3], alone)


def test_the_flawless_camera_of_a_scene_is_told_as_a_clean_film() -> None:
    assert OneCamera().in_words(Camera(), of_films=True).endswith("no down-sampling")
    told = OneCamera(["heavy"]).in_words(Camera(), of_films=True)
    assert told.endswith("taken by the camera reference, compression heavy")


@pytest.mark.parametrize(
    ("compressions", "message"),
    [
        ([], r"degradation.compressions=\[\]: wanted at least one"),
        (["much"], "compression=much: wanted one of none"),
        (3, "degradation.compressions=3: wanted a list"),
    ],
)
def test_what_is_no_compression_is_refused(compressions: list[str], message: str) -> None:
    with pytest.raises(InputError, match=message):
        OneCamera(compressions)
