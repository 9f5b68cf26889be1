"""What has the field agreed on for pictures of unknown history? BSRGAN's shuffled degradation.

Two blurs, a random resizing, noise, JPEG and a camera's noise in random order, then the resizing to
the small picture's size and JPEG once more (K. Zhang, J. Liang, L. Van Gool, R. Timofte, ICCV 2021,
arXiv:2103.14006, section 3; settings are named after the authors' ``degradation_bsrgan``). The
camera is ours: the authors have not published theirs.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.camera.bayer import PATTERNS
from lrsr.camera.codec import jpeg
from lrsr.camera.exposure import KEY
from lrsr.camera.mosaic import Mosaic
from lrsr.camera.sensor import Sensor
from lrsr.images import resize_bicubic, srgb_to_linear
from lrsr.training.augmentation.ranges import SHARE, check_ranges
from lrsr.training.patches import Pair
from lrsr.training.shrinking.shrinking import Shrinking

_Picture = NDArray[np.float32]
"""``(H, W, 3)`` srgb, [0, 1]."""

_RESIZINGS = (cv2.INTER_LINEAR, cv2.INTER_CUBIC, cv2.INTER_AREA)
_SAMPLED_PX = 25
"""Side of the kernel before each ``scale``-th pixel is taken."""

_LEAST_WIDTH_PX = 1e-3
_LEAST_PX = 3
"""A mosaic's side at least; of smaller sizes in between nothing would be left."""


