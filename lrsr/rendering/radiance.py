"""What comes off the film: scene-referred light and where the face is in it."""

from collections.abc import Sequence
from dataclasses import dataclass

import torch

from lrsr.identities.person import Traits
from lrsr.spectra import Spectrum


@dataclass(frozen=True)
class Radiance:
    """One rendered image, before any camera.

    Attributes:
        image: ``(3, H, W)`` float32, scene-referred linear sRGB primaries, >= 0, unbounded above;
            or ``(N, H, W)`` spectral bands, where ``edges_nm`` says so.
        landmarks_px: ``(5, 2)`` float32, (x, y) in pixels of ``image``: pixel (0, 0) is the
            top-left, its centre has the coordinate 0, so x' = s (x + 0.5) - 0.5 on a film s times
            finer.
        ipd_px: True interpupillary distance of the frontal face on the ×1 film, px.
        scale: How many times finer than the ×1 film (1, 2, 3 or 4).
        metered: Luminance that an incident-light meter reads at the face: what an 18 % grey
            Lambertian sphere there would send to the camera on average, divided by 0.18. The camera
            multiplies by 1 / metered, so a white sphere averages 1. It depends on the
            lighting alone, not on who is lit, so skin tones keep their order.
        traits: What is recorded of the head, where it is known.
        edges_nm: N + 1 edges of the bands, nm, rising (:mod:`lrsr.spectra`); None: three
            colours.
        metered_bands: N bands of what the same meter reads; their luminance is ``metered``.
    """

    image: torch.Tensor
    landmarks_px: torch.Tensor
    ipd_px: float
    scale: int
    metered: float
    traits: Traits | None = None
    edges_nm: tuple[float, ...] | None = None
    metered_bands: tuple[float, ...] | None = None


def spectrum_of(radiances: Sequence[Radiance]) -> Spectrum | None:
    """Return what the channels of those films are, if they are bands; None: three colours.

    Args:
        radiances: One or more, all of the same bands.
    """
    edges_nm = radiances[0].edges_nm
    if edges_nm is None:
        return None
    read = [(radiance.metered_bands or (), radiance.metered) for radiance in radiances]
    whites = tuple(tuple(band / metered for band in bands) for bands, metered in read)
    return Spectrum(edges_nm, whites)
