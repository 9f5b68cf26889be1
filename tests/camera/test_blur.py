"""One lens' kernels: which colours and places are blurred, and how much."""

import pytest
import torch

from lrsr.camera.blur import Blur
from lrsr.camera.diffraction import airy_kernel
from lrsr.errors import InputError

AXIS, RIGHT, DOWN = (torch.tensor([place]) for place in ([0.0, 0.0], [0.9, 0.0], [0.0, 0.9]))


def width(kernels: torch.Tensor) -> list[float]:
    reach = kernels.shape[-1] // 2
    places = torch.arange(-reach, reach + 1.0)
    square = places[:, None] ** 2 + places**2
    return [float(value) for value in (kernels[0] * square).sum((-2, -1)).sqrt()]


def test_a_perfect_lens_gives_each_colour_its_airy_disk() -> None:
    kernels = Blur(1.4).kernels(AXIS, 1.325)
    reach = kernels.shape[-1] // 2
    for kernel, wavelength in zip(kernels[0], (611.4, 549.1, 464.2), strict=True):
        assert torch.allclose(kernel, airy_kernel(1.4, wavelength, 1.325, reach).float())


def test_axial_colour_blurs_the_colours_that_miss_the_film() -> None:
    red, green, blue = width(Blur(1.4, axial_colour_um=(15.0, 0.0, 15.0)).kernels(AXIS, 1.0))
    assert red > 1.3 * green
    assert blue > 1.3 * green


@pytest.mark.parametrize("fault", ["coma_waves", "astigmatism_waves", "curvature_waves"])
def test_field_faults_grow_outwards(fault: str) -> None:
    blur = Blur(1.4, **{fault: 2.0})
    near, far = blur.kernels(torch.cat([AXIS, RIGHT]), 1.0).split(1)
    assert min(width(far)) > 1.2 * max(width(near))


def test_the_blur_turns_with_the_field() -> None:
    blur = Blur(1.4, coma_waves=1.0, astigmatism_waves=0.7, defocus_um=3.0)
    right, down = blur.kernels(torch.cat([RIGHT, DOWN]), 1.0)
    assert torch.allclose(down, right.transpose(-1, -2), atol=1e-6)


def test_kernels_hold_nearly_all_their_light_at_any_defocus() -> None:
    # Cut at three quarters of the reach, little is lost: the reach follows the blur.
    for defocus_um in (0.0, 20.0, 100.0):
        kernel = Blur(1.4, defocus_um=defocus_um).kernels(AXIS, 2.65)[0, 1]
        cut = kernel.shape[-1] // 8
        assert float(kernel[cut:-cut, cut:-cut].sum()) > 0.97


def test_a_tiny_aberration_changes_next_to_nothing() -> None:
    # From Airy's analytic transfer to the sampled pupil there is no jump.
    perfect = Blur(1.4).kernels(AXIS, 0.6625)[0, 1]
    nearly = Blur(1.4, defocus_um=1e-4).kernels(AXIS, 0.6625)[0, 1]
    cut = (nearly.shape[-1] - perfect.shape[-1]) // 2
    nearly = nearly[cut : len(nearly) - cut, cut : len(nearly) - cut]
    assert float((nearly - perfect).abs().max() / perfect.max()) < 0.01


def test_a_blur_too_wide_is_refused() -> None:
    with pytest.raises(InputError, match="too wide to compute"):
        Blur(1.4, defocus_um=2000.0).kernels(AXIS, 2.65)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"f_number": -1.0}, "f_number -1"),
        ({"f_number": 2.0, "focal_mm": 0.0}, "focal_mm 0"),
        ({"f_number": 2.0, "wavelengths_nm": (0.0, 1.0, 1.0)}, "wavelengths_nm 0"),
        ({"f_number": 2.0, "coma_waves": float("nan")}, "coma_waves=nan"),
        ({"f_number": 2.0, "curvature_waves": float("inf")}, "curvature_waves=inf"),
    ],
)
def test_an_impossible_lens_is_refused(setting: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Blur(**setting)


def test_more_defocus_needs_no_fewer_samples() -> None:
    sizes = [Blur(1.4, defocus_um=um).pupil_size() for um in (0.0, 1.0, 10.0, 100.0)]
    assert sizes[0] == 0
    assert sizes == sorted(sizes)