@dataclass(frozen=True)
class Bsrgan(Shrinking):
    """Ranges and probabilities of what is drawn for each picture.

    Attributes:
        scale2_prob: At 4×, how often the picture is first halved.
        aniso_prob: How often a blur is anisotropic.
        iso_width: Highest standard deviation of the isotropic one, px: a + b · scale.
        aniso_variance: Highest variance along each axis of the anisotropic one, px²: a + b · scale.
        kernel_px: Smallest and largest side of their kernels, odd.
        resize_prob: How often the resizing in between is one by 1 to 2 · scale, bilinear, bicubic
            or area; else the picture is blurred, and each ``scale``-th pixel taken.
        sampled_width: Lowest standard deviation of that blur, px, and highest, of the scale.
        noise_level: Lowest and highest standard deviation of Gaussian noise, of 255 levels; the
            same in all colours, of each its own, or correlated.
        grey_prob: How often it is the same in all.
        correlated_prob: How often it is correlated.
        jpeg_prob: How often the picture is compressed in between.
        jpeg_quality: Lowest and highest quality, in between and last.
        isp_prob: How often a camera's sensor with its mosaic adds its noise.
        isp_white_e: Electrons at the white of that camera, log-uniform.
        isp_read_noise_e: Its read noise, electrons.

    Raises:
        InputError: A number is out of its range.
    """

    scale2_prob: float
    aniso_prob: float
    iso_width: tuple[float, float]
    aniso_variance: tuple[float, float]
    kernel_px: tuple[int, int]
    resize_prob: float
    sampled_width: tuple[float, float]
    noise_level: tuple[int, int]
    grey_prob: float
    correlated_prob: float
    jpeg_prob: float
    jpeg_quality: tuple[int, int]
    isp_prob: float
    isp_white_e: tuple[float, float]
    isp_read_noise_e: tuple[float, float]

    def __post_init__(self) -> None:
        shares = (
            *("scale2_prob", "aniso_prob", "resize_prob", "grey_prob", "correlated_prob"),
            *("jpeg_prob", "isp_prob"),
        )
        spans = {
            "kernel_px": (3.0, 99.0),
            "noise_level": (0.0, 255.0),
            "jpeg_quality": (1.0, 100.0),
            "isp_white_e": (10.0, 1e6),
            "isp_read_noise_e": (0.0, 1e3),
        }
        widths = dict.fromkeys(("iso_width", "aniso_variance", "sampled_width"), (0.0, 50.0))
        limits = dict.fromkeys(shares, SHARE) | spans | widths
        check_ranges(self, "degradation", limits, spans=[*spans])

    def __call__(
        self, true: torch.Tensor, scale: int, seeds: Sequence[int], camera: Camera
    ) -> Iterator[Pair]:
        """Degrade each picture in its own way; see the base, whose ``camera`` is not read."""
        small = [
            self._degrade(picture.permute(1, 2, 0).numpy(), scale, np.random.default_rng(seed))
            for picture, seed in zip(true, seeds, strict=True)
        ]
        yield torch.stack([_as_image(picture)[0] for picture in small]), true

    def _degrade(self, picture: _Picture, scale: int, rng: np.random.Generator) -> _Picture:
        size = picture.shape[0] // scale, picture.shape[1] // scale
        if scale == 4 and rng.random() < self.scale2_prob:
            picture, scale = _halved(picture, rng), 2
        blur, between, last = self._blurred, self._resized, lambda p, s, r: _resize(p, size, r)
        steps: list[Callable[[_Picture, int, np.random.Generator], _Picture]] = [
            *(blur, blur, between, last),
            *(self._noisy, self._compressed_or_not, self._through_camera_or_not),
        ]
        order = rng.permutation(len(steps)).tolist()
        first, second = sorted((order.index(2), order.index(3)))
        order[first], order[second] = 2, 3  # the last resizing after the other one
        for number in order:
            picture = steps[number](picture, scale, rng)
        return self._compressed(picture, rng)

    def _blurred(self, picture: _Picture, scale: int, rng: np.random.Generator) -> _Picture:
        sides = np.arange(self.kernel_px[0], self.kernel_px[1] + 1, 2)
        side = int(rng.choice(sides))
        if rng.random() < self.aniso_prob:
            most = self.aniso_variance[0] + self.aniso_variance[1] * scale
            along, across = np.sqrt(rng.uniform(0, most, 2))
            kernel = _gaussian(side, along, across, rng.uniform(0, np.pi))
            return _filtered(picture, kernel)
        width = rng.uniform(0, self.iso_width[0] + self.iso_width[1] * scale)
        return _filtered_apart(picture, _line(side, width))

    def _resized(self, picture: _Picture, scale: int, rng: np.random.Generator) -> _Picture:
        height, width = picture.shape[:2]
        if rng.random() < self.resize_prob:
            by = rng.uniform(1, 2 * scale)
            size = max(int(height / by), _LEAST_PX), max(int(width / by), _LEAST_PX)
            return _resize(picture, size, rng)
        low, high = self.sampled_width
        line = _line(_SAMPLED_PX, rng.uniform(low, high * scale), centre=(scale - 1) / 2)
        return np.ascontiguousarray(_filtered_apart(picture, line)[::scale, ::scale])

    def _noisy(self, picture: _Picture, scale: int, rng: np.random.Generator) -> _Picture:
        low, high = self.noise_level
        level, kind = int(rng.integers(low, high + 1)) / 255, rng.random()
        if kind < self.grey_prob:
            noise = level * rng.standard_normal((*picture.shape[:2], 1), np.float32)
        else:
            noise = level * rng.standard_normal(picture.shape, np.float32)
            if kind < self.grey_prob + self.correlated_prob:
                noise = noise / max(level, 1e-9) @ _mixing(high / 255, rng)
        return np.clip(picture + noise, 0, 1).astype(np.float32)

    def _compressed_or_not(
        self, picture: _Picture, scale: int, rng: np.random.Generator
    ) -> _Picture:
        return self._compressed(picture, rng) if rng.random() < self.jpeg_prob else picture

    def _compressed(self, picture: _Picture, rng: np.random.Generator) -> _Picture:
        low, high = self.jpeg_quality
        return _as_picture(jpeg(_as_image(picture), int(rng.integers(low, high + 1))))

    def _through_camera_or_not(
        self, picture: _Picture, scale: int, rng: np.random.Generator
    ) -> _Picture:
        if rng.random() >= self.isp_prob:
            return picture
        white_e = float(np.exp(rng.uniform(*np.log(self.isp_white_e))))
        camera = Camera(
            mosaic=Mosaic(PATTERNS[int(rng.integers(len(PATTERNS)))]),
            sensor=Sensor(white_e, read_noise_e=rng.uniform(*self.isp_read_noise_e)),
        )
        seeds = [int(rng.integers(2**32))]
        light = srgb_to_linear(_as_image(picture))
        return _as_picture(camera(light, torch.tensor([KEY]), seeds))

    def in_words(self, camera: Camera, *, of_films: bool) -> str:
        """Say how the small pictures are made."""
        return "BSRGAN's random degradation (arXiv:2103.14006), the camera's noise by lrsr's"


