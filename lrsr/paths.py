"""Where are things, whether lrsr runs from a wheel or from a checkout, and from any folder?"""

import os
from pathlib import Path

from lrsr.errors import InputError

PACKAGE = Path(__file__).resolve().parent


def config_folder() -> Path:
    """Return the absolute folder of the Hydra configuration: in the wheel, else in the checkout.

    Raises:
        InputError: Neither exists; the installation is broken.
    """
    for folder in (PACKAGE / "conf", PACKAGE.parent / "conf"):
        if (folder / "demo.yaml").is_file():
            return folder
    raise InputError(f"no configuration beside {PACKAGE}: reinstall lrsr")


def asset(name: str) -> Path:
    """Return the path of a file that ships with the package, e.g. ``weights/srcnn2x.onnx``.

    Raises:
        InputError: The package has no such file.
    """
    path = PACKAGE / "assets" / name
    if not path.is_file():
        raise InputError(f"{path} is missing: reinstall lrsr")
    return path


def cache_folder() -> Path:
    """Return the folder of the render cache: ``$LRSR_CACHE``, else the user's cache folder."""
    if given := os.environ.get("LRSR_CACHE"):
        return Path(given).expanduser().resolve()
    base = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return Path(base).expanduser() / "lrsr"
