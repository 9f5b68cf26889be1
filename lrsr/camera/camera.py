"""What file does the camera make of the light on its film? One chain of steps, as a module."""

from collections.abc import Sequence
from inspect import signature
from typing import Any

import torch
from torch import nn

from lrsr.camera.checks import (
    check_choice,
    check_flag,
    check_origin,
    check_setting,
    number,
    numbers,
    whole,
)
from lrsr.camera.codec import COMPRESSIONS, Jpeg, jpeg, jpeg_differentiable
from lrsr.camera.colour import Colour
from lrsr.camera.encoding import encode, quantise
from lrsr.camera.exposure import check_is_light, expose
from lrsr.camera.mosaic import Mosaic
from lrsr.camera.optics import Optics, bin_pixels
from lrsr.camera.processing import Processing
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour, needed, observe
from lrsr.camera.video import Video
from lrsr.errors import InputError
from lrsr.images import check_images
from lrsr.spectra import BANDS, Spectrum

_CODECS = ("true", "differentiable")
_SUPERSAMPLINGS = (1, 2, 4)
STAGES: dict[str, tuple[type[nn.Module], ...]] = {
    "optics": (Optics,),
    "colour": (Colour, SpectralColour),
    "mosaic": (Mosaic,),
    "sensor": (Sensor,),
    "processing": (Processing,),
    "stored": (Jpeg, Video),
}
"""What each stage of a camera may be, in the order of the light."""


