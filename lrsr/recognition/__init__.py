"""From an image and five landmarks to an embedding."""

from lrsr.recognition.engine import Engine

__all__ = ["Engine"]
