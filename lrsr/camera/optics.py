"""What does a real lens make of the light before the sensor counts it? All its faults, in order.

:mod:`lrsr.camera.warp` says where the light lands, :mod:`lrsr.camera.vignetting` how much of it,
:mod:`lrsr.camera.blur` how it spreads.
"""

from collections.abc import Sequence
from typing import Any

import torch
from torch import nn
from torch.nn import functional as F

from lrsr.camera.blur import Blur
from lrsr.camera.checks import (
    check_flag,
    check_light,
    check_positive,
    check_setting,
    number,
    numbers,
    whole,
)
from lrsr.camera.convolution import convolve
from lrsr.camera.distortion import Distortion
from lrsr.camera.image_plane import Field, read_field
from lrsr.camera.vignetting import Vignetting
from lrsr.camera.warp import Warp
from lrsr.errors import ImageContractError, InputError

_VIEWS = ("facing", "planar")


def bin_pixels(film: torch.Tensor, supersampling: int) -> torch.Tensor:
    """Let each pixel of the sensor gather the light of its part of the film: the mean.

    Args:
        film: ``(B, C, H, W)``, linear light; H and W multiples of ``supersampling``.
        supersampling: Film pixels along a sensor pixel's side, >= 1; at 1 nothing changes.

    Returns:
        ``(B, C, H / supersampling, W / supersampling)``.

    Raises:
        ImageContractError: The film is no whole number of pixels.
        InputError: ``supersampling`` is not a whole number >= 1.

    Example:
        >>> bin_pixels(torch.tensor([[[[0.0, 1.0], [2.0, 3.0]]]]), 2).item()
        1.5
    """
    _check_supersampling(supersampling)
    if any(side % supersampling for side in film.shape[-2:]):
        raise ImageContractError(
            f"film: got {film.shape[-2]}x{film.shape[-1]}, wanted multiples of {supersampling}"
        )
    return film if supersampling == 1 else F.avg_pool2d(film, supersampling)


