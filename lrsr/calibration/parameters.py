"""What of a camera is fitted, in which unit, and where does it stand in a preset?"""

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import torch

from lrsr.camera.camera import Camera
from lrsr.camera.checks import check_setting
from lrsr.camera.colour import Colour
from lrsr.camera.optics import Optics
from lrsr.camera.preset_file import build_camera
from lrsr.errors import InputError


@dataclass(frozen=True)
class Parameter:
    """One number that is searched for.

    Attributes:
        name: With its unit.
        start: Where the search begins; the guess that the pictures have to overrule. That of
            :data:`PARAMETERS` is the preset ``generic``'s, nearly.
        low: It never goes below.
        high: It never goes above.
        doubt: Standard deviation of the guess, of the logarithm where ``logarithmic``.
        logarithmic: A factor makes more sense than a difference.
        says: What it means, for the report.
    """

    name: str
    start: float
    low: float
    high: float
    doubt: float
    logarithmic: bool
    says: str

    def coordinate(self, value: float) -> float:
        """Return the distance from ``start`` in units of ``doubt``."""
        if self.logarithmic:
            return math.log(value / self.start) / self.doubt
        return (value - self.start) / self.doubt

    def value(self, coordinate: float) -> float:
        """Invert :meth:`coordinate`."""
        if self.logarithmic:
            return self.start * math.exp(self.doubt * coordinate)
        return self.start + self.doubt * coordinate


PARAMETERS = (
    Parameter("blur_px", 0.7, 0.1, 2.4, 1.0, True, "blur of the lens by its defocus, σ"),
    Parameter("sharpen_amount", 0.5, 0.0, 5.0, 1.0, False, "unsharp mask"),
    Parameter("read_noise", 0.006, 0.0002, 0.1, 1.0, True, "read noise, share of white"),
    Parameter("white_e", 3000.0, 60.0, 2e5, 1.0, True, "electrons at white: shot noise"),
    Parameter("exposure_ev", 0.0, -3.0, 3.0, 0.5, False, "with the subjects' albedo, not apart"),
    Parameter("cast_red", 1.0, 0.3, 3.0, 0.3, True, "gain of red over green"),
    Parameter("cast_blue", 1.0, 0.3, 3.0, 0.3, True, "gain of blue over green"),
    Parameter("contrast", 1.0, 0.4, 2.5, 0.2, True, "slope of the tone curve"),
    Parameter("saturation", 1.0, 0.2, 4.0, 0.2, True, "factor of the colour differences"),
)

_MTF_CYCLES = 0.1
"""Where the lens's blur is compared with a Gaussian's, cycles a pixel: below any zero."""

_NEEDED = ("optics", "colour", "sensor", "processing")
_PITCH_UM = Optics().pitch_um


def with_values(preset: Mapping[str, Any], values: Mapping[str, float]) -> dict[str, Any]:
    """Return a preset with fitted values in their places.

    The well holds exactly ``white_e`` at a gain of 1: gain and full well cannot be told apart. The
    blur is given to the lens as the defocus whose disk, by geometry, has that σ.

    Args:
        preset: Plain mapping as in ``conf/camera``, with optics (and f_number), colour, sensor and
            processing.
        values: By the names of :data:`PARAMETERS`.

    Raises:
        InputError: The preset lacks a stage that is to be fitted.
    """
    _check_stages(preset)
    fitted = copy.deepcopy(dict(preset))
    optics, sensor = fitted["optics"], fitted["sensor"]
    rounded = {name: float(f"{value:.5g}") for name, value in values.items()}
    optics["defocus_um"] = float(f"{_defocus_um_per_px(optics) * values['blur_px']:.5g}")
    sensor |= {"full_well_e": rounded["white_e"], "gain": 1.0}
    sensor["read_noise_e"] = float(f"{values['read_noise'] * values['white_e']:.5g}")
    fitted["colour"].pop("white_balance", None)  # would rule instead
    fitted["colour"]["cast"] = [rounded["cast_red"], 1.0, rounded["cast_blue"]]
    fitted["exposure_ev"] = rounded["exposure_ev"]
    for name in ("sharpen_amount", "contrast", "saturation"):
        fitted["processing"][name] = rounded[name]
    return fitted


