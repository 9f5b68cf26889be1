"""One live scene for all tests of this folder."""

import pytest
from oracles.heads import stand_in

from lrsr.identities.head import Head
from lrsr.rendering.backend import start
from lrsr.rendering.renderer import Renderer


@pytest.fixture
def head() -> Head:
    return stand_in()


@pytest.fixture(scope="session")
def renderer(tmp_path_factory: pytest.TempPathFactory) -> Renderer:
    """Return one renderer for all: every further live scene makes every kernel longer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LRSR_CACHE", str(tmp_path_factory.mktemp("cache")))
        start()
    return Renderer()
