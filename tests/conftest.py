"""Tests run on several cores at once: each worker then keeps to its own."""

import gc
import os
import sys
from collections.abc import Generator

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


_TOGETHER = {f"tests/{folder}" for folder in ("rendering", "training", "identities")}
"""Folders whose files share what takes seconds to make: one worker has all of them."""


def _folder(nodeid: str) -> str:
    return "/".join(nodeid.split("/")[:2])


class _LoadFolders(LoadFileScheduling):
    def _split_scope(self, nodeid: str) -> str:
        folder = _folder(nodeid)
        return folder if folder in _TOGETHER else super()._split_scope(nodeid)


def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> _LoadFolders:
    return _LoadFolders(config, log)


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Begin with what takes long, so that all workers end at the same time."""
    items.sort(key=lambda item: _folder(item.nodeid) not in _TOGETHER)