def starting_from(preset: Mapping[str, Any]) -> tuple[Parameter, ...]:
    """Return :data:`PARAMETERS` with a preset's own values as the guess.

    A value outside a parameter's range starts at its end.

    Args:
        preset: Plain mapping as in ``conf/camera``.

    Raises:
        InputError: The preset lacks a stage that is to be fitted, or measures its filters: a cast
            is none of its settings.
    """
    _check_stages(preset)
    camera = build_camera(dict(preset))
    optics, colour, sensor, processing = (getattr(camera, name) for name in _NEEDED)
    if not isinstance(colour, Colour):
        raise InputError(
            f"camera={camera.name} has measured colour filters, which are not fitted: start "
            "from one with filters of three numbers, e.g. camera=generic"
        )
    red, green, blue = np.array(colour.white_balance) * np.sum(colour.responses, axis=1)
    values = {
        "blur_px": optics.blur.defocus_um / _defocus_um_per_px(preset["optics"]),
        "sharpen_amount": processing.sharpen_amount,
        "read_noise": sensor.read_noise_e / sensor.white_e,
        "white_e": sensor.white_e,
        "exposure_ev": camera.exposure_ev,
        "cast_red": red / green,
        "cast_blue": blue / green,
        "contrast": processing.contrast,
        "saturation": processing.saturation,
    }
    return tuple(
        replace(one, start=min(max(float(values[one.name]), one.low), one.high))
        for one in PARAMETERS
    )


def _check_stages(preset: Mapping[str, Any]) -> None:
    missing = [name for name in _NEEDED if not preset.get(name)]
    if not missing and not preset["optics"].get("f_number"):
        missing = ["optics.f_number"]
    if missing:
        raise InputError(
            f"camera={preset.get('name')} has no {missing[0]} to fit: start from one with all "
            "stages, e.g. camera=generic"
        )


def _defocus_um_per_px(optics: Mapping[str, Any]) -> float:
    """Return the defocus whose disk, by geometry, has a σ of one pixel."""
    return 4 * float(optics["f_number"]) * float(optics.get("pitch_um", _PITCH_UM))


def with_jpeg(
    preset: Mapping[str, Any], quality: int | None, chroma: str, origin_px: tuple[int, int]
) -> dict[str, Any]:
    """Return a preset that stores pictures as JPEG of that quality; None: not at all.

    Args:
        preset: Plain mapping as in ``conf/camera``.
        quality: 1-100 or None.
        chroma: Sub-sampling, "4:4:4", "4:2:2" or "4:2:0".
        origin_px: Of the picture's first pixel within the grid of blocks.
    """
    changed = {**copy.deepcopy(dict(preset)), "origin_px": list(origin_px), "stored": None}
    if quality is not None:
        target = "lrsr.camera.codec.Jpeg"
        changed["stored"] = {"_target_": target, "qualities": quality, "chroma": chroma}
    return changed


def lens_blur_px(camera: Camera) -> float:
    """Return σ of the Gaussian that blurs as a camera's lens does, px of the sensor.

    The one with the lens's modulation transfer in green at 0.1 cycles a pixel, averaged over both
    directions; the pixel's own aperture is not in it. A lens without blur has 0.

    Raises:
        InputError: The lens is too blurred for that: nothing is left at that frequency.
    """
    if camera.optics is None:
        return 0.0
    kernel = camera.optics.point_spread(
        supersampling=camera.supersampling, field_mm=camera.field_mm
    )[0, 1].double()
    at = torch.arange(len(kernel), dtype=torch.float64) - len(kernel) // 2
    wave = torch.cos(2 * torch.pi * _MTF_CYCLES / camera.supersampling * at)
    transfer = float((kernel.sum(0) @ wave + kernel.sum(1) @ wave) / 2)
    check_setting("blur", transfer, transfer > 0.01, "a lens with some contrast at 0.1 cycles/px")
    return float(np.sqrt(-2 * np.log(min(transfer, 1.0))) / (2 * np.pi * _MTF_CYCLES))
