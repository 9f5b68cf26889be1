"""What made this result? Every run folder says: configuration, seed, versions, git hash."""

import os
import platform
import subprocess
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING

from lrsr import __version__
from lrsr.files import write_json, write_text
from lrsr.paths import PACKAGE

if TYPE_CHECKING:
    from omegaconf import DictConfig

_RECORDED = (
    "drjit",
    "hydra-core",
    "kornia",
    "lightning",
    "mitsuba",
    "numpy",
    "onnxruntime",
    "opencv-contrib-python-headless",
    "scikit-image",
    "scikit-learn",
    "scipy",
    "torch",
)
"""Distributions whose version can change a number."""


def versions() -> dict[str, str]:
    """Return the versions of lrsr, Python and the libraries, and the commit of a checkout."""
    found = {"lrsr": __version__, "git": _git_hash(), "python": platform.python_version()}
    found |= {name: _version(name) for name in _RECORDED}
    return found


def _version(distribution: str) -> str:
    try:
        return metadata.version(distribution)
    except metadata.PackageNotFoundError:  # the same library under another name, such as conda's
        return "unknown"


def _git_hash() -> str:
    """Return the commit of the checkout (with "+" if it is changed), "installed" or "unknown"."""
    if not (PACKAGE.parent / ".git").exists():
        return "installed"
    try:
        commit = _git("rev-parse", "--short=12", "HEAD")
        return commit + ("+" if _git("status", "--porcelain", "--", "lrsr", "conf") else "")
    except (OSError, subprocess.SubprocessError):
        return "unknown"


def write_provenance(folder: Path, config: "DictConfig") -> None:
    """Write ``config.yaml`` (resolved) and ``versions.json`` into a run folder.

    Raises:
        InputError: The folder cannot be written.
    """
    from omegaconf import OmegaConf  # Hydra is loaded by the time of a run

    write_text(folder / "config.yaml", OmegaConf.to_yaml(config, resolve=True))
    write_json(folder / "versions.json", versions())


def _git(*words: str) -> str:
    command = ["git", "--no-optional-locks", "-C", str(PACKAGE.parent), *words]
    # A hook's variables would name another repository.
    environment = {name: v for name, v in os.environ.items() if not name.startswith("GIT_")}
    return subprocess.run(
        command, capture_output=True, check=True, text=True, timeout=3, env=environment
    ).stdout.strip()
