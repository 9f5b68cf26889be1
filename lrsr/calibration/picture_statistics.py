"""What can be told of a camera from pictures of strangers? A few numbers a picture.

Their mean over many pictures depends on the camera and on the population, not on who is shown:

- log power of luminance in rings of spatial frequency: blur takes from the high ones, sharpening
  raises the middle ones, noise fills them up;
- log variance of what the mask of J. Immerkær (Computer Vision and Image Understanding 64(2),
  1996, doi:10.1006/cviu.1996.0060, eq. 2) leaves of luminance and of both colour differences, in
  the smooth half of four ranges of brightness: the photon-transfer line, var = K · mean + read
  noise²;
- log power of the cosines of blocks (:mod:`lrsr.calibration.band_powers`), of luminance and of
  both colour differences, quiet and busy, dark and bright: noise apart from features where a codec
  has taken the fine cosines; noise of the colours, which is not sharpened, apart from that of
  luminance;
- quantiles of luminance and of the colour differences: exposure, contrast and saturation;
- log ratios of the channels' mean linear light: the colour cast;
- log spread of the colour differences, how they go together, and their means in the darker and
  the brighter half: saturation apart from the cast.

A mean tells where a cloud of people lies, its shape tells more: complexions fill a bent band with
ends. :func:`bend` therefore adds squares and limited copies of the colours' columns, which halve
the standard error of the cast at 50 people.

Only the middle of a picture counts, since what stands behind a real face is not what the renderer
puts there.
"""

from collections.abc import Iterable, Iterator
from itertools import pairwise

import numpy as np
import torch
from torch.nn import functional as F

from lrsr.calibration.band_powers import HALVES, band_powers, in_order
from lrsr.camera.checks import check_srgb, number
from lrsr.camera.processing import luminance
from lrsr.errors import ImageContractError
from lrsr.images import srgb_to_linear

_SMALLEST_PX = 12
"""Side of the middle part at least: fewer frequencies than rings otherwise."""
RINGS = (0.06, 0.12, 0.18, 0.24, 0.3, 0.36, 0.42, 0.5, 0.75)
"""Edges of the rings of spatial frequency, cycles a pixel."""
_QUANTILES = (0.05, 0.25, 0.5, 0.75, 0.95)
RANGES = 4
"""Ranges of brightness, each a quarter of the pixels."""
_ROUNDING = 1 / 12
"""Variance that rounding to 8 bits leaves, levels²: the least a variance can mean anything."""
_BANDS = {
    "luma": (0.5, 1.2, 2.3, 3.3, 4.5, 6.0, 8.0, 10.0),
    "red": (0.5, 1.2, 2.3, 4.5, 10.0),
    "blue": (0.5, 1.2, 2.3, 4.5, 10.0),
}
"""Edges of the bands of a block's cosines: of luminance and of the two colour differences."""

_BENT = (
    "log_red_green",
    "log_blue_green",
    "log_spread_red",
    "log_spread_blue",
    *(f"mean_{what}_{half}" for half in ("dark", "bright") for what in ("red", "blue")),
)
_COLOURS = ("correlation_red_blue", "slope_red_luma", "slope_blue_luma", "spread_luma", *_BENT)
_BLOCKS = {
    f"cosines of {plane}": [f"log_band_{plane}_{low:g}_{high:g}_" for low, high in pairwise(edges)]
    for plane, edges in _BANDS.items()
}
_PLANES = ("luminance", "red", "blue")
GROUPS = {
    "spectrum": tuple(f"log_power_{low:g}_{high:g}" for low, high in pairwise(RINGS)),
    "noise": tuple(f"log_noise_{plane}_{k}" for plane in _BANDS for k in range(1, RANGES + 1)),
    **{
        group: tuple(one + half for one in ones for half in HALVES)
        for group, ones in _BLOCKS.items()
    },
    "quantiles": tuple(f"{what}_{100 * q:g}" for what in _PLANES for q in _QUANTILES),
    "colours": _COLOURS,
}
"""Names of the columns of :func:`describe`, by what they tell of."""
NAMES = tuple(name for names in GROUPS.values() for name in names)
GROUPS["bent"] = (
    *(f"square_{name}" for name in _BENT),
    *(f"limited_{name}" for name in _BENT),
    "product_red_blue",
)
BENT_NAMES = (*NAMES, *GROUPS["bent"])
"""Names of the columns of :func:`bend`."""
_FIRST_BENT = NAMES.index(_BENT[0])


