"""Which seeds belong to training, which to validation, which to testing? No seed to two of them."""

from typing import Literal, get_args

Split = Literal["train", "validation", "test"]
SPLITS: tuple[Split, ...] = get_args(Split)

LARGEST_INDEX = 2**36
"""More people than anybody draws; above their seeds lie those of the redrawn."""

_DRAW = len(SPLITS) * 2**40


def identity_seed(split: Split, index: int, draw: int = 0) -> int:
    """Return the seed of one identity: ``3 index + 0, 1 or 2``, so splits can never meet.

    Who was redrawn, because somebody else looks too much like them, gets another seed of the same
    remainder that no first draw has: ``3 index + 0, 1 or 2 + 3 draw 2**40``.

    Args:
        split: "train", "validation" or "test".
        index: Number of the identity within its split, 0 to 2**36.
        draw: How many times the identity was redrawn, >= 0.

    Returns:
        A seed for :func:`lrsr.identities.morphable.sample_head`.

    Raises:
        ValueError: The split is unknown, or the index or the draw out of range.

    Example:
        >>> [identity_seed(split, 7) for split in SPLITS]
        [21, 22, 23]
    """
    if split not in SPLITS:
        raise ValueError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
    if not 0 <= index <= LARGEST_INDEX:
        raise ValueError(f"index must be 0 to {LARGEST_INDEX}, got {index}")
    if draw < 0:
        raise ValueError(f"draw must be >= 0, got {draw}")
    return len(SPLITS) * index + SPLITS.index(split) + _DRAW * draw
