"""How does a wide lens bend straight lines? Brown's radial polynomial, both ways."""

from dataclasses import dataclass

import torch

from lrsr.camera.checks import check_positive
from lrsr.camera.image_plane import turn
from lrsr.errors import InputError

_STEPS = 25
"""Newton's steps; half of them reach float64's end over the whole reference sensor."""


@dataclass(frozen=True)
class Distortion:
    """From the sensor to the plane of a pinhole camera: p (1 + k1 r² + k2 r⁴), r = ‖p‖ / f.

    The direction is Brown's own (1966; Wikipedia's "Brown-Conrady", not OpenCV's, which goes from
    the pinhole to the sensor and folds back upon itself beyond 53° for a lens like the reference
    camera's). Positive coefficients make barrels.

    Attributes:
        k1: Third order, no unit.
        k2: Fifth order, no unit.
        focal_mm: Focal length, mm, > 0.
        radius_mm: Farthest place on the sensor, mm, > 0; up to there no two places see the same.
        facing: Films of crops are those of a camera turned towards the middle of the crop, as the
            renderer makes them; else they are cut from the picture of a straight pinhole camera.

    Raises:
        InputError: A length is not positive, or the polynomial turns back before ``radius_mm``.
    """

    k1: float = 0.0
    k2: float = 0.0
    focal_mm: float = 3.0
    radius_mm: float = 2.92
    facing: bool = True

    def __post_init__(self) -> None:
        """Check the numbers.

        Raises:
            InputError: They cannot be a lens.
        """
        check_positive(focal_mm=self.focal_mm, radius_mm=self.radius_mm)
        radii = torch.linspace(0, self.radius_mm / self.focal_mm, 257, dtype=torch.float64)
        slope = 1 + 3 * self.k1 * radii**2 + 5 * self.k2 * radii**4
        if not bool((slope > 0).all()):
            raise InputError(
                f"distortion ({self.k1:g}, {self.k2:g}) folds the picture within "
                f"{self.radius_mm:g} mm of its centre: give coefficients nearer 0"
            )

    @property
    def is_off(self) -> bool:
        """Are all lines as a pinhole camera draws them?"""
        return not (self.k1 or self.k2)

    def undistort(self, points_mm: torch.Tensor) -> torch.Tensor:
        """Return where a pinhole camera would see what the sensor sees at ``points_mm``.

        Args:
            points_mm: ``(..., 2)``, places on the sensor, mm from the optical axis.

        Returns:
            ``(..., 2)``, mm from the optical axis.

        Example:
            >>> Distortion(0.1, focal_mm=1.0).undistort(torch.tensor([1.0, 0.0])).tolist()
            [1.100000023841858, 0.0]
        """
        square = self._square(points_mm)
        return points_mm * (1 + self.k1 * square + self.k2 * square**2)

    def distort(self, points_mm: torch.Tensor) -> torch.Tensor:
        """Invert :meth:`undistort` by Newton's method; the gradient goes through its steps.

        Args:
            points_mm: ``(..., 2)``, places on the pinhole camera's plane, mm from the optical axis.

        Returns:
            ``(..., 2)``, places on the sensor, mm.
        """
        third = self._square(points_mm) * self.k1
        fifth = self._square(points_mm) ** 2 * self.k2
        factor = torch.ones_like(third)
        for _ in range(_STEPS):
            miss = factor + third * factor**3 + fifth * factor**5 - 1
            slope = 1 + 3 * third * factor**2 + 5 * fifth * factor**4
            factor = factor - miss / slope
        return points_mm * factor

    def to_film(self, sensor_mm: torch.Tensor, centre_mm: torch.Tensor) -> torch.Tensor:
        """Go from the sensor to a crop's film.

        Args:
            sensor_mm: ``(..., 2)``, places on the sensor, mm from the optical axis.
            centre_mm: Middle of the crop on the sensor, mm from the optical axis; broadcasts.

        Returns:
            ``(..., 2)``, mm from the middle of the film.

        Example:
            >>> middle = torch.tensor([1.0, 0.5])
            >>> Distortion(0.1).to_film(middle, middle).abs().lt(1e-6).tolist()
            [True, True]
        """
        if self.is_off:
            return sensor_mm - centre_mm
        plane, middle = self.undistort(sensor_mm), self.undistort(centre_mm)
        return turn(plane, middle, self.focal_mm) if self.facing else plane - middle

    def to_sensor(self, film_mm: torch.Tensor, centre_mm: torch.Tensor) -> torch.Tensor:
        """Invert :meth:`to_film`; ``film_mm`` is in mm from the middle of the film."""
        if self.is_off:
            return film_mm + centre_mm
        middle = self.undistort(centre_mm)
        if self.facing:
            return self.distort(turn(film_mm, middle, self.focal_mm, back=True))
        return self.distort(film_mm + middle)

    def area_ratio(self, points_mm: torch.Tensor) -> torch.Tensor:
        """Return how much of the pinhole's plane one unit of sensor sees.

        Args:
            points_mm: ``(..., 2)``, places on the sensor, mm from the optical axis.

        Returns:
            ``(..., 1)``, > 0; above 1 where the lens squeezes.
        """
        square = self._square(points_mm)
        across = 1 + self.k1 * square + self.k2 * square**2
        return across * (1 + 3 * self.k1 * square + 5 * self.k2 * square**2)

    def _square(self, points_mm: torch.Tensor) -> torch.Tensor:
        return points_mm.square().sum(-1, keepdim=True) / self.focal_mm**2
