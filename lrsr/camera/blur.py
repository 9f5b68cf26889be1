"""How does one lens spread points of each colour, at each place? Its kernels."""

import math
from dataclasses import dataclass

import torch

from lrsr.camera.aberrations import Seidel, defocus_waves
from lrsr.camera.checks import check_positive, number
from lrsr.camera.diffraction import airy_kernel, diffraction_length_um
from lrsr.camera.pupil import pupil_kernel
from lrsr.errors import InputError

_TAIL = 16
"""How far kernels reach beyond the geometric blur, in λ / (2A): 98.7 % of an Airy disk's light."""
_STEP = 8
"""Pupils have multiples of so many samples: their Fourier transforms are fast."""
_WAVES = ("spherical_waves", "coma_waves", "astigmatism_waves", "curvature_waves")
"""Seidel's aberrations, in the order of :class:`lrsr.camera.aberrations.Seidel`."""
_MAX_PUPIL = 1024
"""Samples across the pupil at most: enough for 120 waves of defocus."""


@dataclass(frozen=True)
class Blur:
    """Diffraction, defocus, axial colour and Seidel's aberrations; all numbers are plain.

    Attributes:
        f_number: Focal length over diameter of the pupil, > 0.
        focal_mm: Focal length, mm, > 0.
        wavelengths_nm: Of each colour, nm, > 0; waves are those of the middle one.
        defocus_um: How far behind the film the focus lies, µm, < 0: before it.
        axial_colour_um: What each colour adds to that, µm.
        spherical_waves: W₀₄₀ (:class:`lrsr.camera.aberrations.Seidel`).
        coma_waves: W₁₃₁ at the edge of the field; > 0: tails point outwards.
        astigmatism_waves: W₂₂₂ at the edge of the field.
        curvature_waves: W₂₂₀ at the edge of the field.

    Raises:
        InputError: A number is not finite, or not positive where it must be.
    """

    f_number: float
    focal_mm: float = 3.0
    wavelengths_nm: tuple[float, ...] = (611.4, 549.1, 464.2)
    defocus_um: float = 0.0
    axial_colour_um: tuple[float, ...] = (0.0, 0.0, 0.0)
    spherical_waves: float = 0.0
    coma_waves: float = 0.0
    astigmatism_waves: float = 0.0
    curvature_waves: float = 0.0

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: They cannot be a lens.
        """
        check_positive(f_number=self.f_number, focal_mm=self.focal_mm)
        for wavelength in self.wavelengths_nm:
            check_positive(wavelengths_nm=wavelength)
        for name in ("defocus_um", *_WAVES):
            number(name, getattr(self, name), "a number")

    @property
    def varies(self) -> bool:
        """Does the blur depend on the place in the picture?"""
        return bool(self.coma_waves or self.astigmatism_waves or self.curvature_waves)

    def kernels(self, field: torch.Tensor, pitch_um: float) -> torch.Tensor:
        """Return the image of a point, integrated over pixels.

        Args:
            field: ``(N, 2)``, places in the picture (right, down); length 1 is the edge.
            pitch_um: Of the (film's) pixels, µm, > 0.

        Returns:
            ``(N, C, K, K)``, >= 0, sum 1, dtype of ``field``; N is 1 if all places look the same.

        Raises:
            InputError: The blur is too wide to compute.

        Example:
            >>> Blur(1.4).kernels(torch.zeros(1, 2), 2.65).shape  # red decides: 15 µm and more
            torch.Size([1, 3, 13, 13])
        """
        size = self.pupil_size()
        if not self.varies:
            field = torch.zeros_like(field[:1])
        radius_px = self._radius_px(size, pitch_um)
        kernels = []
        for front, nm in zip(self._wavefronts(), self.wavelengths_nm, strict=True):
            if size:
                waves = front.waves(field, size)
                kernels.append(pupil_kernel(waves, self.f_number, nm, pitch_um, radius_px))
            else:
                perfect = airy_kernel(self.f_number, nm, pitch_um, radius_px)
                kernels.append(perfect[None, None].to(field))
        return torch.cat(kernels, dim=1)

    def pupil_size(self) -> int:
        """Return how many samples across the pupil are needed; 0: the lens is perfect.

        Enough for phases to turn by less than half a wave from one to the next, and for kernels not
        to wrap round, wherever in the field the subject is.

        Raises:
            InputError: The blur is too wide to compute.

        Example:
            >>> Blur(1.4).pupil_size(), Blur(1.4, defocus_um=5.0).pupil_size()
            (0, 56)
        """
        slope = max(front.steepest() for front in self._wavefronts())
        size = _STEP * math.ceil((4 * slope + 3 * _TAIL) / _STEP)
        if size > _MAX_PUPIL:
            raise InputError(
                f"a blur of {slope:.3g} waves per pupil radius is too wide to compute: give less "
                "defocus or aberration"
            )
        return size if slope > 0 else 0

    def _wavefronts(self) -> list[Seidel]:
        """Return one for each colour."""
        fronts = []
        for nm, axial_um in zip(self.wavelengths_nm, self.axial_colour_um, strict=True):
            scale = self.wavelengths_nm[len(self.wavelengths_nm) // 2] / nm
            defocus = defocus_waves(self.defocus_um + axial_um, self.f_number, nm)
            fronts.append(Seidel(defocus, *(getattr(self, name) * scale for name in _WAVES)))
        return fronts

    def _radius_px(self, size: int, pitch_um: float) -> int:
        """Return how far kernels reach: the geometric blur and the tail of diffraction."""
        slope = max(0, size - 3 * _TAIL) / 4
        unit = diffraction_length_um(self.f_number, max(self.wavelengths_nm))
        return math.ceil((2 * slope + _TAIL) * unit / pitch_um)
