"""What do a sensor's filters make of colours, and how does the camera undo it?

The filters of a sensor overlap: raw = R · linear, with the 3 × 3 responses R to the primaries of
sRGB. The camera multiplies the channels by the white balance's gains, so that its idea of white
becomes grey, clips, and takes the overlap out by a colour matrix M, whose rows sum to 1 so that
grey stays grey (J. Nakamura, Image Sensors and Signal Processing for Digital Still Cameras, CRC
2006). Noise grows in both. A white balance that misses leaves a cast.
"""

from collections.abc import Iterable, Sequence

import torch
from torch import nn

from lrsr.camera.checks import check_light, check_setting, numbers
from lrsr.spectra import Spectrum

_Matrix = Sequence[Sequence[float]]
_IDENTITY = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


class Colour(nn.Module):
    """The responses of the filters, white balance and colour matrix.

    Args:
        responses: ``(3, 3)``, what the red, green and blue sites see (rows) of linear red, green
            and blue (columns); what white gives must be positive, and 1 or less, or white clips.
        cast: Gains (red, green, blue) that the white balance is wrong by, > 0; (1, 1, 1): grey is
            grey; more than 1 clips the brightest of it.
        white_balance: Gains (red, green, blue); None: those that make white white, times ``cast``.
        matrix: ``(3, 3)``; None: the one that undoes ``responses`` exactly.

    Raises:
        InputError: A value is out of its range, or ``responses`` cannot be inverted.

    Example:
        >>> colour = Colour(((0.5, 0.1, 0.0), (0.1, 0.8, 0.1), (0.0, 0.1, 0.6)))
        >>> light = torch.tensor([0.5, 0.2, 0.1])[None, :, None, None]
        >>> [round(value, 4) for value in colour(colour.filter(light)).flatten().tolist()]
        [0.5, 0.2, 0.1]
    """

    def __init__(
        self,
        responses: _Matrix = _IDENTITY,
        *,
        cast: Sequence[float] = (1.0, 1.0, 1.0),
        white_balance: Sequence[float] | None = None,
        matrix: _Matrix | None = None,
    ) -> None:
        super().__init__()
        seen = _matrix("responses", responses)
        white = seen.sum(1)
        possible = bool((white > 0).all()) and abs(float(torch.linalg.det(seen))) > 1e-6
        check_setting("responses", seen.tolist(), possible, "independent rows with sums > 0")
        gains = _gains("cast", cast) / white
        if white_balance is not None:
            gains = _gains("white_balance", white_balance)
        undo = torch.linalg.inv(seen / white[:, None])
        self.responses = _rows(seen)
        self.white_balance = tuple(gains.tolist())
        self.matrix = _rows(undo if matrix is None else _matrix("matrix", matrix))

    def filter(self, linear: torch.Tensor) -> torch.Tensor:
        """Return what the filters let through, ``(B, 3, H, W)``, of linear light.

        Raises:
            ImageContractError: ``linear`` is no batch of three colours.
        """
        return _mix(linear, self.responses)

    def forward(self, raw: torch.Tensor, spectrum: Spectrum | None = None) -> torch.Tensor:
        """Balance raw channels ``(B, 3, H, W)``, clip them at white, and unmix them.

        Args:
            raw: Of each picture.
            spectrum: Is not looked at: what three numbers a filter do does not depend on the light.

        Returns:
            ``(B, 3, H, W)``, linear, not above 1 where the matrix has no entry above 1; may be < 0.

        Raises:
            ImageContractError: ``raw`` is no batch of three colours.
        """
        check_light(raw, name="raw")
        gains = torch.tensor(self.white_balance, dtype=raw.dtype, device=raw.device)
        return _mix((raw * gains[:, None, None]).clamp_max(1.0), self.matrix)


def _mix(linear: torch.Tensor, matrix: _Matrix) -> torch.Tensor:
    """Multiply each pixel of ``(B, 3, H, W)`` by a ``(3, 3)`` matrix.

    Raises:
        ImageContractError: ``linear`` is no batch of three colours.

    Example:
        >>> swap = ((0, 1, 0), (1, 0, 0), (0, 0, 1))
        >>> _mix(torch.tensor([1.0, 2.0, 3.0])[None, :, None, None], swap).flatten().tolist()
        [2.0, 1.0, 3.0]
    """
    check_light(linear)
    red, green, blue = linear.unbind(1)
    return torch.stack([row[0] * red + row[1] * green + row[2] * blue for row in matrix], 1)


def _matrix(name: str, rows: _Matrix) -> torch.Tensor:
    wish = "three rows of three numbers"
    listed = isinstance(rows, Iterable) and not isinstance(rows, str)
    check_setting(name, rows, listed and len(rows) == 3, wish)
    return torch.tensor([numbers(name, row, 3, wish) for row in rows], dtype=torch.float64)


def _gains(name: str, gains: Sequence[float]) -> torch.Tensor:
    return torch.tensor(numbers(name, gains, 3, "three gains > 0", above=0), dtype=torch.float64)


def _rows(matrix: torch.Tensor) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(row) for row in matrix.tolist())
