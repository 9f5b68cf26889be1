"""A cache in a folder of its own, and a maker that needs no Mitsuba."""

from pathlib import Path

import pytest
from fakes.maker import FakeMaker

from lrsr.pictures.cache import RenderCache


@pytest.fixture
def maker() -> FakeMaker:
    return FakeMaker()


@pytest.fixture
def cache(tmp_path: Path) -> RenderCache:
    return RenderCache(tmp_path / "cache")
