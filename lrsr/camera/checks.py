"""What may a stage of the camera be given? Checks that each of them makes, stated once."""

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from contextlib import suppress
from numbers import Real

import numpy as np
import torch

from lrsr.errors import ImageContractError, InputError


def check_light(
    light: torch.Tensor, *, channels: Collection[int] = (3,), name: str = "linear"
) -> torch.Tensor:
    """Return ``light`` unchanged if it is ``(B, C, H, W)`` of floating point with a legal C.

    Unlike :func:`lrsr.images.check_images` it takes double precision too, in which gradients are
    checked, and leaves NaN and infinity to the camera's entrance.

    Raises:
        ImageContractError: Wrong number of dimensions or channels, an empty side, no tensor, whole
            numbers, or half precision, in which 8 bits are lost.

    Example:
        >>> check_light(torch.zeros(2, 1, 4, 4), channels=(1, 3)).shape
        torch.Size([2, 1, 4, 4])
    """
    if not isinstance(light, torch.Tensor):
        raise ImageContractError(f"{name}: got {type(light).__name__}, wanted a torch.Tensor")
    if light.layout != torch.strided or light.is_meta:
        raise ImageContractError(f"{name}: got a tensor without plain values; give .to_dense()")
    if light.ndim != 4 or light.shape[1] not in channels or 0 in light.shape:
        wanted = " or ".join(map(str, channels))
        raise ImageContractError(
            f"{name}: got shape {tuple(light.shape)}, wanted (B, {wanted}, H, W)"
        )
    if light.dtype not in (torch.float32, torch.float64):
        wish = "floating point of 32 bits (or 64)"
        raise ImageContractError(f"{name}: got {light.dtype}, wanted {wish}")
    return light


def check_srgb(srgb: torch.Tensor) -> torch.Tensor:
    """Return a batch of pictures ``(B, 3, H, W)`` unchanged if all values lie in [0, 1].

    Raises:
        ImageContractError: It is none (:func:`check_light`), or has another range, e.g. 0..255.
    """
    check_light(srgb, name="srgb")
    low, high = (float(end) for end in srgb.detach().aminmax())
    if not (low >= 0 and high <= 1):
        raise ImageContractError(f"srgb: got values from {low:g} to {high:g}, wanted [0, 1]")
    return srgb


def check_setting(name: str, value: object, holds: bool, wish: str) -> None:
    """Refuse a setting that breaks its rule.

    Raises:
        InputError: ``holds`` is false; the message names the setting, its value and the wish.

    Example:
        >>> check_setting("bits", 10, True, "8 to 16")
    """
    if not holds:
        raise InputError(f"{name}={value}: wanted {wish}")


def check_choice(name: str, value: object, choices: Collection[str]) -> str:
    """Return a word that is one of ``choices``.

    Raises:
        InputError: It is none of them.
    """
    known = isinstance(value, str) and value in choices
    check_setting(name, value, known, f"one of {', '.join(choices)}")
    return str(value)


def check_flag(name: str, value: object) -> bool:
    """Return a truth value, NumPy's too; 0 and 1 are some.

    Raises:
        InputError: It is none; words are not taken for one.
    """
    known = isinstance(value, int | np.bool_ | np.integer) and value in (0, 1)
    check_setting(name, value, known, "true or false")
    return bool(value)


def number(
    name: str,
    value: object,
    wish: str = "a finite number",
    *,
    low: float = -math.inf,
    high: float = math.inf,
    above: float = -math.inf,
) -> float:
    """Return a finite number of any type, NumPy's too, as a float.

    Args:
        name: Of the setting.
        value: Truth values and words are no numbers.
        wish: What the message asks for.
        low: It is not below.
        high: It is not above.
        above: It is greater.

    Raises:
        InputError: It is no number, not finite, or out of range.

    Example:
        >>> number("prnu", 0, "a fraction 0..0.5", low=0, high=0.5)
        0.0
    """
    found = _finite(value)
    check_setting(name, value, low <= found <= high and found > above, wish)
    return found


def whole(name: str, value: object, wish: str, *, low: float, high: float = math.inf) -> int:
    """Return a whole number of any type (3.0, as configurations may write it, is one) as an int.

    Raises:
        InputError: It is none, or out of range.
    """
    found = number(name, value, wish, low=low, high=high)
    check_setting(name, value, found == int(found), wish)
    return int(found)


def numbers(
    name: str, values: object, count: int, wish: str | None = None, *, above: float = -math.inf
) -> tuple[float, ...]:
    """Return ``count`` finite numbers of any list, tuple, array or configuration's list.

    Raises:
        InputError: There are others, or more or fewer.

    Example:
        >>> numbers("cast", [1, 1.0, 2], 3)
        (1.0, 1.0, 2.0)
    """
    listed = isinstance(values, Iterable) and not isinstance(values, str | Mapping)
    found = tuple(_finite(value) for value in values) if listed else ()  # type: ignore[attr-defined]
    fits = len(found) == count and all(math.isfinite(one) and one > above for one in found)
    check_setting(name, values, fits, wish or f"{count} finite numbers")
    return found


def check_positive(**settings: object) -> None:
    """Refuse what is not a finite number above zero.

    Raises:
        InputError: One is not; the message names it.
    """
    for name, value in settings.items():
        if not _finite(value) > 0:
            raise InputError(f"{name} {value}: give a finite number > 0")


def check_origin(origin_px: Sequence[float]) -> tuple[int, int]:
    """Return the place ``(x, y)`` of a crop's first pixel in its frame as whole numbers.

    Raises:
        InputError: It is not two whole numbers >= 0.

    Example:
        >>> check_origin((8, 3))
        (8, 3)
    """
    wish = "two whole numbers x, y >= 0"
    x, y = numbers("origin_px", origin_px, 2, wish)
    check_setting("origin_px", origin_px, x == int(x) >= 0 and y == int(y) >= 0, wish)
    return int(x), int(y)


def _finite(value: object) -> float:
    """Return a number, or NaN for anything that is no finite one."""
    if not isinstance(value, bool) and isinstance(value, Real):
        with suppress(OverflowError):  # a whole number of hundreds of digits
            found = float(value)
            return found if math.isfinite(found) else math.nan
    return math.nan
