"""Where are things, whether lrsr runs from a wheel or from a checkout, and from any folder?"""

import os
import tempfile
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


def path_if_any(text: object, name: str) -> Path | None:
    """Return the absolute path that a user wrote; None where null was written.

    Raises:
        InputError: See :func:`user_path`.
    """
    return None if text is None else user_path(text, name)


def user_path(text: object, name: str = "path") -> Path:
    """Return the absolute path that a user wrote, ``~`` and ``~name`` expanded.

    Raises:
        InputError: It is no word, empty or a loop of links, or there is no such home folder.
    """
    if isinstance(text, bool) or not isinstance(text, str | int | Path):
        raise InputError(f"{name}={text}: wanted a path")
    if not str(text).strip():
        raise InputError(f"{name}: a path is empty; write . for this folder")
    try:
        return Path(str(text)).expanduser().resolve()
    except (OSError, RuntimeError) as error:
        raise InputError(f"{text}: {error}; write the whole path") from error


def cache_folder() -> Path:
    """Return the folder of the render cache: ``$LRSR_CACHE``, else the user's cache folder.

    Whoever has none that could be made gets a folder of their own among the temporary ones.

    Raises:
        InputError: ``$LRSR_CACHE`` is in a home folder that does not exist.
    """
    return _own_folder("LRSR_CACHE", "XDG_CACHE_HOME", "~/.cache")


def models_folder() -> Path:
    """Return the folder of other people's networks: ``$LRSR_MODELS``, else among the user's data.

    Raises:
        InputError: See :func:`cache_folder`.
    """
    return _own_folder("LRSR_MODELS", "XDG_DATA_HOME", "~/.local/share", "models")


def _own_folder(variable: str, above: str, otherwise: str, below: str = "") -> Path:
    if (given := os.environ.get(variable, "")).strip():
        return user_path(given)
    base = os.environ.get(above, "")
    if not Path(base).is_absolute():  # as its specification wants it
        base = otherwise
    try:
        folder = Path(base).expanduser() / "lrsr" / below
    except RuntimeError:  # neither HOME nor an entry among the users
        return _scratch_folder() / below
    return folder if _exists_or_can(folder) else _scratch_folder() / below


def _scratch_folder() -> Path:
    """Return a folder of the user's own, made if need be, among the temporary files.

    Raises:
        InputError: It cannot be made, or is somebody else's.
    """
    folder = Path(tempfile.gettempdir()) / f"lrsr-{os.getuid()}"
    try:
        folder.mkdir(mode=0o700, exist_ok=True)
        mine = folder.lstat().st_uid == os.getuid() and not folder.is_symlink()
    except OSError as error:
        raise InputError(
            f"cannot make folder {folder}: {error.strerror}; set LRSR_CACHE"
        ) from error
    if not mine:
        raise InputError(f"{folder} is somebody else's: set LRSR_CACHE to a folder of your own")
    return folder


def prepare_home() -> None:
    """Give libraries that keep something at home another place where there is no home to write."""
    if not _exists_or_can(Path(os.environ.get("HOME") or "/nowhere") / ".config"):
        os.environ.setdefault("MPLCONFIGDIR", str(_scratch_folder()))


def _exists_or_can(folder: Path) -> bool:
    """Tell whether a folder is there, even if only to be read, or could be made."""
    try:
        if folder.is_dir():
            return True
        above = next(path for path in folder.parents if path.exists())
        return above.is_dir() and os.access(above, os.W_OK | os.X_OK)
    except OSError:
        return False
