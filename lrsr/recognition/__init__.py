"""From an image and five landmarks to an embedding."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.recognition.engine import Engine

__all__ = ["Engine"]


def __getattr__(name: str) -> object:
    """Import the engine (and torch with it) only when it is asked for.

    Raises:
        AttributeError: The part has no such name.
    """
    if name in __all__:
        from lrsr.recognition import engine

        return getattr(engine, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
