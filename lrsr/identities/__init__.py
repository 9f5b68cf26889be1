"""Who is in the picture: synthetic heads, each made from a seed.

Nothing heavy is imported until the first of these names is used.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lrsr.identities.face.expression import Expression, find_expression
    from lrsr.identities.head import LANDMARK_NAMES, Head, Part
    from lrsr.identities.morphable import RECIPE_VERSION, sample_head, sample_parameters
    from lrsr.identities.splits import identity_seed, split_of

_HOMES = {
    "Expression": "face.expression",
    "Head": "head",
    "LANDMARK_NAMES": "head",
    "Part": "head",
    "RECIPE_VERSION": "morphable",
    "find_expression": "face.expression",
    "identity_seed": "splits",
    "sample_head": "morphable",
    "sample_parameters": "morphable",
    "split_of": "splits",
}

__all__ = [
    "LANDMARK_NAMES",
    "RECIPE_VERSION",
    "Expression",
    "Head",
    "Part",
    "find_expression",
    "identity_seed",
    "sample_head",
    "sample_parameters",
    "split_of",
]


def __getattr__(name: str) -> object:
    if name in _HOMES:
        return getattr(import_module(f"lrsr.identities.{_HOMES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
