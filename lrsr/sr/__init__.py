"""Makes small pictures larger, by networks that were trained and by formulas, behind one call."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.sr.upscaler import Bicubic, Upscaler, load_upscaler

__all__ = ["Bicubic", "Upscaler", "load_upscaler"]


def __getattr__(name: str) -> object:
    """Import the upscalers (and torch with them) only when they are asked for.

    Raises:
        AttributeError: The part has no such name.
    """
    if name in __all__:
        from lrsr.sr import upscaler

        return getattr(upscaler, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
