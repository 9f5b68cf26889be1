"""How wide is a point of light behind a perfect lens? The Airy disk, integrated over pixels."""

import math
from functools import lru_cache

import torch

from lrsr.camera.checks import check_positive

_MARGIN = 64
"""Where the tails of the Airy disk may wrap round, in units of λ / (2A): 0.5 % of the light."""


def numerical_aperture(f_number: float) -> float:
    """Return A = 1 / sqrt(4 N² + 1) (paper, eq. 2): the sine of the half-angle of the light cone.

    Args:
        f_number: Focal length over diameter of the entrance pupil, > 0.

    Raises:
        InputError: The f-number is not positive.

    Example:
        >>> round(numerical_aperture(1.4), 4)
        0.3363
    """
    check_positive(f_number=f_number)
    return 1 / math.sqrt(4 * f_number**2 + 1)


def diffraction_length_um(f_number: float, wavelength_nm: float) -> float:
    """Return λ / (2A), µm: the finest period that passes the lens, the unit of all kernels here.

    Args:
        f_number: Focal length over diameter of the entrance pupil, > 0.
        wavelength_nm: Of the light, nm, > 0.

    Raises:
        InputError: A number is not positive.
    """
    check_positive(wavelength_nm=wavelength_nm)
    return wavelength_nm * 1e-3 / (2 * numerical_aperture(f_number))


def _diffraction_transfer(frequency: torch.Tensor) -> torch.Tensor:
    """Return the contrast that a perfect lens keeps: (2/π) (acos ν - ν sqrt(1 - ν²)).

    Args:
        frequency: Any shape, ν in periods per λ / (2A), >= 0; nothing passes from 1 on.

    Example:
        >>> _diffraction_transfer(torch.tensor([0.0, 1.0, 2.0])).tolist()
        [1.0, 0.0, 0.0]
    """
    inside = frequency.clamp(0, 1)
    contrast: torch.Tensor = inside.acos() - inside * (1 - inside**2).sqrt()
    return contrast * (2 / math.pi)


@lru_cache(maxsize=64)
def airy_kernel(
    f_number: float, wavelength_nm: float, pitch_um: float, radius_px: int
) -> torch.Tensor:
    """Integrate the Airy disk over each pixel around its centre.

    The integral is exact: the lens' transfer function times that of the square pixel, summed over
    frequencies close enough for the disk's images not to overlap. Light outside the kernel is
    added to it in proportion.

    Args:
        f_number: Focal length over diameter of the entrance pupil, > 0.
        wavelength_nm: Of the light, nm, > 0.
        pitch_um: Of the (film's) pixels, µm, > 0.
        radius_px: The kernel reaches so far from its central pixel, >= 0.

    Returns:
        ``(2 radius_px + 1, 2 radius_px + 1)`` float64, >= 0, sum 1. Shared: do not write into it.

    Raises:
        InputError: A number is not positive.

    Example:
        >>> airy_kernel(1.4, 550, 2.65, 1)[1].mul(100).round().tolist()  # most stays in its pixel
        [2.0, 92.0, 2.0]
    """
    check_positive(pitch_um=pitch_um)
    pitch = pitch_um / diffraction_length_um(f_number, wavelength_nm)
    count = math.ceil((2 * radius_px + 1) * pitch) + _MARGIN
    frequency = torch.arange(count, dtype=torch.float64) / count
    transfer = _diffraction_transfer(torch.hypot(frequency[:, None], frequency))
    centres = torch.arange(-radius_px, radius_px + 1, dtype=torch.float64) * pitch
    waves = torch.cos(2 * math.pi * centres[:, None] * frequency) * torch.sinc(frequency * pitch)
    waves[:, 1:] *= 2  # the frequencies below zero
    kernel = (waves @ transfer @ waves.T).clamp_min(0)
    return kernel / kernel.sum()