class Optics(nn.Module):
    """Distortion, lateral colour, vignetting, then blur: each is off unless it is asked for.

    It works on the film as the renderer delivers it, ``supersampling`` times finer than the sensor
    (:func:`bin_pixels` follows), of a crop whose place on the sensor is given. Over one crop the
    blur is the same. Waves are those of the middle wavelength; colours are red, green, blue.

    Args:
        f_number: Focal length over diameter of the pupil; None: no blur of any kind.
        focal_mm: Focal length, mm, > 0.
        pitch_um: Of the sensor's pixels, µm, > 0.
        wavelengths_nm: Of each colour, nm; the default is the renderer's (sRGB's dominant ones).
        field_radius_mm: From the axis to the sensor's corner, mm; faults "at the edge" are there.
        defocus_um: How far behind the film the focus lies, µm, < 0: before it.
        axial_colour_um: What each colour adds to that, µm.
        spherical_waves: W₀₄₀ (:class:`lrsr.camera.aberrations.Seidel`).
        coma_waves: W₁₃₁ at the edge; > 0: tails point outwards.
        astigmatism_waves: W₂₂₂ at the edge.
        curvature_waves: W₂₂₀ at the edge.
        distortion: (k1, k2) of :class:`lrsr.camera.distortion.Distortion`; > 0: barrel.
        view: "facing": the film is that of a camera turned towards the middle of the crop, as the
            renderer makes it; "planar": it was cut from the picture of a straight pinhole camera.
        lateral_colour_um: How far outwards each colour lies at the edge, µm.
        natural_vignetting: cos⁴ law, and what distortion gives back.
        rim_radius_mm: Of a rim before the pupil; None: there is none.
        rim_distance_mm: From the pupil to that rim.

    Raises:
        InputError: A number out of its range, or a fault that needs an f-number without one.

    Example:
        >>> point = torch.zeros(1, 3, 9, 9)
        >>> point[..., 4, 4] = 1.0
        >>> Optics(f_number=8)(point, supersampling=1)[0, :, 4, 4].mul(100).round().tolist()
        [21.0, 25.0, 33.0]
    """

    def __init__(
        self,
        f_number: float | None = None,
        focal_mm: float = 3.0,
        pitch_um: float = 2.65,
        wavelengths_nm: Sequence[float] = (611.4, 549.1, 464.2),
        field_radius_mm: float = 2.92,
        defocus_um: float = 0.0,
        axial_colour_um: Sequence[float] = (0.0, 0.0, 0.0),
        spherical_waves: float = 0.0,
        coma_waves: float = 0.0,
        astigmatism_waves: float = 0.0,
        curvature_waves: float = 0.0,
        distortion: Sequence[float] = (0.0, 0.0),
        view: str = "facing",
        lateral_colour_um: Sequence[float] = (0.0, 0.0, 0.0),
        natural_vignetting: bool = False,
        rim_radius_mm: float | None = None,
        rim_distance_mm: float | None = None,
    ) -> None:
        super().__init__()
        check_positive(pitch_um=pitch_um, focal_mm=focal_mm, field_radius_mm=field_radius_mm)
        if f_number is not None:
            check_positive(f_number=f_number)
        check_setting("view", view, view in _VIEWS, " or ".join(_VIEWS))
        self.pitch_um, self.field_radius_mm = float(pitch_um), float(field_radius_mm)
        k1, k2 = numbers("distortion", distortion, 2)
        lens = Distortion(k1, k2, float(focal_mm), float(field_radius_mm), facing=view == "facing")
        self.warp = Warp(lens, numbers("lateral_colour_um", lateral_colour_um, 3))
        natural = check_flag("natural_vignetting", natural_vignetting)
        pupil_radius_mm = focal_mm / (2 * f_number) if f_number else None
        self.vignetting = Vignetting(lens, natural, pupil_radius_mm, rim_radius_mm, rim_distance_mm)
        faults: dict[str, Any] = {
            "defocus_um": number("defocus_um", defocus_um),
            "spherical_waves": number("spherical_waves", spherical_waves),
            "coma_waves": number("coma_waves", coma_waves),
            "astigmatism_waves": number("astigmatism_waves", astigmatism_waves),
            "curvature_waves": number("curvature_waves", curvature_waves),
        }
        colours = numbers("wavelengths_nm", wavelengths_nm, 3)
        axial = numbers("axial_colour_um", axial_colour_um, 3)
        needing = [name for name, value in faults.items() if value]
        needing += ["axial_colour_um"] * any(axial) + ["rim_radius_mm"] * bool(rim_radius_mm)
        if f_number is None and needing:
            raise InputError(f"{needing[0]} without f_number: give the lens an f-number")
        self.blur = None
        if f_number is not None:
            self.blur = Blur(
                float(f_number), float(focal_mm), colours, axial_colour_um=axial, **faults
            )

    def forward(
        self,
        linear: torch.Tensor,
        *,
        supersampling: int,
        field_mm: Field = (0.0, 0.0),
    ) -> torch.Tensor:
        """Send the light through the lens.

        Args:
            linear: ``(B, 3, H, W)``, linear light on the film, >= 0.
            supersampling: Film pixels along a sensor pixel's side, >= 1.
            field_mm: Middle of the crop on the sensor, (right, down) from the axis, mm; or a
                tensor ``(B, 2)``.

        Returns:
            ``(B, 3, H, W)``, linear light, >= 0, still on the film; ``linear`` itself if all is
            off.

        Raises:
            ImageContractError: The light breaks the contract.
            InputError: The crop lies off the sensor, or the blur is too wide to compute.
        """
        check_light(linear)
        _check_supersampling(supersampling)
        field = read_field(field_mm, linear, self.field_radius_mm)
        pitch_um = self.pitch_um / supersampling
        film = self.warp.draw(linear, field, pitch_um / 1000)
        film = self.vignetting.darken(film, field, pitch_um / 1000)
        if self.blur is not None:
            film = convolve(film, self.blur.kernels(field / self.field_radius_mm, pitch_um))
        return film if film is linear else film.clamp_min(0)  # a cubic and an FFT may undershoot

    def point_spread(
        self,
        *,
        supersampling: int,
        field_mm: Field = (0.0, 0.0),
    ) -> torch.Tensor:
        """Return what :meth:`forward` makes of a point, without warping: ``(N, 3, K, K)``, sum 1.

        Args:
            supersampling: Film pixels along a sensor pixel's side, >= 1.
            field_mm: See :meth:`forward`.

        Raises:
            InputError: See :meth:`forward`.
        """
        _check_supersampling(supersampling)
        count = len(field_mm) if isinstance(field_mm, torch.Tensor) and field_mm.ndim == 2 else 1
        field = read_field(field_mm, torch.zeros(count, 3, 1, 1), self.field_radius_mm)
        if self.blur is None:
            return torch.ones(1, 3, 1, 1)
        pitch_um = self.pitch_um / supersampling
        return self.blur.kernels(field / self.field_radius_mm, pitch_um)

    def distort_points(
        self,
        points_px: torch.Tensor,
        size: tuple[int, int],
        *,
        supersampling: int,
        field_mm: Field = (0.0, 0.0),
    ) -> torch.Tensor:
        """Return where points of the scene come to lie in the picture (landmarks, for example).

        Args:
            points_px: ``(P, 2)``, or ``(B, P, 2)`` with one field for each; (x, y), film pixels.
            size: (height, width) of the film.
            supersampling: Film pixels along a sensor pixel's side, >= 1.
            field_mm: See :meth:`forward`.

        Raises:
            InputError: The crop lies off the sensor.
        """
        _check_supersampling(supersampling)
        field = read_field(field_mm, points_px, self.field_radius_mm)
        field = field[0] if len(field) == 1 else field[:, None]
        pitch_mm = self.pitch_um / supersampling / 1000
        return self.warp.move_points(points_px, size, field, pitch_mm)


def _check_supersampling(supersampling: int) -> None:
    whole("supersampling", supersampling, "a whole number >= 1", low=1)
