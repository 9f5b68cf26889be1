"""The chain from light to file, as a whole."""

import subprocess
import sys

import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

import lrsr.camera
from lrsr.camera import Camera
from lrsr.camera.codec import COMPRESSIONS
from lrsr.camera.exposure import KEY
from lrsr.errors import ImageContractError, InputError, NonFiniteError
from lrsr.images import linear_to_srgb
from lrsr.paths import config_folder


def light(batch: int = 2, height: int = 32, width: int = 32, seed: int = 0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(batch, 3, height, width, generator=generator)


@pytest.mark.parametrize("codec", ["true", "differentiable"])
def test_without_compression_the_file_is_the_rounded_curve(codec: str) -> None:
    linear = light()
    wanted = (linear_to_srgb(linear * KEY / 2.0) * 255).round() / 255
    assert torch.allclose(Camera(codec=codec)(linear, torch.tensor([2.0, 2.0])), wanted)


@pytest.mark.parametrize("codec", ["true", "differentiable"])
@pytest.mark.parametrize("compression", list(COMPRESSIONS))
@pytest.mark.parametrize("size", [(32, 32), (45, 29), (1, 1)], ids=str)
def test_any_size_comes_back_as_srgb_of_eight_bits(
    compression: str, codec: str, size: tuple[int, int]
) -> None:
    srgb = Camera(compression, codec=codec)(light(3, *size), torch.ones(3))
    assert srgb.shape == (3, 3, *size)
    assert srgb.dtype == torch.float32
    assert torch.allclose(srgb * 255, (srgb * 255).round().clamp(0, 255), atol=1e-4)


@pytest.mark.parametrize("compression", list(COMPRESSIONS))
def test_a_picture_does_not_depend_on_its_batch(compression: str) -> None:
    linear, metered = light(5, 20, 30), torch.linspace(0.5, 2, 5)
    camera = Camera(compression)
    alone = [camera(linear[i : i + 1], metered[i : i + 1]) for i in range(5)]
    assert torch.equal(camera(linear, metered), torch.cat(alone))


def test_the_same_light_gives_the_same_file() -> None:
    camera = Camera("heavy")
    assert torch.equal(camera(light(), torch.ones(2)), camera(light(), torch.ones(2)))


@pytest.mark.parametrize("compression", list(COMPRESSIONS))
def test_the_differentiable_camera_passes_the_light_a_gradient(compression: str) -> None:
    linear = light().requires_grad_()
    Camera(compression, codec="differentiable")(linear, torch.ones(2)).sum().backward()
    assert linear.grad is not None
    assert bool(torch.isfinite(linear.grad).all())
    assert float(linear.grad.abs().mean()) > 0.1


def test_overexposure_clips_at_white() -> None:
    assert Camera(exposure_ev=10)(light() + 0.1, torch.ones(2)).unique().tolist() == [1.0]


def test_a_camera_has_nothing_to_train_or_to_store() -> None:
    assert Camera().state_dict() == {}


def test_another_compression_is_otherwise_the_same_camera() -> None:
    camera = Camera("none", exposure_ev=1.0, codec="differentiable", name="mine")
    heavy = camera.compressing("heavy")
    assert heavy.compression == "heavy"
    assert (heavy.exposure_ev, heavy.codec, heavy.name) == (1.0, "differentiable", "mine")


def test_a_camera_says_how_it_is_set() -> None:
    assert repr(Camera("small")) == (
        "Camera(compression='small', exposure_ev=0, codec='true', name='reference')"
    )


def test_the_preset_builds_the_camera_it_names() -> None:
    for file in (config_folder() / "camera").glob("*.yaml"):
        camera = instantiate(OmegaConf.load(file))
        assert isinstance(camera, Camera)
        assert camera.name == file.stem


def test_unknown_settings_are_refused_with_the_choice() -> None:
    with pytest.raises(InputError, match="compression 'much': choose one of none, small, heavy"):
        Camera("much")
    with pytest.raises(InputError, match="codec 'webp': choose one of true, differentiable"):
        Camera(codec="webp")
    with pytest.raises(InputError, match="compression 'much'"):
        Camera().compressing("much")


def test_broken_light_is_refused() -> None:
    with pytest.raises(ImageContractError, match="metered: got shape"):
        Camera()(light(2), torch.ones(3))
    with pytest.raises(NonFiniteError, match="linear: nan"):
        Camera()(light() * float("nan"), torch.ones(2))


def test_the_package_loads_kornia_only_with_the_camera() -> None:
    script = "import sys, lrsr.camera; print('kornia' in sys.modules, 'torch' in sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert loaded.stdout == b"False False\n"


def test_the_package_has_no_other_names() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Lens'"):
        lrsr.camera.Lens  # noqa: B018 - asking is the test
