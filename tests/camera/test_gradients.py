"""Does every differentiable stage have the slope that finite differences see?

One file, so that none is missed (measured filters: test_spectral.py). `gradcheck` compares each
output's slope along each input, in double precision; `all_slopes_agree` does so in three calls of a
stage that takes whole batches. Where a stage rounds, its gradient goes straight through; then what
it is without rounding is checked, and that the gradient with rounding is the very same.
"""

from collections.abc import Callable
from functools import partialmethod

import pytest
import torch
from torch.autograd import gradcheck

from lrsr.camera import Camera, camera, codec, encoding
from lrsr.camera.aberrations import Seidel, defocus_waves
from lrsr.camera.bayer import PATTERNS, mosaic
from lrsr.camera.codec import Jpeg, jpeg_differentiable
from lrsr.camera.colour import Colour
from lrsr.camera.convolution import convolve
from lrsr.camera.demosaic import METHODS, demosaic
from lrsr.camera.distortion import Distortion
from lrsr.camera.exposure import expose
from lrsr.camera.image_plane import turn
from lrsr.camera.mosaic import Mosaic
from lrsr.camera.optics import Optics, bin_pixels
from lrsr.camera.processing import Processing, _sharpen, _tone, luminance
from lrsr.camera.pupil import pupil_kernel
from lrsr.camera.sensor import Sensor
from lrsr.camera.smoothing import bilateral_blur, gaussian_blur
from lrsr.camera.soft_jpeg import SHARING, soft_jpeg
from lrsr.camera.vignetting import _mechanical_vignetting, natural_vignetting
from lrsr.images import linear_to_srgb
from lrsr.resampling import sample_bicubic

pytestmark = pytest.mark.usefixtures("one_thread")

Stage = Callable[..., torch.Tensor]
BARREL = Distortion(0.1, 0.4)
FILTERS = ((0.5, 0.1, 0.0), (0.1, 0.8, 0.1), (0.0, 0.1, 0.6))


def draw(*shape: int, low: float = 0.1, high: float = 0.9, seed: int = 0) -> torch.Tensor:
    """Random numbers in double precision that ask for a gradient."""
    generator = torch.Generator().manual_seed(seed)
    numbers = torch.rand(shape, generator=generator, dtype=torch.float64)
    return (low + (high - low) * numbers).requires_grad_()


def all_slopes_agree(stage: Stage, image: torch.Tensor, step: float = 1e-7) -> bool:
    """Compare all slopes of one image ``(1, C, H, W)``, each along a pixel of a copy in a batch.

    Which says something only if no picture of a batch heeds another.
    """
    count, still = image.numel(), image.detach()
    both = still, still.flip(-1)
    if not torch.equal(stage(torch.cat(both)), torch.cat([stage(one) for one in both])):
        return False
    moves = step * torch.eye(count, dtype=torch.float64).reshape(count, *image.shape[1:])
    differences = (stage(still + moves) - stage(still - moves)).flatten(1).T / (2 * step)
    outputs = len(differences)
    copies = still.repeat(outputs, 1, 1, 1).requires_grad_()
    stage(copies).reshape(outputs, outputs).diagonal().sum().backward()
    assert copies.grad is not None
    return torch.allclose(copies.grad.flatten(1), differences, rtol=1e-3, atol=1e-5)


PLACES = draw(4, 2, low=-1.5, high=1.5)  # mm on the sensor
IMAGE = draw(1, 3, 5, 4)
PLANE = draw(1, 1, 5, 4)

