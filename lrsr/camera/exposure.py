"""How bright does the camera make a picture? By an incident-light meter, never by its content."""

import torch

from lrsr.errors import ImageContractError
from lrsr.images import check_images

KEY = 0.9
"""Linear value at which a diffuse white sphere is recorded on average at 0 EV.

An incident-light meter knows the light and not the subject, so the same light gives the same
exposure whoever stands in it, and skin tones keep their order. At 0.9 a face of albedo 0.35
averages 0.32 linear, 0.60 in sRGB, and peaks at 1.5 times that in light from the camera's side (a
Lambertian sphere there: mean 2/3 of the peak). Of six rendered heads nothing clips in light from
the front, above or below, and at most 2 % of the picture in light from the side, on the lit cheek.
"""


_UNDERSHOOT = 0.5
"""How far below black, as a share of its brightest value, an image's light may lie."""


def check_is_light(linear: torch.Tensor) -> torch.Tensor:
    """Return light ``(B, C, H, W)`` unchanged, if it is light.

    A little of it may lie below 0: colours that sRGB has not, and undershoot of filters. It counts
    as none where pixels count it. What lies lower is something else, such as a normalised picture.

    Raises:
        ImageContractError: An image has a value lower than minus half of its highest.

    Example:
        >>> check_is_light(torch.tensor([[[[-0.1, 1.0]]]])).min().item() < 0
        True
    """
    each = linear.detach().flatten(1)
    low, high = each.amin(dim=1), each.amax(dim=1)
    if bool((wrong := low < -_UNDERSHOOT * high).any()):
        first = int(wrong.nonzero()[0, 0])
        raise ImageContractError(
            f"linear: got values {low[first]:g} to {high[first]:g} in image {first}, wanted light,"
            " which is 0 or more"
        )
    return linear


def expose(linear: torch.Tensor, metered: torch.Tensor, exposure_ev: float = 0.0) -> torch.Tensor:
    """Scale scene-referred light by ``KEY * 2**exposure_ev / metered``.

    Args:
        linear: ``(B, 3, H, W)`` float32, scene-referred linear light, unbounded.
        metered: ``(B,)``, what :class:`lrsr.rendering.radiance.Radiance` calls ``metered``, > 0.
        exposure_ev: Correction in stops; +1 doubles the light.

    Returns:
        ``(B, 3, H, W)`` float32, linear, 1 = the sensor's white; not clipped.

    Raises:
        ImageContractError: The images break the contract, or ``metered`` is not one positive
            number for each of them.
        NonFiniteError: A NaN or an infinity in the images.

    Example:
        >>> white_sphere = torch.full((1, 3, 1, 1), 2.0)
        >>> expose(white_sphere, torch.tensor([2.0])).flatten()
        tensor([0.9000, 0.9000, 0.9000])
    """
    check_images(linear, name="linear")
    if not isinstance(metered, torch.Tensor):
        raise ImageContractError(f"metered: got {type(metered)}, wanted a torch.Tensor")
    if metered.shape != (len(linear),):
        raise ImageContractError(
            f"metered: got shape {tuple(metered.shape)}, wanted ({len(linear)},)"
        )
    if not bool((torch.isfinite(metered) & (metered > 0)).all()):
        raise ImageContractError(f"metered: got {metered.tolist()}, wanted finite numbers > 0")
    gain: torch.Tensor = KEY * 2.0**exposure_ev / metered.to(linear)
    return linear * gain[:, None, None, None]
