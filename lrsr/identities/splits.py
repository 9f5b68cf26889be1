"""Which seeds belong to training, which to validation, which to testing? No seed to two of them."""

from typing import Literal, get_args

Split = Literal["train", "validation", "test"]
SPLITS: tuple[Split, ...] = get_args(Split)


def identity_seed(split: Split, index: int) -> int:
    """Return the seed of one identity: ``3 index + 0, 1 or 2``, so splits can never meet.

    Args:
        split: "train", "validation" or "test".
        index: Number of the identity within its split, >= 0.

    Returns:
        A seed for :func:`lrsr.identities.morphable.sample_head`.

    Raises:
        ValueError: The split is unknown or the index negative.

    Example:
        >>> [identity_seed(split, 7) for split in SPLITS]
        [21, 22, 23]
    """
    if split not in SPLITS:
        raise ValueError(f"split must be one of {', '.join(SPLITS)}, got {split!r}")
    if index < 0:
        raise ValueError(f"index must be >= 0, got {index}")
    return len(SPLITS) * index + SPLITS.index(split)


def split_of(seed: int) -> Split:
    """Return the split that a seed belongs to.

    Args:
        seed: >= 0.

    Raises:
        ValueError: The seed is negative.

    Example:
        >>> split_of(22)
        'validation'
    """
    if seed < 0:
        raise ValueError(f"seed must be >= 0, got {seed}")
    return SPLITS[seed % len(SPLITS)]
