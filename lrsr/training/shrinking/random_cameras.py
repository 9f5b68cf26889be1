"""What might any camera make of a sharp picture? One is drawn for every few pictures.

A network that has met one way of shrinking only is worse than bicubic where pictures were made
small in another. So the lens's blur, exposure, noise, demosaicing, processing and compression are
drawn, and the same stages do it as of a configured camera (:mod:`lrsr.camera`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np
import torch
from torch.nn import functional as F

from lrsr.camera import Camera
from lrsr.camera.bayer import PATTERNS
from lrsr.camera.codec import Jpeg
from lrsr.camera.encoding import encode
from lrsr.camera.exposure import KEY
from lrsr.camera.mosaic import Mosaic
from lrsr.camera.processing import Processing
from lrsr.camera.sensor import Sensor
from lrsr.configuration import as_list, require
from lrsr.images import srgb_to_linear
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.gaussians import filter_each, gaussian_kernels
from lrsr.training.patches import Pair
from lrsr.training.shrinking.shrinking import Shrinking

_LEAST_BLUR_PX = 0.05
"""Less cannot be told from a single pixel."""

_FRAME_PX = 256
"""Crops lie anywhere in so many rows and columns: where mosaic and blocks of JPEG fall."""

_T = TypeVar("_T")


@dataclass(frozen=True)
class RandomCameras(Shrinking):
    """Ranges of what is drawn; numbers are uniform unless it says otherwise.

    Attributes:
        blur_px: Standard deviation of the Gaussian that a lens and its focus make of a point, px of
            the small picture; of each picture its own.
        elongation: How many times longer it is in one direction, any.
        exposure_ev: Stops by which light is changed before the camera, of the true picture too.
        noise_share: How many cameras are noisy.
        white_e: Electrons at white, log-uniform; fewer are more shot noise.
        read_noise_e: Electrons.
        mosaic_share: How many cameras have a mosaic of filters, of any phase.
        methods: By which it is interpolated; see :class:`lrsr.camera.mosaic.Mosaic`.
        denoise_px: Width of the filters on luminance and, twice as wide, on colour.
        sharpen_amount: Of the unsharp mask.
        jpeg_share: How many cameras compress.
        jpeg_quality: Lowest and highest quality.
        chromas: What is left of the colours; see :class:`lrsr.camera.codec.Jpeg`.
        group: Pictures of one camera.

    Raises:
        InputError: A value is out of its range, or none of those that are known.
    """

    blur_px: tuple[float, float]
    elongation: tuple[float, float]
    exposure_ev: tuple[float, float]
    noise_share: float
    white_e: tuple[float, float]
    read_noise_e: tuple[float, float]
    mosaic_share: float
    methods: Sequence[str]
    denoise_px: tuple[float, float]
    sharpen_amount: tuple[float, float]
    jpeg_share: float
    jpeg_quality: tuple[int, int]
    chromas: Sequence[str]
    group: int

    def __post_init__(self) -> None:
        spans = {
            "blur_px": (0.0, 8.0),
            "elongation": (1.0, 8.0),
            "exposure_ev": (-8.0, 8.0),
            "white_e": (10.0, 1e6),
            "read_noise_e": (0.0, 1e3),
            "denoise_px": (0.0, 10.0),
            "sharpen_amount": (0.0, 10.0),
            "jpeg_quality": (1.0, 100.0),
        }
        shares = dict.fromkeys(("noise_share", "mosaic_share", "jpeg_share"), SHARE)
        limits = spans | shares | {"group": (1.0, 4096.0)}
        check_ranges(self, "degradation", limits, spans=[*spans])
        for name, make in (("methods", _mosaic), ("chromas", _file)):
            listed = as_list(getattr(self, name), f"degradation.{name}")
            require(len(listed) > 0, f"degradation.{name}", [], "at least one")
            for one in listed:
                make(one)
            object.__setattr__(self, name, tuple(listed))

    def __call__(
        self, true: torch.Tensor, scale: int, seeds: Sequence[int], camera: Camera
    ) -> Iterator[Pair]:
        """Photograph a few pictures with each camera; see the base, whose ``camera`` is not read.

        Raises:
            ImageContractError: A small picture has less than 3 × 3 pixels.
        """
        for start in range(0, len(true), self.group):
            few = true[start : start + self.group]
            yield self._photograph(few, scale, seeds[start : start + len(few)])

    def _photograph(self, true: torch.Tensor, scale: int, seeds: Sequence[int]) -> Pair:
        rng = np.random.default_rng(seeds[0])
        light = srgb_to_linear(true) * float(2 ** rng.uniform(*self.exposure_ev))
        film = F.avg_pool2d(filter_each(light, self._kernels(scale, seeds)), scale)
        taken = self._camera(rng)(film, torch.full((len(film),), KEY), seeds)
        return taken, encode(light)

    def _kernels(self, scale: int, seeds: Sequence[int]) -> np.ndarray:
        drawn = [np.random.default_rng([seed, 1]) for seed in seeds]
        across, longer, angle = np.array(
            [
                (rng.uniform(*self.blur_px), rng.uniform(*self.elongation), rng.uniform(0, np.pi))
                for rng in drawn
            ]
        ).T
        across = np.maximum(across, _LEAST_BLUR_PX) * scale
        return gaussian_kernels(across, across * longer, angle)

    def _camera(self, rng: np.random.Generator) -> Camera:
        """Draw a camera, always as many numbers."""
        noisy, filtered, compressing = rng.random(3) < (
            self.noise_share,
            self.mosaic_share,
            self.jpeg_share,
        )
        white_e = float(np.exp(rng.uniform(*np.log(self.white_e))))
        sensor = Sensor(white_e, read_noise_e=rng.uniform(*self.read_noise_e))
        mosaic = _mosaic(_one(self.methods, rng), _one(PATTERNS, rng))
        denoise_px = rng.uniform(*self.denoise_px)
        processing = Processing(
            denoise_luma_px=denoise_px,
            denoise_chroma_px=2 * denoise_px,
            sharpen_amount=rng.uniform(*self.sharpen_amount),
        )
        low, high = self.jpeg_quality
        stored = _file(_one(self.chromas, rng), int(rng.integers(low, high + 1)))
        x, y = rng.integers(0, _FRAME_PX, 2).tolist()
        return Camera(
            sensor=sensor if noisy else None,
            mosaic=mosaic if filtered else None,
            processing=processing,
            stored=stored if compressing else None,
            origin_px=(x, y),
        )

    def in_words(self, camera: Camera, *, of_films: bool) -> str:
        """Say how the small pictures are made."""
        low, high = self.jpeg_quality
        return (
            "linear light blurred, averaged over pixels of scale times the size, and taken by"
            f" cameras drawn at random: noise, mosaic, processing, JPEG {low} to {high}"
        )


def _mosaic(method: str, pattern: str = "RGGB") -> Mosaic:
    return Mosaic(pattern, method)


def _file(chroma: str, quality: int = 75) -> Jpeg:
    return Jpeg(quality, chroma)


def _one(of: Sequence[_T], rng: np.random.Generator) -> _T:
    return of[int(rng.integers(len(of)))]
