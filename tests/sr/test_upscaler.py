from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import torch

from lrsr.errors import ImageContractError, InputError
from lrsr.images import luminance, resize_bicubic, rgb_to_ycbcr, ycbcr_to_rgb
from lrsr.sr import METHODS, Upscaler
from lrsr.sr.weights import read_weights


@pytest.fixture
def faces() -> torch.Tensor:
    """Three random srgb images inside the gamut, so that nothing is clipped."""
    generator = torch.Generator().manual_seed(5)
    return 0.3 + 0.4 * torch.rand(3, 3, 10, 8, generator=generator)


@pytest.mark.parametrize(
    ("method", "label", "scale"),
    [
        ("base", "Base", 1),
        ("bicubic2", "Bicubic 2", 2),
        ("bicubic4", "Bicubic 4", 4),
        ("srcnn2", "SR 2", 2),
        ("srcnn2x2", "SR 2x2", 4),
        ("srcnn4", "SR 4", 4),
    ],
)
def test_method_has_its_label_and_scale(
    faces: torch.Tensor, method: str, label: str, scale: int
) -> None:
    upscaler = Upscaler(method)
    assert (upscaler.method, upscaler.label, upscaler.scale) == (method, label, scale)
    assert upscaler(faces).shape == (3, 3, 10 * scale, 8 * scale)


def test_methods_stand_in_the_order_of_the_tables() -> None:
    assert list(METHODS) == ["base", "bicubic2", "bicubic4", "srcnn2", "srcnn2x2", "srcnn4"]


def test_srcnn_restores_the_luminance_and_leaves_the_chroma_bicubic(
    faces: torch.Tensor, weights_file: Callable[..., Path]
) -> None:
    path = weights_file(2)
    network, _ = read_weights(path)
    larger = Upscaler("srcnn2", path)(faces)
    bicubic = resize_bicubic(faces, 2)
    torch.testing.assert_close(luminance(larger), network(luminance(bicubic)), rtol=0, atol=2e-6)
    torch.testing.assert_close(
        rgb_to_ycbcr(larger)[:, 1:], rgb_to_ycbcr(bicubic)[:, 1:], rtol=0, atol=2e-6
    )


def test_bicubic_is_the_one_bicubic(faces: torch.Tensor) -> None:
    torch.testing.assert_close(Upscaler("bicubic4")(faces), resize_bicubic(faces, 4).clamp(0, 1))


def test_base_returns_the_image_itself(faces: torch.Tensor) -> None:
    assert Upscaler("base")(faces) is faces


def test_2x2_is_2x_taken_twice(faces: torch.Tensor, weights_file: Callable[..., Path]) -> None:
    path = weights_file(2)
    twice, once = Upscaler("srcnn2x2", path), Upscaler("srcnn2", path)
    torch.testing.assert_close(twice(faces), once(once(faces)), rtol=0, atol=0)


@pytest.mark.parametrize("method", ["bicubic4", "srcnn2x2"])
def test_batches_change_nothing(faces: torch.Tensor, method: str) -> None:
    one_by_one = Upscaler(method, batch_size=1)(faces)
    torch.testing.assert_close(Upscaler(method)(faces), one_by_one, rtol=0, atol=1e-6)


@pytest.mark.parametrize("method", list(METHODS))
def test_grey_stays_grey_without_colour(method: str) -> None:
    grey = torch.full((1, 3, 8, 8), 0.5)
    larger = Upscaler(method)(grey)
    np.testing.assert_allclose((larger - larger[:, :1]).numpy(), 0.0, atol=1e-6)


@pytest.mark.parametrize("method", ["bicubic4", "srcnn2", "srcnn4"])
def test_result_is_clipped_to_0_and_1(method: str) -> None:
    edge = torch.zeros(1, 3, 8, 8)
    edge[..., 4:] = 1.0
    larger = Upscaler(method)(edge)
    assert float(larger.min()) >= 0.0
    assert float(larger.max()) <= 1.0


def test_one_pixel_can_be_enlarged() -> None:
    assert Upscaler("srcnn4")(torch.rand(1, 3, 1, 1)).shape == (1, 3, 4, 4)


def test_no_gradient_is_kept(faces: torch.Tensor) -> None:
    upscaler = Upscaler("srcnn2")
    assert not upscaler(faces.requires_grad_()).requires_grad
    assert not any(parameter.requires_grad for parameter in upscaler.parameters())


def test_ycbcr_goes_there_and_back(faces: torch.Tensor) -> None:
    torch.testing.assert_close(ycbcr_to_rgb(rgb_to_ycbcr(faces)), faces, rtol=0, atol=1e-6)


def test_unknown_method_is_refused_with_the_choice() -> None:
    with pytest.raises(InputError, match=r"no upscaling method 'srcnn3': choose one of base, bic"):
        Upscaler("srcnn3")


@pytest.mark.parametrize(("method", "trained"), [("srcnn4", 2), ("srcnn2", 4), ("srcnn2x2", 4)])
def test_weights_of_another_scale_are_refused(
    method: str, trained: int, weights_file: Callable[..., Path]
) -> None:
    wanted = 2 if trained == 4 else 4
    with pytest.raises(
        InputError, match=f"trained for {trained}x, but {method} needs {wanted}x: give the weights"
    ):
        Upscaler(method, weights_file(trained))


def test_bicubic_refuses_weights(weights_file: Callable[..., Path]) -> None:
    with pytest.raises(InputError, match="bicubic2 takes no weights"):
        Upscaler("bicubic2", weights_file(2))


def test_missing_weights_are_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"no weights at .*nowhere.safetensors"):
        Upscaler("srcnn2", tmp_path / "nowhere.safetensors")


def test_grey_image_is_refused() -> None:
    with pytest.raises(ImageContractError, match=r"srgb: got shape \(1, 1, 8, 8\)"):
        Upscaler("srcnn2")(torch.zeros(1, 1, 8, 8))


def test_upscaler_is_found_without_lightning() -> None:
    """`from lrsr.sr import Upscaler` must not cost the import of a training framework."""
    import subprocess
    import sys

    code = "import sys; from lrsr.sr import Upscaler; sys.exit('lightning' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
