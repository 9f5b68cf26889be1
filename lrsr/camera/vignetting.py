"""How much darker are the corners? The cos⁴ law, and rims that cut the light's bundle."""

import math
from dataclasses import dataclass

import torch

from lrsr.camera.checks import check_positive
from lrsr.camera.distortion import Distortion
from lrsr.camera.image_plane import pixel_grid, pixels_to_mm
from lrsr.errors import InputError


@dataclass(frozen=True)
class Vignetting:
    """What of a lens's light each place on the sensor gets.

    Attributes:
        distortion: Of the lens; also holds its focal length.
        natural: cos⁴ law, and what distortion gives back.
        pupil_radius_mm: Of the entrance pupil, mm, > 0; a rim needs it.
        rim_radius_mm: Of a rim before the pupil, mm, > 0; None: there is none.
        rim_distance_mm: From the pupil to that rim, mm, > 0.

    Raises:
        InputError: Only one of the rim's lengths is given, or a length is not positive.
    """

    distortion: Distortion
    natural: bool = False
    pupil_radius_mm: float | None = None
    rim_radius_mm: float | None = None
    rim_distance_mm: float | None = None

    def __post_init__(self) -> None:
        """Check the rim.

        Raises:
            InputError: It cannot be one.
        """
        radius, distance = self.rim_radius_mm, self.rim_distance_mm
        if bool(radius) != bool(distance):
            raise InputError(
                f"rim_radius_mm={radius}, rim_distance_mm={distance}: give both or neither"
            )
        if radius and distance:
            check_positive(rim_radius_mm=radius, rim_distance_mm=distance)

    def darken(self, film: torch.Tensor, field: torch.Tensor, pitch_mm: float) -> torch.Tensor:
        """Give each pixel of a crop its share of the light.

        Args:
            film: ``(B, C, H, W)``, linear light.
            field: ``(1, 2)`` or ``(B, 2)``, the crop's middle on the sensor, mm from the axis.
            pitch_mm: Of the film's pixels, mm.

        Returns:
            ``(B, C, H, W)``, unchanged on the axis; ``film`` itself if all is off.
        """
        if not (self.natural or self.rim_radius_mm):
            return film
        size = (film.shape[-2], film.shape[-1])
        places = pixels_to_mm(pixel_grid(size, film), size, pitch_mm, field[:, None, None])
        if self.natural:
            film = film * natural_vignetting(places, self.distortion).permute(0, 3, 1, 2)
        if self.pupil_radius_mm and self.rim_radius_mm and self.rim_distance_mm:
            share = _mechanical_vignetting(
                places,
                self.distortion,
                pupil_radius_mm=self.pupil_radius_mm,
                rim_radius_mm=self.rim_radius_mm,
                rim_distance_mm=self.rim_distance_mm,
            )
            film = film * share.permute(0, 3, 1, 2)
        return film


def natural_vignetting(points_mm: torch.Tensor, distortion: Distortion) -> torch.Tensor:
    """Return the light on the sensor for a scene of one brightness, 1 on the axis.

    cos⁴ θ of the angle from which the light comes, times how much more of the scene a barrel
    squeezes onto each piece of sensor (without distortion that is 1: the cos⁴ law; H. Reiss 1945,
    doi:10.1364/JOSA.35.000283). Pupils that grow towards the edge are not modelled.

    Args:
        points_mm: ``(..., 2)``, places on the sensor, mm from the optical axis.
        distortion: Of the lens; also holds its focal length.

    Returns:
        ``(..., 1)``, > 0.

    Example:
        >>> pinhole = Distortion(focal_mm=3.0)
        >>> natural_vignetting(torch.tensor([3.0, 0.0]), pinhole).item()  # cos⁴ 45°
        0.25
    """
    square = distortion.undistort(points_mm).square().sum(-1, keepdim=True)
    cosine2 = 1 / (1 + square / distortion.focal_mm**2)
    return cosine2**2 * distortion.area_ratio(points_mm)


def _mechanical_vignetting(
    points_mm: torch.Tensor,
    distortion: Distortion,
    *,
    pupil_radius_mm: float,
    rim_radius_mm: float,
    rim_distance_mm: float,
) -> torch.Tensor:
    """Return the share of the pupil that a rim in front of it leaves open.

    Seen along a ray at θ the rim is a circle moved by ``rim_distance_mm`` tan θ across the pupil;
    what passes is where the two overlap.

    Args:
        points_mm: ``(..., 2)``, places on the sensor, mm from the optical axis.
        distortion: Of the lens; also holds its focal length.
        pupil_radius_mm: Of the entrance pupil, mm, > 0.
        rim_radius_mm: Of the rim, mm, > 0.
        rim_distance_mm: Between the two, mm, > 0.

    Returns:
        ``(..., 1)``, [0, 1]; 1 on the axis if the rim is no smaller than the pupil.

    Raises:
        InputError: A length is not positive.

    Example:
        >>> axis = torch.zeros(2)
        >>> _mechanical_vignetting(axis, Distortion(), pupil_radius_mm=1.0, rim_radius_mm=1.5,
        ...                       rim_distance_mm=2.0).item()
        1.0
    """
    check_positive(
        pupil_radius_mm=pupil_radius_mm,
        rim_radius_mm=rim_radius_mm,
        rim_distance_mm=rim_distance_mm,
    )
    slope = distortion.undistort(points_mm) / distortion.focal_mm
    moved2 = slope.square().sum(-1, keepdim=True) * rim_distance_mm**2
    return _overlap(moved2, pupil_radius_mm, rim_radius_mm) / (math.pi * pupil_radius_mm**2)


def _overlap(distance2: torch.Tensor, first: float, second: float) -> torch.Tensor:
    """Return the area that two circles share, from the square of their centres' distance."""
    small, large = min(first, second), max(first, second)
    apart, within = distance2 >= (first + second) ** 2, distance2 <= (large - small) ** 2
    # Where one circle holds all or nothing of the other, any harmless distance: its value and
    # gradient are thrown away, but must be finite.
    crossing = torch.where(apart | within, torch.full_like(distance2, large**2), distance2)
    d = crossing.sqrt()
    shared = torch.zeros_like(d)
    for one, other in ((small, large), (large, small)):
        chord = (crossing + one**2 - other**2) / (2 * d)
        shared = shared + one**2 * (chord / one).clamp(-1, 1).acos()
        shared = shared - chord * (one**2 - chord**2).clamp_min(0).sqrt()
    whole = torch.full_like(d, math.pi * small**2)
    return torch.where(within, whole, torch.where(apart, torch.zeros_like(d), shared))
