"""One live scene for all tests of this folder."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fakes.scenes import Studio
from oracles.heads import stand_in

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
    target = tmp_path_factory.mktemp("traced") / "seen.npz"
    environment = {**os.environ, "LRSR_VARIANT": "llvm_ad_spectral"}
    environment["PYTHONPATH"] = str(Path(__file__).parents[1])
    command = [sys.executable, "-m", "oracles.spectral", str(target)]
    subprocess.run(command, check=True, env=environment)
    return dict(np.load(target))
