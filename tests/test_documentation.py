"""The site is built from the guide and the docstrings, every warning an error."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_the_site_builds_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "sphinx", "-W", "-q", "-b", "html", ROOT / "docs", tmp_path]
    subprocess.run(command, check=True)
    assert (tmp_path / "api" / "lrsr.evaluation.delong.html").is_file()
    assert "estimate_auc" in (tmp_path / "api" / "lrsr.evaluation.delong.html").read_text()
