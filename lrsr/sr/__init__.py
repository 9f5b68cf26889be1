"""Makes small pictures larger, by networks that were trained and by formulas, behind one call."""

from lrsr.sr.fusion import Mean, ShiftAndAdd
from lrsr.sr.registration import Correlation, TrueLandmarks
from lrsr.sr.upscaler import Bicubic, Upscaler, load_upscaler

__all__ = [
    "Bicubic",
    "Correlation",
    "Mean",
    "ShiftAndAdd",
    "TrueLandmarks",
    "Upscaler",
    "load_upscaler",
]