def describe(srgb: torch.Tensor, part: float = 0.75) -> torch.Tensor:
    """Return the numbers of each picture.

    Args:
        srgb: ``(B, 3, H, W)``, [0, 1].
        part: Share of the sides that counts, about the middle, > 0 to 1.

    Returns:
        ``(B, len(NAMES))`` float64: powers and variances in levels² (of 255), logs natural.

    Raises:
        ImageContractError: The images break the contract, or the middle part is under 12 px.
        InputError: ``part`` is out of range.
    """
    check_srgb(srgb)
    middle = crop(srgb, part).double()
    luma = 255 * luminance(middle)[:, 0]
    planes = {"luma": luma, "red": 255 * middle[:, 0] - luma, "blue": 255 * middle[:, 2] - luma}
    columns = [
        _ring_powers(luma),
        *_noise(planes.values(), luma),
        *(band_powers(planes[what], luma, edges, _ROUNDING) for what, edges in _BANDS.items()),
        *(_quantiles(plane) for plane in planes.values()),
        _together(**planes),
        _colours(middle, luma),
        _means(planes["red"], planes["blue"], luma),
    ]
    return torch.cat(columns, dim=1)


def bend(numbers: torch.Tensor, typical: torch.Tensor) -> torch.Tensor:
    """Add what makes means tell of the shape of a cloud of colours as well.

    Args:
        numbers: ``(B, len(NAMES))``, of :func:`describe`.
        typical: Mean and standard deviation over one camera's pictures: ``(2, len(NAMES))``, the
            same for all, or each picture's own, ``(2, B, len(NAMES))`` (:func:`leave_one_out`).

    Returns:
        ``(B, len(BENT_NAMES))``: then the squares of the colours' distances from the mean in
        standard deviations, their hyperbolic tangents, and the product of the first two.
    """
    columns = slice(_FIRST_BENT, _FIRST_BENT + len(_BENT))
    centre, spread = typical[..., columns]
    away = (numbers[:, columns] - centre) / spread.clamp_min(1e-6)
    return torch.cat([numbers, away.square(), away.tanh(), away[:, :1] * away[:, 1:2]], dim=1)


def leave_one_out(numbers: torch.Tensor) -> torch.Tensor:
    """Return mean and standard deviation of all pictures but the one in question.

    A picture that counts in its own mean is nearer to it than a stranger's can be.

    Args:
        numbers: ``(B, S)``, B >= 3.

    Returns:
        ``(2, B, S)``.

    Example:
        >>> leave_one_out(torch.tensor([[1.0], [3.0], [5.0]]))[0].flatten().tolist()
        [4.0, 3.0, 2.0]
    """
    count = len(numbers)
    away = numbers - numbers.mean(0)
    squares = away.square().sum(0) - away.square() * count / (count - 1)
    deviation = (squares.clamp_min(0) / (count - 2)).sqrt()
    return torch.stack([numbers.mean(0) - away / (count - 1), deviation])


def crop(images: torch.Tensor, part: float) -> torch.Tensor:
    """Return the middle ``part`` of the sides of ``(B, C, H, W)``.

    Raises:
        ImageContractError: Less than 12 pixels are left of a side.
        InputError: ``part`` is not above 0 and at most 1.

    Example:
        >>> crop(torch.zeros(1, 3, 32, 40), 0.75).shape[-2:]
        torch.Size([24, 30])
    """
    number("part", part, "a share > 0 to 1", above=0, high=1)
    height, width = images.shape[-2:]
    tall, wide = (round(part * side) for side in (height, width))
    if min(tall, wide) < _SMALLEST_PX:
        raise ImageContractError(
            f"pictures of {width} x {height} px: their middle {part:g} is under {_SMALLEST_PX} px; "
            "take larger ones or more of them"
        )
    top, left = (height - tall) // 2, (width - wide) // 2
    return images[..., top : top + tall, left : left + wide]


