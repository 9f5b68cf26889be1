"""What do measured colour filters make of spectral bands, and how does the camera undo it?

The filters' curves (:mod:`lrsr.camera.sensitivities`) weigh the bands of the film. Then the camera
does what :mod:`lrsr.camera.colour` says, but for a white and a matrix that follow from curves and
light: white is what the light of the scene gives off a perfect diffuser, or fixed daylight, and the
matrix is fitted in that light to the patches of a ColorChecker as the standard observer, adapted to
it, sees them (:mod:`lrsr.camera.colour_matrix`). Skin takes no part in the fit: makers do not know
whom their cameras will see.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal, get_args

import numpy as np
import torch
from torch import nn

from lrsr.camera.checks import check_choice, check_light, numbers
from lrsr.camera.colour_matrix import fit_matrix, observed
from lrsr.camera.sensitivities import FloatArray, Per, colorchecker, find_sensitivities
from lrsr.errors import InputError
from lrsr.spectra import BANDS, Spectrum, daylight, srgb_weights

_Balance = Literal["scene", "daylight"]


@dataclass(frozen=True, eq=False)
class Rendition:
    """How a camera renders the raw colours of one light.

    Attributes:
        gains: ``(3,)`` of the white balance.
        matrix: ``(3, 3)``, rows sum to 1.
    """

    gains: FloatArray
    matrix: FloatArray


class SpectralColour(nn.Module):
    """Measured filters before spectral bands, white balance and colour matrix.

    Args:
        sensitivities: "nikon_d5100", or a ``.csv`` file of nm, red, green, blue.
        per: "energy" or "quanta", of the responses in a file.
        balance: "scene": the light at the face becomes white, as by a camera whose automatic white
            balance is perfect. "daylight": D65 does, whatever the light is, so that rooms keep
            their hue, as in cameras that are described by three numbers a filter.
        cast: Gains (red, green, blue) that the white balance is wrong by, > 0.

    Raises:
        InputError: There are no such filters, or a setting is out of its range.
    """

    def __init__(
        self,
        sensitivities: str = "nikon_d5100",
        *,
        per: Per = "energy",
        balance: _Balance = "scene",
        cast: Sequence[float] = (1.0, 1.0, 1.0),
    ) -> None:
        super().__init__()
        self.sensitivities = find_sensitivities(sensitivities, per)
        self.balance = check_choice("balance", balance, get_args(_Balance))
        self.cast = numbers("cast", cast, 3, "three gains > 0", above=0)

    def filter(self, bands: torch.Tensor, spectrum: Spectrum | None) -> torch.Tensor:
        """Return what the filters let through.

        Args:
            bands: ``(B, N, H, W)``, light.
            spectrum: Says which bands they are.

        Returns:
            ``(B, 3, H, W)``; white in daylight of luminance 1 fills the strongest channel: 1.

        Raises:
            ImageContractError: The light is no batch of so many bands.
            InputError: It has no bands.
        """
        edges = needed(spectrum).edges_nm
        return _weigh(bands, [self.sensitivities.weights(edges)] * len(bands))

    def gains(self, spectrum: Spectrum | None, size: tuple[int, int]) -> torch.Tensor:
        """Return the white balance of each film at each pixel, ``(B, 3, H, W)`` float64.

        A camera multiplies each photosite by its filter's gain and clips at white before it
        interpolates, which takes the three channels of a grey edge for equal.

        Args:
            spectrum: Holds the light of each film.
            size: (height, width).

        Raises:
            InputError: The light has no bands.
        """
        edges, whites = needed(spectrum).edges_nm, needed(spectrum).whites
        gains = torch.tensor(np.array([self.rendition(edges, white).gains for white in whites]))
        return gains[:, :, None, None].expand(-1, -1, *size)

    def forward(self, balanced: torch.Tensor, spectrum: Spectrum | None) -> torch.Tensor:
        """Unmix balanced channels ``(B, 3, H, W)``.

        Args:
            balanced: Of each film, white being 1.
            spectrum: Holds the light of each.

        Returns:
            ``(B, 3, H, W)``, linear sRGB; may be < 0, and > 1 where the matrix has entries > 1.

        Raises:
            ImageContractError: ``balanced`` is no batch of three colours.
            InputError: The light has no bands.
        """
        check_light(balanced, name="balanced")
        edges, whites = needed(spectrum).edges_nm, needed(spectrum).whites
        return _weigh(balanced, [self.rendition(edges, white).matrix for white in whites])

    def rendition(
        self, edges_nm: tuple[float, ...], white: tuple[float, ...] | None = None
    ) -> Rendition:
        """Return gains and matrix for a light.

        Args:
            edges_nm: Of N bands.
            white: N bands of the light, of luminance 1; daylight where that is the balance, or if
                it is None.
        """
        if self.balance == "daylight" or white is None:
            white = tuple(daylight(edges_nm).tolist())
        return self._rendition(edges_nm, white)

    @lru_cache(maxsize=64)  # noqa: B019 - a camera lives as long as its process
    def _rendition(self, edges_nm: tuple[float, ...], white: tuple[float, ...]) -> Rendition:
        weights, light = self.sensitivities.weights(edges_nm), np.array(white)
        patches = colorchecker(edges_nm)
        balanced = (patches * light) @ weights.T / (weights @ light)
        matrix = fit_matrix(balanced, observed(edges_nm, light, patches))
        return Rendition(np.array(self.cast) / (weights @ light), matrix)

    def extra_repr(self) -> str:
        """Show the settings when the module is printed."""
        return f"sensitivities={self.sensitivities.name!r}, balance={self.balance!r}"


def needed(spectrum: Spectrum | None, bands: int = BANDS) -> Spectrum:
    """Return the spectrum that measured filters cannot do without.

    Raises:
        InputError: There is none; the message says how to render ``bands`` of it.
    """
    if spectrum is None:
        raise InputError(
            "measured colour filters need spectral bands, but this light has three colours: render"
            f" it with LRSR_VARIANT=llvm_ad_spectral and bands={bands}"
        )
    return spectrum


def observe(bands: torch.Tensor, spectrum: Spectrum, *, adapted: bool = False) -> torch.Tensor:
    """Return linear sRGB ``(B, 3, H, W)`` of bands as the CIE 1931 observer sees them.

    Args:
        bands: ``(B, N, H, W)``, light.
        spectrum: Says which bands they are, and the light of each film.
        adapted: That light looks white; else daylight does, as sRGB has it.

    Raises:
        ImageContractError: The light is no batch of so many bands.
    """
    edges = spectrum.edges_nm
    whites = spectrum.whites if adapted else [None] * len(bands)
    return _weigh(bands, [srgb_weights(edges, white) for white in whites])


def _weigh(channels: torch.Tensor, weights: Sequence[FloatArray]) -> torch.Tensor:
    """Weigh the channels of each image by its own matrix.

    One image after the other: sums of a batch would depend, in their last bits, on its size.

    Args:
        channels: ``(B, N, H, W)``.
        weights: ``(K, N)``, one for each image.

    Returns:
        ``(B, K, H, W)``.

    Raises:
        ImageContractError: The channels are no batch of N of them.

    Example:
        >>> bands = torch.tensor([1.0, 2.0])[None, :, None, None]
        >>> _weigh(bands, [np.array([[1.0, 1.0], [0.0, 3.0]])]).flatten().tolist()
        [3.0, 6.0]
    """
    check_light(channels, channels=(weights[0].shape[1],), name="bands")
    pairs = zip(channels, weights, strict=True)
    mixed = [torch.as_tensor(rows).to(image) @ image.flatten(1) for image, rows in pairs]
    return torch.stack(mixed).reshape(len(channels), -1, *channels.shape[2:])
