"""How does one lens spread points of each colour, at each place and distance? Its kernels."""

import math
from dataclasses import dataclass

import torch

from lrsr.camera.aberrations import Seidel, defocus_waves, focus_shift_um
from lrsr.camera.checks import check_positive, check_setting, number
from lrsr.camera.convolution import convolve
from lrsr.camera.diffraction import airy_kernel, diffraction_length_um
from lrsr.camera.pupil import pupil_kernel
from lrsr.errors import InputError

TAIL = 16
"""How far kernels reach beyond the geometric blur, in λ / (2A): 98.7 % of an Airy disk's light."""
STEP = 8
"""Pupils have multiples of so many samples: their Fourier transforms are fast."""
WAVES = ("spherical_waves", "coma_waves", "astigmatism_waves", "curvature_waves")
"""Seidel's aberrations, in the order of :class:`lrsr.camera.aberrations.Seidel`."""
MAX_PUPIL = 1024
"""Samples across the pupil at most: enough for 120 waves of defocus."""


@dataclass(frozen=True)
class Blur:
    """Diffraction, defocus, axial colour and Seidel's aberrations; all numbers are plain.

    Attributes:
        f_number: Focal length over diameter of the pupil, > 0.
        focal_mm: Focal length, mm, > 0.
        wavelengths_nm: Of each colour, nm, > 0; waves are those of the middle one.
        focus_m: Distance that is sharp, m; None: the subject, wherever it is.
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
    focus_m: float | None = None
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
        if self.focus_m is not None:
            check_setting(
                "focus_m", self.focus_m, 1000 * self.focus_m > self.focal_mm, "> focal_mm"
            )
        for name in ("defocus_um", *WAVES):
            number(name, getattr(self, name), "a number")

    @property
    def varies(self) -> bool:
        """Does the blur depend on the place in the picture?"""
        return bool(self.coma_waves or self.astigmatism_waves or self.curvature_waves)

    def kernels(
        self, field: torch.Tensor, pitch_um: float, subject_m: torch.Tensor | float | None = None
    ) -> torch.Tensor:
        """Return the image of a point, integrated over pixels.

        Args:
            field: ``(N, 2)``, places in the picture (right, down); length 1 is the edge.
            pitch_um: Of the (film's) pixels, µm, > 0.
            subject_m: Lens to subject, m, or a tensor ``(N,)``; matters only with ``focus_m``.

        Returns:
            ``(N, C, K, K)``, >= 0, sum 1, dtype of ``field``; N is 1 if all places look the same.

        Raises:
            InputError: The subject's distance is missing, or the blur is too wide to compute.

        Example:
            >>> Blur(1.4).kernels(torch.zeros(1, 2), 2.65).shape  # red decides: 15 µm and more
            torch.Size([1, 3, 13, 13])
        """
        sizes = self.pupil_sizes(subject_m)
        size = int(sizes.max())
        if not self.varies:
            field = torch.zeros_like(field[:1])
        radius_px = self._radius_px(size, pitch_um)
        if not size:
            perfect = [
                airy_kernel(self.f_number, nm, pitch_um, radius_px) for nm in self.wavelengths_nm
            ]
            return torch.stack(perfect)[None].to(field)
        kernels = [
            pupil_kernel(front.waves(field, size), self.f_number, nm, pitch_um, radius_px)
            for front, nm in zip(
                self._wavefronts(subject_m, field), self.wavelengths_nm, strict=True
            )
        ]
        return torch.cat(kernels, dim=1)

    def spread(
        self,
        film: torch.Tensor,
        field: torch.Tensor,
        pitch_um: float,
        subject_m: torch.Tensor | float | None = None,
    ) -> torch.Tensor:
        """Blur pictures; those that need kernels of one size together, so that none sees another.

        Args:
            film: ``(B, C, H, W)``, linear light.
            field: ``(1, 2)`` or ``(B, 2)``, places of their middles; length 1 is the edge.
            pitch_um: See :meth:`kernels`.
            subject_m: See :meth:`kernels`.

        Returns:
            ``(B, C, H, W)``.

        Raises:
            InputError: Not one distance for each image, or a blur that cannot be computed.
        """
        sizes = self.pupil_sizes(subject_m)
        if len(sizes) == 1 or not isinstance(subject_m, torch.Tensor):
            return convolve(film, self.kernels(field, pitch_um, subject_m))
        if len(sizes) != len(film):
            raise InputError(f"subject_m: {len(sizes)} distances for {len(film)} images")
        result = torch.empty_like(film)
        for size in sorted(set(sizes.tolist())):
            alike = (sizes == size).to(film.device)
            places = field if len(field) == 1 else field[alike]
            blurred = convolve(film[alike], self.kernels(places, pitch_um, subject_m[alike]))
            result = result.masked_scatter(alike[:, None, None, None], blurred)
        return result

    def pupil_sizes(self, subject_m: torch.Tensor | float | None = None) -> torch.Tensor:
        """Return how many samples across the pupil each subject needs; 0: the lens is perfect.

        Enough for phases to turn by less than half a wave from one to the next, and for kernels not
        to wrap round, wherever in the field the subject is. The kernels' size depends on it, so
        subjects of different needs are better kept apart: then none depends on another.

        Args:
            subject_m: Lens to subject, m, or a tensor ``(N,)``; matters only with ``focus_m``.

        Returns:
            ``(N,)`` or ``(1,)`` int64.

        Raises:
            InputError: The subject's distance is missing, or the blur is too wide to compute.

        Example:
            >>> Blur(1.4, focus_m=1.0).pupil_sizes(torch.tensor([1.0, 0.2])).tolist()
            [0, 88]
        """
        like = torch.zeros(1, dtype=torch.float64)
        fronts = self._wavefronts(subject_m, like)
        slopes = torch.stack([front.steepest().reshape(-1) for front in fronts]).amax(0)
        sizes = STEP * torch.ceil((4 * slopes + 3 * TAIL) / STEP).long()
        if int(sizes.max()) > MAX_PUPIL:
            raise InputError(
                f"a blur of {float(slopes.max()):.3g} waves per pupil radius is too wide to "
                "compute: give less defocus or aberration"
            )
        return torch.where(slopes > 0, sizes, 0)

    def _wavefronts(
        self, subject_m: torch.Tensor | float | None, like: torch.Tensor
    ) -> list[Seidel]:
        """Return one for each colour."""
        shift_um = self._subject_shift_um(subject_m, like)
        fronts = []
        for nm, axial_um in zip(self.wavelengths_nm, self.axial_colour_um, strict=True):
            scale = self.wavelengths_nm[len(self.wavelengths_nm) // 2] / nm
            defocus = defocus_waves(shift_um + (self.defocus_um + axial_um), self.f_number, nm)
            fronts.append(Seidel(defocus, *(getattr(self, name) * scale for name in WAVES)))
        return fronts

    def _radius_px(self, size: int, pitch_um: float) -> int:
        """Return how far kernels reach: the geometric blur and the tail of diffraction."""
        slope = max(0, size - 3 * TAIL) / 4
        unit = diffraction_length_um(self.f_number, max(self.wavelengths_nm))
        return math.ceil((2 * slope + TAIL) * unit / pitch_um)

    def _subject_shift_um(
        self, subject_m: torch.Tensor | float | None, like: torch.Tensor
    ) -> torch.Tensor | float:
        """Return 0, or ``(N, 1)``: how far behind the film each subject is sharp.

        Raises:
            InputError: The subject's distance is missing, or shorter than the focal length.
        """
        if self.focus_m is None:
            return 0.0
        if subject_m is None:
            raise InputError(f"subject_m: with focus_m={self.focus_m:g}, give its distance too")
        distance = torch.as_tensor(subject_m, dtype=like.dtype, device=like.device)
        return torch.as_tensor(focus_shift_um(distance.reshape(-1, 1), self.focus_m, self.focal_mm))