def _ring_powers(luma: torch.Tensor) -> torch.Tensor:
    """Return the log mean power ``(B, rings)``; white noise gives its variance in each."""
    height, width = luma.shape[-2:]
    window = torch.outer(_hann(height), _hann(width))
    centred = luma - (luma * window).sum((1, 2), keepdim=True) / window.sum()
    power = torch.fft.fft2(centred * window).abs().square() / window.square().sum()
    rows, columns = (torch.fft.fftfreq(side, dtype=torch.float64) for side in (height, width))
    radius = torch.hypot(rows[:, None], columns[None])
    rings = [power[:, (radius >= low) & (radius < high)].mean(1) for low, high in pairwise(RINGS)]
    return torch.stack(rings, 1).add(_ROUNDING).log()


def _hann(side: int) -> torch.Tensor:
    return torch.from_numpy(np.hanning(side + 2)[1:-1])


def _noise(planes: Iterable[torch.Tensor], luma: torch.Tensor) -> Iterator[torch.Tensor]:
    """Yield a plane's log variances ``(B, RANGES)``, from the darkest quarter to the brightest."""
    mask = torch.tensor([[1.0, -2, 1], [-2, 4, -2], [1, -2, 1]], dtype=torch.float64) / 6
    local = F.avg_pool2d(luma[:, None], 3, stride=1)[:, 0].flatten(1)
    order = local.argsort(dim=1, stable=True)
    for plane in planes:
        left = F.conv2d(plane[:, None], mask[None, None])[:, 0].flatten(1).square()
        groups = left.gather(1, order).tensor_split(RANGES, dim=1)
        smooth = [in_order(group)[:, : group.shape[1] // 2] for group in groups]
        # Of a normal variable, the smaller half of the squares has the mean 0.1426 of all.
        variances = [squares.mean(1) / 0.1426 for squares in smooth]
        yield torch.stack(variances, 1).add(_ROUNDING).log()


def _colours(srgb: torch.Tensor, luma: torch.Tensor) -> torch.Tensor:
    red, green, blue = srgb_to_linear(srgb).mean((2, 3)).add(1e-4).log().unbind(1)
    spread = (255 * srgb[:, (0, 2)] - luma[:, None]).std((2, 3)).square().add(_ROUNDING).log() / 2
    return torch.stack([red - green, blue - green, spread[:, 0], spread[:, 1]], 1)


def _quantiles(plane: torch.Tensor) -> torch.Tensor:
    return plane.flatten(1).quantile(torch.tensor(_QUANTILES, dtype=torch.float64), dim=1).T


def _together(luma: torch.Tensor, red: torch.Tensor, blue: torch.Tensor) -> torch.Tensor:
    """Return how the planes go together, ``(B, 4)``."""
    light, r, b = (plane.flatten(1) - plane.mean((1, 2))[:, None] for plane in (luma, red, blue))
    power = light.square().mean(1).add(_ROUNDING)
    colours = (r.square().mean(1).add(_ROUNDING) * b.square().mean(1).add(_ROUNDING)).sqrt()
    slopes = [(plane * light).mean(1) / power for plane in (r, b)]
    return torch.stack([(r * b).mean(1) / colours, *slopes, power.sqrt()], 1)


def _means(red: torch.Tensor, blue: torch.Tensor, luma: torch.Tensor) -> torch.Tensor:
    """Return the mean colour differences of the darker and the brighter half, ``(B, 4)``."""
    order = luma.flatten(1).argsort(dim=1, stable=True)
    both = torch.stack([red.flatten(1), blue.flatten(1)], 2)
    sorted_ = both.gather(1, order[..., None].expand_as(both))
    return torch.cat([half.mean(1) for half in sorted_.tensor_split(2, dim=1)], 1)