STAGES: dict[str, tuple[Stage, tuple[torch.Tensor, ...]]] = {
    "convolution": (convolve, (draw(2, 1, 3, 4), draw(1, 1, 3, 3, seed=1))),
    "bicubic, alike": (sample_bicubic, (draw(2, 2, 4, 4), draw(1, 1, 2, 3, 2, high=3.0))),
    "bicubic, each": (sample_bicubic, (draw(2, 2, 4, 4), draw(2, 1, 2, 3, 2, high=3.0))),
    "binning": (lambda film: bin_pixels(film, 2), (draw(1, 3, 4, 6),)),
    "undistortion": (BARREL.undistort, (PLACES,)),
    "distortion": (BARREL.distort, (PLACES,)),
    "turning": (lambda p, m: turn(p, m, 3.0), (PLACES, draw(2, seed=1))),
    "turning back": (lambda p, m: turn(p, m, 3.0, back=True), (PLACES, draw(2, seed=1))),
    "to the film": (BARREL.to_film, (PLACES, draw(2, seed=1))),
    "to the sensor": (BARREL.to_sensor, (PLACES, draw(2, seed=1))),
    "cos⁴": (lambda p: natural_vignetting(p, BARREL), (PLACES,)),
    "rim": (
        lambda p: _mechanical_vignetting(
            p, BARREL, pupil_radius_mm=1.0, rim_radius_mm=1.1, rim_distance_mm=2.0
        ),
        (PLACES,),
    ),
    "defocus": (lambda um: defocus_waves(um, 1.4, 550.0), (draw(3),)),
    "colour": (lambda x: Colour(FILTERS)(Colour(FILTERS).filter(x)), (IMAGE,)),
    "gaussian": (lambda x: gaussian_blur(x, 1.2), (PLANE,)),
    "bilateral": (lambda x: bilateral_blur(x, 1.2, 0.3), (PLANE,)),
    "sharpening": (lambda x: _sharpen(x, 1.0, 0.7), (PLANE,)),
    "luminance": (luminance, (IMAGE,)),
    "tone, s": (lambda x: _tone(x, 1.8, 0.4), (PLANE,)),
    "tone, straight": (lambda x: _tone(x, 0.7, 0.4), (PLANE,)),
    "sRGB": (linear_to_srgb, (draw(3, 5, low=0.004),)),
    "sRGB near black": (linear_to_srgb, (draw(7, low=1e-4, high=3e-3),)),
    "processing": (
        Processing(
            denoise_luma_px=0.8,
            denoise_luma_level=0.1,
            denoise_chroma_px=1.0,
            sharpen_amount=0.5,
            contrast=1.3,
            pivot=0.4,
            brightness=0.02,
            saturation=0.8,
        ),
        (draw(1, 3, 4, 5, low=0.15, high=0.45),),
    ),
}


def test_a_wrong_slope_and_a_picture_that_heeds_another_are_noticed() -> None:
    assert all_slopes_agree(torch.exp, IMAGE)
    assert not all_slopes_agree(lambda x: x.exp() + 0.01 * x.detach().square(), IMAGE)
    assert not all_slopes_agree(lambda x: x + 0.01 * (x * x).mean(0), IMAGE)


@pytest.mark.parametrize("name", STAGES)
def test_finite_differences_agree(name: str) -> None:
    stage, inputs = STAGES[name]
    assert gradcheck(stage, inputs)


def test_every_aberration_has_its_slope() -> None:
    # Two places and two colours; defocus, spherical, coma, astigmatism, curvature, and the place.
    def kernels(field: torch.Tensor, *waves: torch.Tensor) -> torch.Tensor:
        return pupil_kernel(Seidel(*waves).waves(field, 8), 2.0, 550, 1.0, 1)

    waves = [draw(2, 2, low=-0.5, high=0.5, seed=seed) for seed in range(5)]
    assert gradcheck(kernels, (draw(2, 2, seed=9), *waves))


def test_the_whole_lens_has_its_slope_in_light_and_place() -> None:
    optics = Optics(
        f_number=1.4,
        pitch_um=10.0,
        defocus_um=9.0,
        axial_colour_um=(5.0, 0.0, 8.0),
        coma_waves=0.8,
        astigmatism_waves=0.5,
        curvature_waves=0.4,
        distortion=(0.1, 0.4),
        lateral_colour_um=(2.0, 0.0, -3.0),
        natural_vignetting=True,
        rim_radius_mm=1.5,
        rim_distance_mm=1.0,
    )

    def lens(light: torch.Tensor, field: torch.Tensor) -> torch.Tensor:
        return optics(light, supersampling=1, field_mm=field)

    places = torch.tensor([[1.5, 0.7], [-0.4, 1.1]], dtype=torch.float64, requires_grad=True)
    assert gradcheck(lens, (draw(2, 3, 2, 3), places))


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("pattern", PATTERNS)
def test_interpolation_has_its_slope_away_from_ties(pattern: str, method: str) -> None:
    light = draw(1, 3, 6, 5)
    assert all_slopes_agree(lambda x: demosaic(mosaic(x, pattern), pattern, method), light)


