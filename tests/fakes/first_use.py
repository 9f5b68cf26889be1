"""Who uses Mitsuba first in a process: threads, children that it starts, or one that it forks."""

import sys
import threading
from collections.abc import Callable
from multiprocessing import get_context

from fakes.scenes import Studio
from oracles.heads import stand_in

from lrsr.rendering import render

Seen = tuple[list[float], list[str]]
"""The pictures' means, and what went wrong."""


def threads() -> Seen:
    """Of one renderer and of their own, then the main one."""
    seen, faults = _in_threads([_picture] * 3 + [_own] * 2)
    return [*seen, _picture()], faults


def children() -> Seen:
    """Which a process that has rendered starts."""
    return [_picture(), _in_child("spawn"), _in_child("forkserver")], []


def fork() -> Seen:
    """A forked child before its parent."""
    return [_in_child("fork"), _picture()], []


def tell(first: Callable[[], Seen]) -> None:
    """Write how many pictures there are, how many of them differ, and the faults; then fork."""
    seen, faults = first()
    sys.stdout.write(f"{len(seen)} {len(set(seen))} {faults}\n")
    sys.stdout.flush()
    _in_child("fork")


def _picture(_: int = 0) -> float:
    return float(render(stand_in(0), ipd_px=4.0, samples_per_pixel=16).image.double().mean())


def _own() -> float:
    image = Studio().render(stand_in(0), ipd_px=4.0, samples_per_pixel=16).image
    return float(image.double().mean())


def _in_threads(functions: list[Callable[[], float]]) -> Seen:
    seen: list[float] = []
    faults: list[str] = []

    def work(function: Callable[[], float]) -> None:
        try:
            seen.append(function())
        except BaseException as error:
            faults.append(f"{type(error).__name__}: {error}")

    started = [threading.Thread(target=work, args=(function,)) for function in functions]
    for thread in started:
        thread.start()
    for thread in started:
        thread.join()
    return seen, faults


def _in_child(method: str) -> float:
    with get_context(method).Pool(1) as pool:
        return pool.map_async(_picture, [0]).get(timeout=120)[0]
