"""What can be chosen of a reconstruction, and which version of it is this?"""

from typing import Literal, get_args

PHOTOGRAPHS_VERSION = "4"
"""Changes whenever the same photograph would give another head."""

Hair = Literal["painted", "none"]
HAIRS: tuple[Hair, ...] = get_args(Hair)
Kept = Literal["photograph", "neutral"]
KEPT: tuple[Kept, ...] = get_args(Kept)
"""Whose expression a head has before it is told to act."""