def _as_image(picture: _Picture) -> torch.Tensor:
    return torch.from_numpy(np.ascontiguousarray(picture.transpose(2, 0, 1)))[None]


def _as_picture(image: torch.Tensor) -> _Picture:
    return np.ascontiguousarray(image[0].permute(1, 2, 0).numpy())


def _halved(picture: _Picture, rng: np.random.Generator) -> _Picture:
    """Halve a picture as OpenCV or as MATLAB does."""
    if rng.random() < 0.5:
        return _resize(picture, (picture.shape[0] // 2, picture.shape[1] // 2), rng)
    return _as_picture(resize_bicubic(_as_image(picture), 0.5).clamp(0, 1))


def _resize(picture: _Picture, size: tuple[int, int], rng: np.random.Generator) -> _Picture:
    """Resize to (height, width) by one of OpenCV's ways, the field of view unchanged."""
    how = _RESIZINGS[int(rng.integers(len(_RESIZINGS)))]
    resized = cv2.resize(picture, (size[1], size[0]), interpolation=how)
    clipped: _Picture = np.clip(resized, 0, 1)
    return clipped


def _line(side: int, width: float, centre: float = 0.0) -> NDArray[np.float64]:
    """Return a Gaussian ``(side,)`` of the sum 1.

    Args:
        side: Odd.
        width: Standard deviation, px; 0 is a point.
        centre: How far beyond the middle it lies, px.

    Example:
        >>> _line(3, 0.0).tolist()
        [0.0, 1.0, 0.0]
    """
    squared = ((np.arange(side) - side // 2 - centre) / max(width, _LEAST_WIDTH_PX)) ** 2
    line: NDArray[np.float64] = np.exp(-0.5 * (squared - squared.min()))
    line /= line.sum()
    return line


def _gaussian(side: int, along: float, across: float, angle: float) -> NDArray[np.float64]:
    """Return a kernel ``(side, side)`` of the sum 1.

    Args:
        side: Odd.
        along: Standard deviation along the direction ``angle``, px; 0 is a point.
        across: And across it.
        angle: From x to y, radians.
    """
    x = np.arange(side) - side // 2
    right = np.cos(angle) * x + np.sin(angle) * x[:, None]
    down = np.cos(angle) * x[:, None] - np.sin(angle) * x
    squared = (right / max(along, _LEAST_WIDTH_PX)) ** 2 + (
        down / max(across, _LEAST_WIDTH_PX)
    ) ** 2
    kernel: NDArray[np.float64] = np.exp(-0.5 * squared)
    kernel /= kernel.sum()
    return kernel


def _filtered(picture: _Picture, kernel: NDArray[np.float64]) -> _Picture:
    """Correlate, mirrored about the outermost pixels."""
    filtered = cv2.filter2D(picture, -1, kernel, borderType=cv2.BORDER_REFLECT_101)
    clipped: _Picture = np.clip(filtered, 0, 1)  # it may multiply spectra, which leaves -1e-16
    return clipped


def _filtered_apart(picture: _Picture, line: NDArray[np.float64]) -> _Picture:
    """Correlate with the same line along both sides."""
    filtered = cv2.sepFilter2D(picture, -1, line, line, borderType=cv2.BORDER_REFLECT_101)
    clipped: _Picture = np.clip(filtered, 0, 1)
    return clipped


def _mixing(level: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """Return a matrix ``(3, 3)`` that gives independent noise a random covariance.

    It is |L² Uᵀ D U|, each number without its sign, D diagonal in [0, 1] and U a rotation, as the
    authors have it; what is not a covariance by that becomes the nearest one.
    """
    rotation, _ = np.linalg.qr(rng.random((3, 3)))
    covariance = level**2 * np.abs(rotation.T @ np.diag(rng.random(3)) @ rotation)
    variances, axes = np.linalg.eigh(covariance)
    mixing: NDArray[np.float32] = np.sqrt(np.maximum(variances, 0))[:, None] * axes.T
    return mixing.astype(np.float32)
