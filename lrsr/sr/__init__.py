"""Makes small pictures larger, by networks that were trained and by formulas, behind one call."""

from lrsr.sr.upscaler import Bicubic, Upscaler, load_upscaler

__all__ = ["Bicubic", "Upscaler", "load_upscaler"]
