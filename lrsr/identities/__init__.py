"""Who is in the picture: synthetic heads, each made from a seed.

Nothing heavy is imported until the first of these names is used.
"""

from importlib import import_module

_HOMES = {
    "AnotherDay": "day.another_day",
    "Expression": "face.expression",
    "Head": "head",
    "Person": "person",
    "sample_head": "morphable",
}

__all__ = list(_HOMES)


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(f"lrsr.identities.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
