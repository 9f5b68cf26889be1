"""By how many waves does a real lens miss the perfect wavefront? Defocus and Seidel's terms."""

from dataclasses import dataclass

import torch

from lrsr.camera.diffraction import numerical_aperture


@dataclass(frozen=True)
class Seidel:
    """Wavefront error at the rim of the pupil, in waves.

    W = defocus ρ² + spherical ρ⁴ + coma h ρ³ cos φ + astigmatism h² ρ² cos² φ + curvature h² ρ²
    (H. Hopkins 1950; W₀₂₀, W₀₄₀, W₁₃₁, W₂₂₂, W₂₂₀), where ρ, φ are the place in the pupil, φ from
    the direction of the field, and h = 1 is the edge of the field. Each is a number or a tensor
    ``(N, C)`` or one that broadcasts to it: N places in the field, C colours.

    Attributes:
        defocus: The same over the whole field.
        spherical: The same over the whole field.
        coma: At the edge of the field; > 0: the tail points away from the picture's centre.
        astigmatism: At the edge of the field; the wavefront bends more along the field's direction.
        curvature: At the edge of the field; defocus that grows outwards.
    """

    defocus: torch.Tensor | float = 0.0
    spherical: torch.Tensor | float = 0.0
    coma: torch.Tensor | float = 0.0
    astigmatism: torch.Tensor | float = 0.0
    curvature: torch.Tensor | float = 0.0

    def waves(self, field: torch.Tensor, size: int) -> torch.Tensor:
        """Return the wavefront over the square around the pupil.

        Args:
            field: ``(N, 2)``, place of the image (right, down); length 1 is the edge of the field.
            size: Samples across the pupil.

        Returns:
            ``(N, C, size, size)``, waves, rows from top to bottom; in the dtype of ``field``.
        """
        rim = (torch.arange(size, dtype=field.dtype, device=field.device) * 2 + 1 - size) / size
        x, y = rim[None, None, None, :], rim[None, None, :, None]
        square = x**2 + y**2
        along = _spread(field[:, :1]) * x + _spread(field[:, 1:]) * y
        height2 = _spread(field.square().sum(1, keepdim=True))
        return (
            (_spread(self.defocus) + _spread(self.curvature) * height2) * square
            + _spread(self.spherical) * square**2
            + _spread(self.coma) * along * square
            + _spread(self.astigmatism) * along**2
        )

    def steepest(self) -> float:
        """Return a bound on the wavefront's slope anywhere in the field, waves per pupil radius.

        2 λ / (2A) times the slope is how far light lands from where it should. All terms must be
        numbers.

        Example:
            >>> Seidel(defocus=-1.0, coma=0.5).steepest()
            3.5
        """
        weights = {"defocus": 2, "astigmatism": 2, "curvature": 2, "spherical": 4, "coma": 3}
        return sum(weight * abs(float(getattr(self, term))) for term, weight in weights.items())


def _spread(number: torch.Tensor | float) -> torch.Tensor | float:
    return number[..., None, None] if isinstance(number, torch.Tensor) else number


def defocus_waves(shift_um: float, f_number: float, wavelength_nm: float) -> float:
    """Return W₀₂₀ of a film that is out of focus, waves at the rim of the pupil.

    W₀₂₀ = δ A / (4 N λ), which for narrow cones is the text books' δ / (8 N² λ). The blur disk, 4
    W₀₂₀ λ / A wide, then is the cone of light cut by the film: δ / N.

    Args:
        shift_um: From film to focus, µm.
        f_number: Focal length over diameter of the entrance pupil, > 0.
        wavelength_nm: Of the light, nm, > 0.

    Raises:
        InputError: The f-number is not positive.

    Example:
        >>> round(defocus_waves(10.0, 4.0, 550), 3)
        0.141
    """
    return shift_um * (1000 * numerical_aperture(f_number) / (4 * f_number)) / wavelength_nm
