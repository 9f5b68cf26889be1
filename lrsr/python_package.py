"""How is a file had that a Python package carries? pip downloads it; nothing of it is run.

pip asks a source distribution for its name and version by running its ``setup.py``. What it runs
here instead is a build backend (PEP 517) of ten lines, under the name of the usual one, that
answers with what was asked for. That the archive is the known one pip checks before, by its sha256.
"""

import importlib.util
import logging
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from lrsr.errors import InputError
from lrsr.files import make_folder

logger = logging.getLogger(__name__)

_BACKEND = """
import os, pathlib

class __legacy__:
    def get_requires_for_build_wheel(config_settings=None):
        return []

    def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
        name, version = os.environ["LRSR_PACKAGE"].split("==")
        folder = pathlib.Path(metadata_directory, f"{name}-{version}.dist-info")
        folder.mkdir()
        text = f"Metadata-Version: 2.1\\nName: {name}\\nVersion: {version}\\n"
        (folder / "METADATA").write_text(text)
        return folder.name

get_requires_for_build_wheel = __legacy__.get_requires_for_build_wheel
prepare_metadata_for_build_wheel = __legacy__.prepare_metadata_for_build_wheel
"""


def download_package(package: str, folder: Path, *, sha256: str, timeout_s: float = 3600) -> Path:
    """Download a package, without what it depends on, from wherever pip is set up to look.

    Args:
        package: ``NAME==VERSION``, exactly.
        folder: Where its archive is to lie.
        sha256: Of the archive, wheel or source distribution.
        timeout_s: Until pip is stopped, seconds.

    Returns:
        The archive.

    Raises:
        InputError: There is no pip, or it cannot get that archive; the message holds its reason.
    """
    if importlib.util.find_spec("pip") is None:
        raise InputError(f"{package}: this Python has no pip; python -m ensurepip makes one")
    make_folder(folder)
    with tempfile.TemporaryDirectory() as scratch:
        place = Path(scratch)
        (place / "setuptools").mkdir()
        (place / "setuptools" / "__init__.py").touch()
        (place / "setuptools" / "build_meta.py").write_text(_BACKEND, encoding="utf-8")
        (place / "wanted.txt").write_text(f"{package} --hash=sha256:{sha256}\n", encoding="utf-8")
        command = [sys.executable, "-m", "pip", "download", "--no-deps", "--no-input"]
        command += ["--use-pep517", "--no-build-isolation", "--disable-pip-version-check"]
        command += ["--require-hashes", "--dest", scratch, "--requirement", f"{place}/wanted.txt"]
        known = {**os.environ, "PYTHONPATH": scratch, "LRSR_PACKAGE": package}
        logger.info("pip downloads %s", package)
        try:
            done = subprocess.run(
                command, env=known, capture_output=True, text=True, timeout=timeout_s, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise InputError(f"{package}: pip took over {timeout_s:g} s; try again") from error
        archives = [path for path in place.iterdir() if path.is_file() and path.suffix != ".txt"]
        if done.returncode or len(archives) != 1:
            said = [line for line in done.stderr.splitlines() if line.startswith("ERROR")]
            why = (said or done.stderr.splitlines() or ["nothing came"])[-1].strip()
            raise InputError(f"{package}: pip cannot download it ({why[:200]})")
        target = folder / archives[0].name
        shutil.move(archives[0], target)
        return target
