"""Which random numbers does each ray take? Stratified ones, so that neighbours in a kernel stay so.

Samples are stratified in every dimension (correlated multi-jittered: Kensler 2013). On a face that
takes six times fewer rays than independent samples need for the same noise.

The numbers are those of Mitsuba's ``multijitter``, bit for bit, but which lane of the kernel traces
which of a pixel's rays is chosen by where in the pixel it starts. Mitsuba's order is random, and a
packet of rays that start far apart meets more boxes and more materials: a quarter of the time.
"""

import math
from functools import cache
from typing import Any

from lrsr.rendering.backend import dr, mi

_STRIP = 4
"""Rows of strata that are walked together; a packet of 8 rays then covers 2 x 4 strata."""

_IN_1D, _IN_2D, _IN_X, _IN_Y = 0x45FBE943, 0x51633E2D, 0x68BC21EB, 0x02E5BE93
"""Multipliers by which ``multijitter`` tells its permutations apart."""


def grid(samples: int) -> tuple[int, int]:
    """Return columns and rows of the nearly square grid of strata for at least that many samples.

    Example:
        >>> [grid(n) for n in (16, 17, 2048)]
        [(4, 4), (5, 4), (46, 45)]
    """
    rows = math.isqrt(samples)
    return -(-samples // rows), rows


def order_rays(samples: int, pixels: int, seed: int) -> Any:
    """Return which of Mitsuba's lanes each lane stands for, a permutation within every pixel.

    Args:
        samples: Per pixel; fills its :func:`grid`.
        pixels: Of the film.
        seed: Of the sampler.
    """
    columns, rows = grid(samples)
    given = dr.arange(mi.UInt32, samples * pixels)
    number, stream = _stream(given, samples, seed)
    row, column = _cell(mi.permute_kensler(number, samples, stream * _IN_2D), columns)
    first = row // _STRIP * _STRIP
    height = dr.minimum(rows - first, _STRIP)
    place = first * columns + column * height + row - first
    order = dr.empty(mi.UInt32, samples * pixels)
    dr.scatter(order, given, given - number + place, mode=dr.ReduceMode.Permute)
    dr.eval(order)
    return order


def stratified(samples: int, seed: int, lanes: Any) -> Any:
    """Make the ``mi.Sampler`` that gives what ``multijitter`` gives in those lanes.

    Args:
        samples: Per pixel; fills its :func:`grid`.
        seed: Of the sampler.
        lanes: Of :func:`order_rays`.
    """
    return _sampler_class(mi.variant())(samples, seed, lanes)


def _stream(lanes: Any, samples: int, seed: int) -> tuple[Any, Any]:
    """Return which of its pixel's samples a lane is, and the seed of the pixel's permutations."""
    number = lanes - lanes // samples * samples
    first = lanes - number + dr.opaque(mi.UInt32, seed)
    return number, mi.sample_tea_32(dr.opaque(mi.UInt32, 0), first)[0]


def _cell(stratum: Any, columns: int) -> tuple[Any, Any]:
    row = stratum // columns
    return row, stratum - row * columns


@cache
def _sampler_class(variant: str) -> type:
    """Make the class for a variant of Mitsuba, whose base class has one of its own."""

    class Stratified(mi.Sampler):  # type: ignore[misc]  # untyped
        """See the module; Dr.Jit carries its arrays through loops."""

        def __init__(self, samples: int, seed: int, lanes: Any) -> None:
            super().__init__(mi.Properties())
            self.samples, (self.columns, self.rows) = samples, grid(samples)
            self.number, self.stream = _stream(lanes, samples, seed)
            self.dimension = dr.opaque(mi.UInt32, 0)
            self.jitter = mi.PCG32()
            state = mi.sample_tea_32(dr.opaque(mi.UInt32, seed), lanes)
            self.jitter.seed(*(mi.UInt64(word) for word in state))

        def next_1d(self, active: Any = True) -> Any:
            """Return one number in [0, 1)."""
            seed = self.stream + self.dimension
            self.dimension += 1
            place = mi.permute_kensler(self.number, self.samples, seed * _IN_1D, active)
            return (mi.Float(place) + self.jitter.next_float32(active)) * (1 / self.samples)

        def next_2d(self, active: Any = True) -> Any:
            """Return two."""
            seed = self.stream + self.dimension
            self.dimension += 1
            stratum = mi.permute_kensler(self.number, self.samples, seed * _IN_2D, active)
            row, column = _cell(stratum, self.columns)
            x = mi.permute_kensler(column, self.columns, seed * _IN_X, active)
            y = mi.permute_kensler(row, self.rows, seed * _IN_Y, active)
            wide, high = 1 / self.columns, 1 / self.rows
            across = mi.Float(column) + (mi.Float(y) + self.jitter.next_float32(active)) * high
            down = mi.Float(row) + (mi.Float(x) + self.jitter.next_float32(active)) * wide
            return mi.Point2f(across * wide, down * high)

    Stratified.__qualname__ = f"Stratified[{variant}]"
    return Stratified
