"""One thread, makers that need no Mitsuba, and lessons that take milliseconds."""

from collections.abc import Iterator
from pathlib import Path

import pytest
import torch
from fakes.lessons import SyntheticPairs
from fakes.maker import FakeMaker
from fakes.painted import PaintedMaker

from lrsr.pictures.cache import RenderCache


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    """Two threads on a busy machine are slower than one, and round differently."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def maker() -> FakeMaker:
    return FakeMaker()


@pytest.fixture
def painter() -> PaintedMaker:
    return PaintedMaker()


@pytest.fixture
def cache(tmp_path: Path) -> RenderCache:
    return RenderCache(tmp_path / "cache")


@pytest.fixture
def pairs() -> SyntheticPairs:
    return SyntheticPairs()


@pytest.fixture(scope="session")
def many_pairs() -> SyntheticPairs:
    return SyntheticPairs(batch_size=8, count=80)
