"""What may a stage of the camera be given? Checks that each of them makes, stated once."""

from collections.abc import Collection

import torch

from lrsr.errors import ImageContractError, InputError


def check_light(
    light: torch.Tensor, *, channels: Collection[int] = (3,), name: str = "linear"
) -> torch.Tensor:
    """Return ``light`` unchanged if it is ``(B, C, H, W)`` of floating point with a legal C.

    Unlike :func:`lrsr.images.check_images` it takes double precision too, in which gradients are
    checked, and leaves NaN and infinity to the camera's entrance.

    Raises:
        ImageContractError: Wrong number of dimensions or channels, an empty side, or whole numbers.

    Example:
        >>> check_light(torch.zeros(2, 1, 4, 4), channels=(1, 3)).shape
        torch.Size([2, 1, 4, 4])
    """
    if light.ndim != 4 or light.shape[1] not in channels or 0 in light.shape:
        wanted = " or ".join(map(str, channels))
        raise ImageContractError(
            f"{name}: got shape {tuple(light.shape)}, wanted (B, {wanted}, H, W)"
        )
    if not light.is_floating_point():
        raise ImageContractError(f"{name}: got {light.dtype}, wanted floating point")
    return light


def check_setting(name: str, value: object, holds: bool, wish: str) -> None:
    """Refuse a setting that breaks its rule.

    Raises:
        InputError: ``holds`` is false; the message names the setting, its value and the wish.

    Example:
        >>> check_setting("bits", 10, True, "8 to 16")
    """
    if not holds:
        raise InputError(f"{name}={value}: wanted {wish}")


def check_origin(origin_px: tuple[int, int]) -> tuple[int, int]:
    """Return the place ``(x, y)`` of a crop's first pixel in its frame as whole numbers.

    Raises:
        InputError: It is not two whole numbers >= 0.

    Example:
        >>> check_origin((8, 3))
        (8, 3)
    """
    pair = tuple(origin_px)
    whole = len(pair) == 2 and all(value == int(value) and value >= 0 for value in pair)
    check_setting("origin_px", pair, whole, "two whole numbers x, y >= 0")
    return int(pair[0]), int(pair[1])
