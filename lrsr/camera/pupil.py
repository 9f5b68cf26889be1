"""How wide is a point of light behind a real lens? The pupil's Fourier transform, on pixels."""

import math

import torch

from lrsr.camera.checks import check_positive
from lrsr.camera.diffraction import diffraction_length_um

_CHUNK_SAMPLES = 2**20
"""Samples of pupils that are transformed at a time, some tens of MB."""


def _pupil_transmission(size: int) -> torch.Tensor:
    """Return the round pupil in its square; its rim covers samples in part.

    Args:
        size: Samples across the diameter, >= 1.

    Returns:
        ``(size, size)`` float64, [0, 1].

    Example:
        >>> round(float(_pupil_transmission(64).mean()) * 4, 2)  # π
        3.14
    """
    rim = (torch.arange(size, dtype=torch.float64) * 2 + 1 - size) / size
    return ((1 - torch.hypot(rim[:, None], rim)) * size / 2 + 0.5).clamp(0, 1)


def pupil_kernel(
    waves: torch.Tensor, f_number: float, wavelength_nm: float, pitch_um: float, radius_px: int
) -> torch.Tensor:
    """Integrate the image of a point over each pixel around where it should be.

    The image is ``|FFT(pupil exp(2πi W))|²`` (Goodman, Introduction to Fourier Optics, 6.1). Twice
    the pupil's samples show it at every λ / (4A), the Nyquist rate, so its integral over a pixel is
    a sum of those samples with known weights. It repeats every ``size`` λ / (2A): the kernel should
    be narrower than that, and W should change by less than half a wave from sample to sample.

    Args:
        waves: ``(..., size, size)``, W over the square around the pupil, in waves; real.
        f_number: Focal length over diameter of the entrance pupil, > 0.
        wavelength_nm: Of the light, nm, > 0.
        pitch_um: Of the (film's) pixels, µm, > 0.
        radius_px: The kernel reaches so far from its central pixel, >= 0.

    Returns:
        ``(..., 2 radius_px + 1, 2 radius_px + 1)``, >= 0, sum 1, in the dtype of ``waves``;
        rows from top to bottom, columns from left to right.

    Raises:
        InputError: A number is not positive.

    Example:
        >>> perfect = torch.zeros(64, 64)
        >>> pupil_kernel(perfect, 1.4, 550, 2.65, 1)[1].mul(100).round().tolist()
        [2.0, 92.0, 2.0]
    """
    check_positive(pitch_um=pitch_um)
    size = waves.shape[-1]
    pitch = pitch_um / diffraction_length_um(f_number, wavelength_nm)
    weights = _pixel_weights(size, pitch, radius_px).to(waves)
    few = max(1, _CHUNK_SAMPLES // size**2)
    fronts = torch.split(waves.reshape(-1, size, size), few)
    parts = [weights @ _intensity(front) @ weights.T for front in fronts]
    side = len(weights)
    kernel = torch.cat(parts).clamp_min(0).reshape(*waves.shape[:-2], side, side)
    return kernel / kernel.sum((-2, -1), keepdim=True)


def _intensity(waves: torch.Tensor) -> torch.Tensor:
    """Return ``(..., 2 size, 2 size)``: the image at every λ / (4A), its middle at [size, size]."""
    size = waves.shape[-1]
    pupil = torch.polar(_pupil_transmission(size).to(waves).expand_as(waves), 2 * math.pi * waves)
    light = torch.fft.fft2(pupil, s=(2 * size, 2 * size))
    intensity: torch.Tensor = torch.fft.fftshift(light.real**2 + light.imag**2, dim=(-2, -1))
    return intensity


def _pixel_weights(size: int, pitch: float, radius_px: int) -> torch.Tensor:
    """Return ``(2 radius_px + 1, 2 size)``: each pixel's integral as a sum of Nyquist samples.

    Band-limited interpolation (a Dirichlet kernel) times the pixel's own transfer, sinc(pitch ν);
    the highest frequency is left out: no lens passes it.
    """
    frequency = torch.arange(size, dtype=torch.float64) / size
    samples = torch.arange(-size, size, dtype=torch.float64) / 2
    centres = torch.arange(-radius_px, radius_px + 1, dtype=torch.float64) * pitch
    at_samples = 2 * math.pi * frequency[:, None] * samples
    at_centres = 2 * math.pi * centres[:, None] * frequency
    passed = torch.sinc(pitch * frequency)
    passed[1:] *= 2  # the frequencies below zero
    return (at_centres.cos() * passed) @ at_samples.cos() + (
        at_centres.sin() * passed
    ) @ at_samples.sin()
