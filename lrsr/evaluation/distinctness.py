"""Is everybody somebody else? Angles between embeddings, and who has to be drawn again.

The measure is that of Colbois, de Freitas Pereira and Marcel, "On the use of automatically
generated synthetic image datasets for benchmarking face recognition" (IJCB 2021): the angle between
the embeddings of two people's pictures. Two who are nearer than some angle count as one.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from lrsr.errors import ScoreError
from lrsr.evaluation.arrays import plain_array

_Floats = NDArray[np.float64]
Drawn = tuple[int, int]
"""Index of an identity, and how often it was redrawn."""

_ROWS = 512


@dataclass(frozen=True)
class Pair:
    """Two people.

    Attributes:
        first: Row of the earlier one.
        second: Row of the later one.
        angle_deg: Between their embeddings.
    """

    first: int
    second: int
    angle_deg: float


def pairwise_angles_deg(embeddings: ArrayLike) -> NDArray[np.float32]:
    """Return the angles between all pairs of rows; 1500 people take half a second.

    Args:
        embeddings: ``(N, D)``, not 0; a row with a NaN (nobody was found) is in no pair.

    Returns:
        ``(M (M - 1) / 2,)`` degrees, [0, 180], M the rows without NaN, in the order (0, 1),
        (0, 2), ..., (1, 2), ...

    Example:
        >>> pairwise_angles_deg([[1, 0], [0, 2], [-3, 0]]).tolist()
        [90.0, 180.0, 90.0]
    """
    rows = _unit_rows(embeddings)
    rows = rows[np.isfinite(rows).all(axis=1)]
    angles = [np.empty(0, np.float32)]
    for start, block in _blocks(rows):
        for offset, cosines in enumerate(block):
            angles.append(_degrees(cosines[start + offset + 1 :]).astype(np.float32))
    return np.concatenate(angles)


def closest_pairs(embeddings: ArrayLike, count: int) -> list[Pair]:
    """Return the pairs with the smallest angles, smallest first; ties in the order of the rows.

    Args:
        embeddings: ``(N, D)``; a row with a NaN is in no pair.
        count: How many at most, >= 0.
    """
    rows = _unit_rows(embeddings)
    found: list[Pair] = []
    for start, block in _blocks(rows):
        first, second = np.nonzero(np.triu(np.isfinite(block), k=start + 1))
        cosines = block[first, second]
        if len(cosines) > count:
            limit = np.partition(cosines, -count)[-count] if count else np.inf
            near = cosines >= limit
            first, second, cosines = first[near], second[near], cosines[near]
        pairs = zip(first + start, second, _degrees(cosines), strict=True)
        found += [Pair(int(a), int(b), float(angle)) for a, b, angle in pairs]
    return sorted(found, key=lambda pair: (pair.angle_deg, pair.first, pair.second))[:count]


def summarise(angles_deg: ArrayLike) -> dict[str, float | int]:
    """Return number, minimum, percentiles and maximum of angles; only the number if there are none.

    Args:
        angles_deg: Any shape, degrees.
    """
    angles = plain_array(angles_deg, "angles").astype(np.float64)
    if angles.size == 0:
        return {"pairs": 0}
    shares = {"p0_1": 0.1, "p1": 1, "p5": 5, "median": 50, "p95": 95, "p99": 99}
    values = np.percentile(angles, list(shares.values()))
    return {
        "pairs": int(angles.size),
        "min": float(angles.min()),
        **{name: float(value) for name, value in zip(shares, values, strict=True)},
        "max": float(angles.max()),
    }


@dataclass(frozen=True)
class Distinct:
    """Who is left when look-alikes were redrawn.

    Attributes:
        draws: How often each identity was redrawn, in the order of the indices.
        unresolved: Identities that were still too near to somebody when the bound was reached.
        rejected: Everyone who was drawn and dismissed: index, draw, whom they were too near to
            (index), and the angle, degrees.
    """

    draws: tuple[int, ...]
    unresolved: tuple[int, ...]
    rejected: tuple[tuple[int, int, int, float], ...]


def draw_distinct(
    indices: Sequence[int],
    embed: Callable[[Sequence[Drawn]], ArrayLike],
    *,
    smallest_angle_deg: float,
    most_redraws: int,
) -> Distinct:
    """Redraw everyone who is too near to somebody before them, until nobody is.

    Each identity is the first of its draws that is at least ``smallest_angle_deg`` from everybody
    with a smaller index. The outcome of an index depends on those before it alone, not on how many
    follow, nor on how the work is done: people whose turn cannot be settled yet are drawn together,
    then all is decided anew.

    Args:
        indices: Of the identities, in order.
        embed: Returns ``(n, D)`` embeddings of n people, always the same for the same one; a row
            with a NaN (nobody was found) is near to nobody.
        smallest_angle_deg: At and above it two people are different; 0 accepts everybody.
        most_redraws: Per identity. Whoever is still too near then keeps the draw that came out
            farthest from everybody.

    Raises:
        ValueError: ``most_redraws`` is negative.
    """
    if most_redraws < 0:
        raise ValueError(f"most_redraws must be >= 0, got {most_redraws}")
    known: dict[Drawn, _Floats] = {}
    wanted: list[Drawn] = [(index, 0) for index in indices]
    outcome = Distinct((), (), ())
    while wanted:
        rows = _unit_rows(embed(wanted))
        known |= dict(zip(wanted, rows, strict=True))
        outcome, wanted = _decide(indices, known, smallest_angle_deg, most_redraws)
    return outcome


def nearest(row: NDArray[np.floating], others: NDArray[np.floating]) -> tuple[int, float]:
    """Return who of the others is nearest, and the angle, degrees; 180 if there is nobody.

    Args:
        row: ``(D,)`` of length 1.
        others: ``(N, D)`` of length 1, or with a NaN: near to nobody.

    Example:
        >>> nearest(np.array([0.0, 1.0]), np.array([[0.0, -1.0], [1.0, 0.0]]))
        (1, 90.0)
    """
    cosines = np.nan_to_num(others @ row, nan=-1.0) if len(others) else -np.ones(1)
    whom = int(np.argmax(cosines))
    return whom, float(_degrees(cosines[whom]))


def _decide(
    indices: Sequence[int], known: Mapping[Drawn, _Floats], angle_deg: float, most: int
) -> tuple[Distinct, list[Drawn]]:
    """Settle everyone in order with what is known; return the outcome and who must be drawn."""
    accepted = np.empty((len(indices), next(iter(known.values())).size))
    whom: list[int] = []
    draws: list[int] = []
    unresolved: list[int] = []
    rejected: list[tuple[int, int, int, float]] = []
    wanted: list[Drawn] = []
    for index in indices:
        tried: list[tuple[int, int, int, float]] = []
        for draw in range(most + 1):
            if (index, draw) not in known:
                wanted.append((index, draw))
                break
            near, distance = nearest(known[index, draw], accepted[: len(whom)])
            if distance >= angle_deg:
                break
            tried.append((index, draw, whom[near], distance))
        else:
            draw = max(tried, key=lambda entry: entry[3])[1]
            unresolved.append(index)
        rejected += [entry for entry in tried if entry[1] != draw]
        draws.append(draw)
        if (index, draw) in known:  # whoever is still to be drawn is left out for now
            accepted[len(whom)] = known[index, draw]
            whom.append(index)
    return Distinct(tuple(draws), tuple(unresolved), tuple(rejected)), wanted


def _blocks(rows: _Floats) -> Iterator[tuple[int, _Floats]]:
    """Yield the cosines of some rows with all, and the number of the first of them."""
    for start in range(0, len(rows), _ROWS):
        yield start, rows[start : start + _ROWS] @ rows.T


def _degrees(cosines: _Floats) -> _Floats:
    return np.degrees(np.arccos(np.clip(cosines, -1.0, 1.0)))


def _unit_rows(embeddings: ArrayLike) -> _Floats:
    """Divide each row by its length, in double precision.

    Args:
        embeddings: ``(N, D)``, no row of zeros, of any real type and origin.

    Raises:
        ScoreError: They are no table of real numbers, or a row is infinite or all zeros.
    """
    rows = plain_array(embeddings, "embeddings").astype(np.float64)
    if rows.ndim != 2:
        raise ScoreError(f"got embeddings of shape {rows.shape}, wanted (N, D)")
    broken = np.isinf(rows).any(axis=1) | ~rows.any(axis=1)
    if broken.any():
        raise ScoreError(f"embedding {int(np.argmax(broken))} is infinite or all zeros")
    return np.asarray(rows / np.linalg.norm(rows, axis=1, keepdims=True))
