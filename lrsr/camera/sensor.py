"""How does light become digital numbers? Electrons in a well, their noise, and a converter.

A photosite that gets the light E (1 = the camera's white) collects E · full well / gain electrons.
Their number is Poisson's, and so is that of the thermal ones; the amplifier adds Gaussian read
noise; the converter rounds. The variance of a flat field then lies on the photon-transfer line

    var = K (mean - black) + (K · read noise)² + 1/12        with K digital numbers per electron

(J. R. Janesick, Photon Transfer, SPIE 2007; the photon transfer method of EMVA Standard 1288).
Fixed-pattern noise multiplies the light by a gain of each photosite, the same in every picture.
"""

import hashlib
import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np
import torch
from torch import nn

from lrsr.camera.checks import check_flag, check_light, check_origin, number, whole
from lrsr.configuration import as_whole
from lrsr.errors import InputError

_PATTERN_PX = 256
"""Side of the tile of photosite gains; a larger sensor repeats it."""


class Sensor(nn.Module):
    """Exposure in electrons, shot noise, dark current, read noise, PRNU, 8 to 16 bits.

    Args:
        full_well_e: Electrons that a photosite can hold, > 0.
        gain: Analogue amplification, >= 1: white is reached at ``full_well_e / gain`` electrons.
        read_noise_e: Standard deviation of the amplifier, electrons, >= 0.
        dark_current_e_per_s: Thermal electrons a second, >= 0.
        exposure_s: Time of exposure, s, >= 0; it scales the dark current alone, for the light is
            metered.
        prnu: Photo-response non-uniformity: standard deviation of the photosites' gains, 0..0.5.
        bits: Of the converter, 8 to 16.
        black_level_dn: Digital number that no electron at all reads as, >= 0.
        pattern_seed: Makes this sensor's photosites; equal seeds are one and the same sensor.
        noise: False: only the well, the fixed pattern and the rounding.

    Raises:
        InputError: A value is out of its range.

    Example:
        >>> sensor = Sensor(full_well_e=10_000, bits=10, black_level_dn=64, noise=False, prnu=0)
        >>> sensor(torch.tensor([[[[0.0, 0.5, 1.0, 2.0]]]])).flatten().tolist()
        [64.0, 544.0, 1023.0, 1023.0]
    """

    def __init__(
        self,
        full_well_e: float = 10_000.0,
        *,
        gain: float = 1.0,
        read_noise_e: float = 3.0,
        dark_current_e_per_s: float = 0.0,
        exposure_s: float = 0.02,
        prnu: float = 0.01,
        bits: int = 12,
        black_level_dn: int = 256,
        pattern_seed: int = 0,
        noise: bool = True,
    ) -> None:
        super().__init__()
        self.full_well_e = number("full_well_e", full_well_e, "electrons > 0", above=0)
        self.gain = number("gain", gain, "a factor >= 1", low=1)
        self.read_noise_e = number("read_noise_e", read_noise_e, "electrons >= 0", low=0)
        thermal = number("dark_current_e_per_s", dark_current_e_per_s, "a number >= 0", low=0)
        self.dark_e = thermal * number("exposure_s", exposure_s, "seconds >= 0", low=0)
        self.prnu = number("prnu", prnu, "a fraction 0..0.5", low=0, high=0.5)
        self.bits = whole("bits", bits, "8 to 16", low=8, high=16)
        white = 2**self.bits - 1
        black = whole("black_level_dn", black_level_dn, "0 to white", low=0, high=white - 1)
        self.black_level_dn, self.noise = black, check_flag("noise", noise)
        self.pattern_seed = whole("pattern_seed", pattern_seed, "a whole number", low=-math.inf)

    @property
    def white_e(self) -> float:
        """Electrons at which the light is 1."""
        return self.full_well_e / self.gain

    @property
    def dn_per_e(self) -> float:
        """Digital numbers per electron, the K of the photon-transfer line."""
        return float(2**self.bits - 1 - self.black_level_dn) / self.white_e

    def forward(
        self,
        light: torch.Tensor,
        seeds: Sequence[int] | None = None,
        *,
        frame: int = 0,
        origin_px: tuple[int, int] = (0, 0),
        differentiable: bool = False,
        rounding: bool = True,
    ) -> torch.Tensor:
        """Expose once.

        Args:
            light: ``(B, C, H, W)``, C = 1 under a mosaic or 3 for three chips, linear, 1 = white.
            seeds: One for each image, of its noise, which therefore depends on nothing else.
            frame: Number of the exposure; each has noise of its own.
            origin_px: ``(x, y)`` of the first pixel on the sensor, which says whose gains they are.
            differentiable: Shot noise as √mean times a fixed normal number (re-parametrised: the
                mean and variance of Poisson's, without its skewness of 1/√mean), rounding with a
                straight-through gradient.
            rounding: False: return what the converter is given, which is not whole.

        Returns:
            Digital numbers ``(B, C, H, W)``, whole, 0 to 2^bits - 1, in the dtype of ``light``.

        Raises:
            ImageContractError: ``light`` is no batch of images.
            InputError: A noisy sensor got no seeds, or not one for each image.
        """
        check_light(light, channels=(1, 3), name="light")
        gains = _gains(self.pattern_seed, light.shape[1:], check_origin(origin_px)).to(light)
        sites = (1 + self.prnu * gains).clamp_min(0)
        electrons = light.clamp_min(0) * (self.white_e * sites) + self.dark_e
        if self.noise:
            generators = [_noise_generator(seed, frame) for seed in _each(seeds, len(light))]
            electrons = _shot(electrons, generators, differentiable).clamp_max(self.full_well_e)
            electrons = electrons + self.read_noise_e * _normal(electrons, generators)
        else:
            electrons = electrons.clamp_max(self.full_well_e)
        analogue = (self.black_level_dn + self.dn_per_e * electrons).clamp(0, 2**self.bits - 1)
        if not rounding:
            return analogue
        numbers = analogue.detach().round()
        return numbers + (analogue - analogue.detach()) if differentiable else numbers

    def light(self, raw: torch.Tensor) -> torch.Tensor:
        """Take the black level, with the mean dark current, off digital numbers; 1 = white.

        Noise around black stays on both sides of 0: clipping there would brighten the shadows.
        """
        black = self.black_level_dn + self.dn_per_e * self.dark_e
        return (raw - black) / (self.dn_per_e * self.white_e)


