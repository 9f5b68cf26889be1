"""One live scene for all tests of this folder."""

import os
from functools import partial

import numpy as np
import pytest
from fakes.elsewhere import finish, run_module
from fakes.scenes import Studio
from oracles.heads import stand_in

from lrsr.files import locked
from lrsr.identities.head import Head
from lrsr.rendering.backend import _start


@pytest.fixture
def head() -> Head:
    return stand_in()


@pytest.fixture(scope="session")
def renderer(tmp_path_factory: pytest.TempPathFactory) -> Studio:
    """Return one renderer for all: every further live scene makes every kernel longer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LRSR_CACHE", str(tmp_path_factory.mktemp("cache")))
        _start()
    return Studio()


@pytest.fixture(scope="session")
def traced(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """Return what a variant that traces wavelengths shows; see ``oracles/spectral.py``."""
    return shown_by("llvm_ad_spectral", "oracles.spectral", tmp_path_factory)


@pytest.fixture(scope="session")
def slow(tmp_path_factory: pytest.TempPathFactory) -> dict[str, np.ndarray]:
    """Return what the variant without any compiler shows; see ``oracles/scalar.py``."""
    return shown_by("scalar_rgb", "oracles.scalar", tmp_path_factory)


def shown_by(
    variant: str, name: str, tmp_path_factory: pytest.TempPathFactory
) -> dict[str, np.ndarray]:
    """Run an oracle in a process of its own, as a variant wants it, once for all workers."""
    folder = tmp_path_factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        folder = folder.parent
    target = folder / f"{variant}.npz"
    with locked(folder):
        if not target.is_file():
            oracle = partial(run_module, LRSR_VARIANT=variant)
            ended = finish(folder / variant, oracle, name, str(target))
            assert ended.status == 0, ended.err
    return dict(np.load(target))
