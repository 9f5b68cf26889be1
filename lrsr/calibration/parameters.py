"""What of a camera is fitted, in which unit, and where does it stand in a preset?"""

import copy
import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

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
NAMES = tuple(parameter.name for parameter in PARAMETERS)

_NEEDED = ("optics", "colour", "sensor", "processing")


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
    optics, sensor, processing = (preset[name] for name in ("optics", "sensor", "processing"))
    if "sensitivities" in preset["colour"]:
        raise InputError(
            f"camera={preset.get('name')} has measured colour filters, which are not fitted: start "
            "from one with filters of three numbers, e.g. camera=generic"
        )
    white_e = sensor.get("full_well_e", 10_000) / sensor.get("gain", 1)
    red, green, blue = preset["colour"].get("cast", (1, 1, 1))
    values = {
        "blur_px": optics.get("defocus_um", 0) / _defocus_um_per_px(optics),
        "sharpen_amount": processing.get("sharpen_amount", 0),
        "read_noise": sensor.get("read_noise_e", 3) / white_e,
        "white_e": white_e,
        "exposure_ev": preset.get("exposure_ev", 0),
        "cast_red": red / green,
        "cast_blue": blue / green,
        "contrast": processing.get("contrast", 1),
        "saturation": processing.get("saturation", 1),
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
    return 4 * float(optics["f_number"]) * float(optics.get("pitch_um", 2.65))


def with_jpeg(
    preset: Mapping[str, Any], quality: int | None, chroma: str, origin_px: tuple[int, int]
) -> dict[str, Any]:
    """Return a preset that stores pictures as JPEG of that quality; None: not at all.

    Args:
        preset: Plain mapping as in ``conf/camera``.
        quality: 1-100 or None.
        chroma: One of :data:`lrsr.camera.codec.CHROMAS`.
        origin_px: Of the picture's first pixel within the grid of blocks.
    """
    changed = {**copy.deepcopy(dict(preset)), "origin_px": list(origin_px), "stored": None}
    if quality is not None:
        target = "lrsr.camera.codec.Jpeg"
        changed["stored"] = {"_target_": target, "qualities": quality, "chroma": chroma}
    return changed