def _noise_generator(seed: int, frame: int = 0) -> torch.Generator:
    """Return a generator of the noise of one exposure of one image.

    torch's generator looks at 32 bits of its seed alone, and its streams of neighbouring seeds
    start alike; a digest of both numbers avoids that.

    Example:
        >>> _noise_generator(7).initial_seed() == _noise_generator(7, frame=1).initial_seed()
        False
    """
    digest = hashlib.sha256(f"noise {int(seed)} {int(frame)}".encode()).digest()
    return torch.Generator().manual_seed(int.from_bytes(digest[:4], "big"))


def _each(seeds: Sequence[int] | None, count: int) -> Sequence[int]:
    given = list(seeds) if np.ndim(seeds) and not isinstance(seeds, str) else []  # type: ignore[arg-type]
    if len(given) != count:
        got = len(given) or "none"
        raise InputError(f"seeds: got {got} for {count} noisy images, wanted one for each")
    return [as_whole(seed, "seeds") for seed in given]


def _shot(
    mean: torch.Tensor, generators: Sequence[torch.Generator], differentiable: bool
) -> torch.Tensor:
    if differentiable:  # below a hundredth of an electron √ has no slope worth following
        return mean + mean.clamp_min(1e-2).sqrt() * _normal(mean, generators)
    rates = mean.detach().cpu()
    drawn = [torch.poisson(rate, generator=g) for rate, g in zip(rates, generators, strict=True)]
    return torch.stack(drawn).to(mean)


def _normal(like: torch.Tensor, generators: Sequence[torch.Generator]) -> torch.Tensor:
    return torch.stack([torch.randn(like.shape[1:], generator=g) for g in generators]).to(like)


def _gains(pattern_seed: int, size: torch.Size, origin_px: tuple[int, int]) -> torch.Tensor:
    """Return standard normal numbers ``(C, H, W)`` that belong to these photosites."""
    channels, height, width = size
    rows = (torch.arange(height) + origin_px[1]) % _PATTERN_PX
    columns = (torch.arange(width) + origin_px[0]) % _PATTERN_PX
    return _tile(pattern_seed)[:channels, rows[:, None], columns]


@lru_cache(maxsize=8)
def _tile(pattern_seed: int) -> torch.Tensor:
    generator = _noise_generator(pattern_seed, -1)
    return torch.randn(3, _PATTERN_PX, _PATTERN_PX, generator=generator)
