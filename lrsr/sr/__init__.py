"""Makes small pictures larger, by networks that were trained and by formulas, behind one call."""

from lrsr.sr.foreign import Foreign
from lrsr.sr.loading import load_upscaler
from lrsr.sr.onnx_network import Onnx
from lrsr.sr.upscaler import Bicubic, Upscaler

__all__ = ["Bicubic", "Foreign", "Onnx", "Upscaler", "load_upscaler"]
