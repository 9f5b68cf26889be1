"""Which bicubic? The one of :mod:`lrsr.images`, and the words by which files name it."""

from lrsr.images import resize_bicubic

__all__ = ["ENLARGED_BY", "resize_bicubic"]

#: Written into every weights file and ONNX export: a network works only behind its own kernel.
ENLARGED_BY = "bicubic, Keys a=-0.5 (MATLAB imresize), edges replicated"
