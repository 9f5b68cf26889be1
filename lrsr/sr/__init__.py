"""Makes small pictures larger, by networks that were trained and by formulas, behind one call."""

from lrsr.sr.foreign import Foreign
from lrsr.sr.fusion import Mean, ShiftAndAdd
from lrsr.sr.learned_fusion import load_fusion
from lrsr.sr.loading import load_upscaler
from lrsr.sr.onnx_network import Onnx
from lrsr.sr.registration import Correlation, TrueLandmarks
from lrsr.sr.upscaler import Bicubic, Upscaler

__all__ = [
    "Bicubic",
    "Correlation",
    "Foreign",
    "Mean",
    "Onnx",
    "ShiftAndAdd",
    "TrueLandmarks",
    "Upscaler",
    "load_fusion",
    "load_upscaler",
]