class Camera(nn.Module):
    """Exposure, optics, colour filters, sensor, processing, codec: from linear light to a file.

    Each stage is off where it is None; without any this is the reference camera: exposure, sRGB
    curve, 8 bits, JPEG. The exposure is that of an incident-light meter
    (:mod:`lrsr.camera.exposure`): it depends on the lighting alone. No image sees another one of
    its batch, and what is random follows from a seed for each image. Where gradients reach the
    light, noise is drawn otherwise: as strong (within 13 %), but a picture is as far from the true
    one as two true ones of different seeds are (28-35 dB for the presets, 31 with H.264).

    Args:
        compression: "none", "small" or "heavy" (:data:`lrsr.camera.codec.COMPRESSIONS`): what
            becomes of the crop after the camera has stored it. The result has 8 bits with "none"
            too.
        exposure_ev: Stops over (+) or under (-) the meter's reading.
        codec: "true": the real codecs, for evaluation; "differentiable": gradients reach the light.
        name: Of the preset; goes into manifests and reports.
        optics: The lens's faults, on the film.
        supersampling: Film pixels along a side of the sensor's: 1, 2 or 4. The film comes that
            much finer than the picture.
        colour: Responses of the filters, white balance, colour matrix; measured filters
            (:class:`lrsr.camera.spectral.SpectralColour`) look at spectral bands.
        mosaic: Filters and interpolation; None: three chips.
        sensor: Electrons, noise, converter.
        processing: Denoising, sharpening, tone; None: the sRGB curve alone.
        stored: The camera's own file: :class:`lrsr.camera.codec.Jpeg` or
            :class:`lrsr.camera.video.Video`.
        origin_px: ``(x, y)`` of the crop's first pixel in the camera's frame: where the mosaic, the
            sensor's pattern and the blocks of ``stored`` fall.
        field_mm: ``(right, down)`` of the crop's middle from the optical axis, mm, for ``optics``.
        bands: Spectral bands on the film, 7 to 350; None: those that measured filters usually get,
            none (0) for other cameras. Of such a film cameras without measured filters see what the
            CIE 1931 observer sees, so that one rendering serves them all.
        adapted: That observer takes the light at the face for white, as the camera does whose
            references he sees.

    Raises:
        InputError: Unknown compression or codec, a number is out of its range, or a stage is
            something else.

    Example:
        >>> white_sphere = torch.ones(1, 3, 8, 8)
        >>> Camera()(white_sphere, torch.ones(1)).mul(255).unique().tolist()
        [243.0]
    """

    def __init__(
        self,
        compression: str = "none",
        exposure_ev: float = 0.0,
        codec: str = "true",
        name: str = "reference",
        *,
        optics: Optics | None = None,
        supersampling: int = 1,
        colour: Colour | SpectralColour | None = None,
        mosaic: Mosaic | None = None,
        sensor: Sensor | None = None,
        processing: Processing | None = None,
        stored: Jpeg | Video | None = None,
        origin_px: tuple[int, int] = (0, 0),
        field_mm: tuple[float, float] = (0.0, 0.0),
        bands: int | None = None,
        adapted: bool = False,
    ) -> None:
        super().__init__()
        self.compression = check_choice("compression", compression, COMPRESSIONS)
        self.codec = check_choice("codec", codec, _CODECS)
        check_setting("name", name, isinstance(name, str), "a word")
        self.quality, self.name = COMPRESSIONS[compression], name
        self.exposure_ev = number("exposure_ev", exposure_ev, "-100..100", low=-100, high=100)
        wish = f"one of {_SUPERSAMPLINGS}"
        self.supersampling = whole("supersampling", supersampling, wish, low=1)
        check_setting("supersampling", supersampling, supersampling in _SUPERSAMPLINGS, wish)
        self.optics, self.colour, self.mosaic = optics, colour, mosaic
        self.sensor, self.processing, self.stored = sensor, processing, stored
        for stage, kinds in STAGES.items():
            fits = isinstance(getattr(self, stage), (*kinds, type(None)))
            names = " or ".join(kind.__name__ for kind in kinds)
            check_setting(stage, getattr(self, stage), fits, f"{names}, or null")
        self.origin_px = check_origin(origin_px)
        right, down = numbers("field_mm", field_mm, 2)
        self.field_mm, self.adapted = (right, down), check_flag("adapted", adapted)
        wish = "7 to 350, or 0 without measured filters"
        given = (BANDS if self._measured else 0) if bands is None else bands
        self.bands = whole("bands", given, wish, low=0, high=350)
        usable = self.bands >= 7 or (self.bands == 0 and self._measured is None)
        check_setting("bands", self.bands, usable, wish)

    @property
    def noisy(self) -> bool:
        """Does a picture depend on a seed?"""
        return self.sensor is not None and self.sensor.noise

    @property
    def flawless(self) -> bool:
        """Is this the reference camera, whatever its exposure, compression and name?"""
        return self.supersampling == 1 and all(getattr(self, stage) is None for stage in STAGES)

    def check_lens(self, name: str, *, pinhole: bool) -> None:
        """Refuse light that has come through another lens than a pinhole, if this one has optics.

        Args:
            name: Of the lens that the light was rendered through.
            pinhole: It is none.

        Raises:
            InputError: There would be two lenses, each with its faults.
        """
        if self.optics is not None and not pinhole:
            raise InputError(
                f"lens={name} camera={self.name}: two lenses, whose faults would add up; give "
                "lens=pinhole, or a camera without optics (camera.optics=null)"
            )

    def forward(
        self,
        linear: torch.Tensor,
        metered: torch.Tensor,
        seeds: Sequence[int] | None = None,
        spectrum: Spectrum | None = None,
    ) -> torch.Tensor:
        """Take the picture.

        Args:
            linear: ``(B, 3, S H, S W)`` float32, scene-referred linear light on a film S =
                ``supersampling`` times finer, any H and W >= 1 (3 under a mosaic); or
                ``(B, N, S H, S W)`` spectral bands. What lies below 0 counts as no light
                (:func:`lrsr.camera.exposure.check_is_light`).
            metered: ``(B,)``, reading of the incident-light meter, > 0.
            seeds: One for each image, of its noise; only a noisy camera needs them.
            spectrum: Which bands they are; None: three colours.

        Returns:
            srgb ``(B, 3, H, W)`` float32, [0, 1], multiples of 1/255.

        Raises:
            ImageContractError: The images break the contract or are no light, or ``metered`` does
                not fit them.
            InputError: A noisy camera got no seeds, or measured filters got three colours.
            NonFiniteError: A NaN or an infinity in the images.
        """
        if self.noisy and seeds is None:
            raise InputError(f"camera {self.name!r} is noisy: give seeds, one for each image")
        bands = spectrum is not None and getattr(linear, "ndim", 0) == 4
        channels = linear.shape[1] if bands else 3
        light = check_is_light(check_images(linear, channels=channels, name="linear"))
        seen = self.see(light, spectrum)
        light = self.gather(expose(seen, metered, self.exposure_ev))
        count = 1 if self.stored is None else self.stored.frames
        frames = [self.develop(light, seeds, frame, spectrum) for frame in range(count)]
        srgb = frames[-1]
        if self.stored is not None:
            stack, soft = torch.stack(frames), self._trained_through
            srgb = self.stored(stack, origin_px=self.origin_px, differentiable=soft)
        if self.quality is None:
            return srgb
        return (jpeg_differentiable if self._trained_through else jpeg)(srgb, self.quality)

    def see(self, linear: torch.Tensor, spectrum: Spectrum | None = None) -> torch.Tensor:
        """Return three channels ``(B, 3, H, W)`` of light ``(B, 3 or N, H, W)``.

        Of bands those are what measured filters let through, or the linear sRGB of the standard
        observer. They come before the lens, which treats each channel as it treats a colour.

        Args:
            linear: Three colours or bands.
            spectrum: Which bands they are; None: three colours.

        Raises:
            ImageContractError: The light has another number of channels.
            InputError: Measured filters got three colours.
        """
        if self._measured is not None:
            return self._measured.filter(linear, needed(spectrum, self.bands))
        if spectrum is None:
            return linear
        return observe(linear, spectrum, adapted=self.adapted)

    def gather(self, light: torch.Tensor) -> torch.Tensor:
        """Send exposed light ``(B, 3, S H, S W)`` through the lens into pixels ``(B, 3, H, W)``.

        Raises:
            ImageContractError: The film is no whole number of pixels.
        """
        if self.optics is not None:
            light = self.optics(light, supersampling=self.supersampling, field_mm=self.field_mm)
        return bin_pixels(light, self.supersampling)

    def develop(
        self,
        light: torch.Tensor,
        seeds: Sequence[int] | None = None,
        frame: int = 0,
        spectrum: Spectrum | None = None,
    ) -> torch.Tensor:
        """Count the light of pixels ``(B, 3, H, W)`` and make a picture of 8 bits of it.

        Args:
            light: Linear, 1 = white; behind measured filters what they let through.
            seeds: One for each image.
            frame: Number of the exposure; each has noise of its own.
            spectrum: Of the scenes' light, for measured filters.

        Returns:
            srgb ``(B, 3, H, W)``, multiples of 1/255.

        Raises:
            InputError: Noise without a seed for each image.
        """
        soft = self._trained_through
        raw = self.colour.filter(light) if isinstance(self.colour, Colour) else light
        if self.mosaic is not None:
            raw = self.mosaic.filter(raw, self.origin_px)
        if self.sensor is not None:
            where: dict[str, Any] = {"frame": frame, "origin_px": self.origin_px}
            raw = self.sensor.light(self.sensor(raw, seeds, differentiable=soft, **where))
        if self._measured is not None:
            gains = self._measured.gains(spectrum, (raw.shape[-2], raw.shape[-1])).to(raw)
            gains = gains if self.mosaic is None else self.mosaic.filter(gains, self.origin_px)
            raw = (raw * gains).clamp_max(1.0)
        if self.mosaic is not None:
            raw = self.mosaic(raw, self.origin_px)
        if self.colour is not None:
            raw = self.colour(raw, spectrum)
        if self.processing is None:
            return encode(raw, differentiable=soft)
        return quantise(self.processing(raw), differentiable=soft)

    def place_points(self, points_px: torch.Tensor, size: tuple[int, int]) -> torch.Tensor:
        """Return where points of the film come to lie in the picture.

        Args:
            points_px: ``(P, 2)`` (x, y), pixels of the film.
            size: (height, width) of the film.
        """
        if self.optics is not None:
            points_px = self.optics.distort_points(
                points_px, size, supersampling=self.supersampling, field_mm=self.field_mm
            )
        if self.supersampling == 1:
            return points_px
        return (points_px + 0.5) / self.supersampling - 0.5

    def compressing(self, compression: str) -> "Camera":
        """Return the same camera with another compression.

        Raises:
            InputError: Unknown compression.
        """
        settings = {name: getattr(self, name) for name in signature(Camera).parameters}
        return Camera(**{**settings, "compression": compression})

    def clean(self) -> "Camera":
        """Return a reference camera of the same exposure that does not compress.

        It takes enrolled pictures, and what a restored picture is measured against. The reference
        camera keeps its name; one with flaws gives it up. It sees the same bands, if there are
        any, as the standard observer, with the same idea of white.
        """
        name = self.name if self.flawless else "reference"
        adapted = self.adapted
        if self._measured is not None:
            adapted = self._measured.balance == "scene"
        told: dict[str, Any] = {"bands": self.bands, "adapted": adapted}
        return Camera("none", self.exposure_ev, self.codec, name, **told)

    @property
    def _measured(self) -> SpectralColour | None:
        return self.colour if isinstance(self.colour, SpectralColour) else None

    @property
    def _trained_through(self) -> bool:
        return self.codec == "differentiable"

    def extra_repr(self) -> str:
        """Show the settings when the module is printed."""
        return (
            f"compression={self.compression!r}, exposure_ev={self.exposure_ev:g}, "
            f"codec={self.codec!r}, name={self.name!r}"
        )
