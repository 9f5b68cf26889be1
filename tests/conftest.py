"""Tests run on several cores at once: each worker then keeps to its own."""

import gc
import os
import sys
from collections.abc import Generator
from typing import Any

import pytest
from xdist.scheduler import LoadFileScheduling

if "PYTEST_XDIST_WORKER" in os.environ:  # before torch is imported
    os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ["LRSR_MODELS"] = "/nowhere"  # not what its user has pulled
# Dozens of processes are started: none compiles what another has compiled.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False


@pytest.hookimpl(wrapper=True)
def pytest_collect_file() -> Generator[None, list[pytest.Collector], list[pytest.Collector]]:
    """Look for doctests in the package alone."""
    return [found for found in (yield) if type(found) is pytest.Module]


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage meanwhile, a quarter of the time, and later none of what stays."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


_TOGETHER = (
    ("tests/rendering/", "tests/cli/test_whole.py", "tests/notebooks/"),  # all that starts Mitsuba
    ("tests/identities/",),
    ("tests/training/",),
)
"""What shares something that takes seconds to make, and one worker has in this order.

Every live scene makes Mitsuba's kernels others; in one process, and in one order, they are those
that an earlier run has compiled and kept.
"""


def _place(nodeid: str) -> tuple[int, int]:
    """Return the number of a test's group, and its place there; those without one come last."""
    for number, group in enumerate(_TOGETHER):
        for place, start in enumerate(group):
            if nodeid.startswith(start):
                return number, place
    return len(_TOGETHER), 0


class _LoadGroups(LoadFileScheduling):
    def _split_scope(self, nodeid: str) -> str:
        number, _ = _place(nodeid)
        return f"group {number}" if number < len(_TOGETHER) else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> _LoadGroups | None:
    return _LoadGroups(config, log) if config.getoption("dist") == "loadfile" else None


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what takes longest, so that all workers end at the same time."""
    items.sort(key=lambda item: _place(item.nodeid))