SENSOR = Sensor(1e4, read_noise_e=20.0, dark_current_e_per_s=50.0, bits=8, black_level_dn=9)


@pytest.mark.parametrize("channels", [1, 3])
def test_the_sensor_has_its_slope_without_rounding(channels: int) -> None:
    # Noise is fixed by its seeds. A converter of 8 bits: with rounding no step would be small.
    light = draw(2, channels, 4, 3)
    assert gradcheck(lambda x: SENSOR(x, [3, 4], differentiable=True, rounding=False), (light,))


@pytest.mark.parametrize("low", [-0.2, 0.1], ids=["below black, beyond white", "in between"])
def test_the_sensors_gradient_with_rounding_is_the_same(low: float) -> None:
    light, share = draw(2, 3, 20, 20, low=low, high=1 - low), draw(2, 3, 20, 20, seed=1).detach()
    rounded = SENSOR(light, [3, 4], differentiable=True)
    analogue = SENSOR(light, [3, 4], differentiable=True, rounding=False)
    assert torch.equal(rounded, analogue.round())
    slopes = [torch.autograd.grad((x * share).sum(), light)[0] for x in (rounded, analogue)]
    assert torch.equal(*slopes)
    assert float(slopes[0].abs().max()) > 100


@pytest.mark.parametrize("quality", [20, 90])
@pytest.mark.parametrize("chroma", SHARING)
def test_soft_jpeg_has_its_slope_in_every_pixel(chroma: str, quality: int) -> None:
    image = draw(1, 3, 9, 5, low=0.2, high=0.8)
    assert all_slopes_agree(lambda x: soft_jpeg(x, quality, chroma), image)


@pytest.mark.parametrize("chroma", SHARING)
def test_the_stand_ins_gradient_with_eight_bits_is_the_same(chroma: str) -> None:
    images, share = draw(2, 3, 17, 19), draw(2, 3, 17, 19, seed=1).detach()
    pair = (jpeg_differentiable(images, 40, chroma=chroma), soft_jpeg(images, 40, chroma))
    slopes = [torch.autograd.grad((x * share).sum(), images)[0] for x in pair]
    assert torch.equal(*slopes)
    assert torch.equal(pair[0] * 255, (pair[1] * 255).round())


def test_the_exposure_has_the_slope_of_its_gain() -> None:
    light = draw(2, 3, 2, 2).detach().float().requires_grad_()
    exposed = expose(light, torch.tensor([0.5, 2.0]), 1.0)
    exposed.sum().backward()
    assert light.grad is not None
    assert torch.equal(light.grad, torch.tensor([3.6, 0.9])[:, None, None, None].expand_as(light))


def test_the_whole_chain_has_its_slope_without_rounding(monkeypatch: pytest.MonkeyPatch) -> None:
    for module in (camera, codec, encoding):
        monkeypatch.setattr(module, "quantise", lambda srgb, differentiable: srgb)
    monkeypatch.setattr(Sensor, "forward", partialmethod(Sensor.forward, rounding=False))
    whole = Camera(
        codec="differentiable",
        optics=Optics(f_number=1.4, defocus_um=5.0, distortion=(0.1, 0.4), natural_vignetting=True),
        supersampling=2,
        colour=Colour(FILTERS),
        mosaic=Mosaic("GRBG", "edge_aware"),
        sensor=Sensor(5000.0),
        processing=Processing(denoise_luma_px=0.7, sharpen_amount=0.3, contrast=1.1),
        origin_px=(3, 5),
        field_mm=(1.0, 0.5),
    )
    stored = Jpeg(60, "4:2:2")

    def photograph(exposed: torch.Tensor) -> torch.Tensor:
        # What Camera.forward does behind the exposure, which takes single precision only.
        frames = whole.develop(whole.gather(exposed), [7] * len(exposed))[None]
        return stored(frames, origin_px=whole.origin_px, differentiable=True)

    assert all_slopes_agree(photograph, draw(1, 3, 6, 8, low=0.3, high=0.5))
