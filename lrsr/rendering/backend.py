"""Which Mitsuba variant renders here, and why?

``cuda_ad_rgb`` where a GPU renders, else ``llvm_ad_rgb`` with an LLVM that works, else
``scalar_rgb``; variants that trace wavelengths instead of channels only where ``$LRSR_VARIANT``
names one. An old LLVM (14, 15) makes Dr.Jit abort the whole process, so every candidate renders in
a child process first; the verdict is kept on disk, so that this costs seconds only once.
"""

import ctypes
import hashlib
import json
import logging
import os
import re
import subprocess
import sys
import sysconfig
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

from lrsr.errors import InputError
from lrsr.files import read_bytes, write_json
from lrsr.paths import cache_folder

logger = logging.getLogger(__name__)

_LOCK = threading.RLock()
if hasattr(os, "register_at_fork"):  # no child is born with the lock held by a thread it lacks
    os.register_at_fork(
        before=_LOCK.acquire, after_in_parent=_LOCK.release, after_in_child=_LOCK.release
    )

_VARIANTS = ("cuda_ad_rgb", "llvm_ad_rgb", "scalar_rgb", "cuda_ad_spectral", "llvm_ad_spectral")
_GIVEN_UP: set[tuple[str, int]] = set()
"""What took too long, and in which process."""
_PROBE_SECONDS = 120
"""A candidate that has not rendered a triangle by then counts as broken."""

_TIMED_OUT = f"no answer in {_PROBE_SECONDS} s"

_SYSTEM_FOLDERS = ("/usr/lib", "/usr/lib64", "/usr/local/lib", "/opt/homebrew/opt/llvm/lib")

_PROBE = """
import sys
try:
    import resource
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))  # an abort is an answer, not a crash to keep
except (ImportError, ValueError):
    pass
import mitsuba as mi
mi.set_variant(sys.argv[1])
scene = mi.load_dict({"type": "scene", "light": {"type": "constant"}, "ball": {"type": "sphere"},
    "integrator": {"type": "path", "max_depth": 2},
    "sensor": {"type": "perspective", "to_world": mi.ScalarTransform4f().look_at(
        origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0]),
        "film": {"type": "hdrfilm", "width": 4, "height": 4}}})
image = mi.render(scene, spp=4)
mean = float(image.array[0])
if not 0 < mean < 10:
    sys.exit(f"rendered {mean}")
"""


@dataclass(frozen=True)
class _Backend:
    """What renders.

    Attributes:
        variant: Of Mitsuba.
        reason: Why this one, in one line.
        llvm: Path of the LLVM library that Dr.Jit is to load; None: not needed, or its own search.
    """

    variant: str
    reason: str
    llvm: Path | None = None


def choose_variant(candidates: Sequence[Path] | None = None) -> _Backend:
    """Choose the fastest variant that works on this machine; ``$LRSR_VARIANT`` overrides it.

    Args:
        candidates: LLVM libraries to try, in that order; None: ``_find_llvm``.

    Raises:
        InputError: ``$LRSR_VARIANT`` is unknown, or cannot run here.
    """
    wanted = os.environ.get("LRSR_VARIANT")
    if wanted and wanted not in _VARIANTS:
        raise InputError(
            f"LRSR_VARIANT={wanted}: choose one of {', '.join(_VARIANTS)}, or unset it"
        )
    said = f"LRSR_VARIANT={wanted}" if wanted else None
    if wanted == "scalar_rgb":
        return _Backend("scalar_rgb", f"{said} (slow)")
    tried = []
    traced = "spectral" if wanted and wanted.endswith("spectral") else "rgb"
    cuda, llvm = f"cuda_ad_{traced}", f"llvm_ad_{traced}"
    if wanted in (None, cuda):
        if (driver := _cuda_driver()) and not (fault := _probe(cuda, None, driver)):
            return _Backend(cuda, said or "a CUDA device renders")
        tried.append(f"CUDA: {fault if driver else 'no driver'}")
    if wanted in (None, llvm):
        for library in _find_llvm() if candidates is None else candidates:
            if not (fault := _probe(llvm, library, _stamp(library))):
                return _Backend(llvm, said or f"{library} renders", library)
            tried.append(f"{library}: {fault}")
    faults = "; ".join(tried) or "no LLVM found"
    if wanted:
        raise InputError(f"LRSR_VARIANT={wanted} does not work here ({faults}); unset it")
    return _Backend("scalar_rgb", f"{faults}; slow: pip install karellen-llvm-core")


def _find_llvm() -> list[Path]:
    """List the LLVM libraries worth trying, best first, each file once.

    ``$DRJIT_LIBLLVM_PATH``; what pip installed into this environment (karellen-llvm-core) or one
    whose packages it uses; the system's, newest first.
    """
    found: list[Path] = []
    if given := os.environ.get("DRJIT_LIBLLVM_PATH"):
        found.append(Path(given))
    packages = [Path(place) for place in (sysconfig.get_paths()["purelib"], *sys.path)]
    beside = [place.parent.parent for place in packages if place.name.endswith("-packages")]
    for folder in dict.fromkeys([Path(sys.prefix) / "lib", *beside]):
        found += _newest_first(_libraries(folder))
    system = [path for name in _SYSTEM_FOLDERS for path in _libraries(Path(name))]
    found += _newest_first(system)
    unique = {path.resolve(): path for path in reversed(found) if path.exists()}
    return [path for path in found if unique.get(path.resolve()) is path]


@contextmanager
def alone() -> Iterator[None]:
    """Let one thread at a time use Mitsuba; decorates a function, too.

    The first import and a live scene are not for two. All cores trace each picture anyway.

    Raises:
        InputError: Mitsuba was started before this process was forked: its threads are gone.
    """
    with _LOCK:
        if _begin.cache_info().currsize and _begin()[1] != os.getpid():
            raise InputError(
                f"process {os.getpid()} was forked after its parent had started Mitsuba, which does"
                " not survive that: start it by multiprocessing's 'spawn' or 'forkserver'"
            )
        yield


@alone()
def _start() -> Any:
    """Import Mitsuba with the chosen variant set, say once which and why, and return the module.

    Raises:
        InputError: ``$LRSR_VARIANT`` cannot be met, or see :func:`alone`.
    """
    return _begin()[0]


class _Woken:
    """A module that is imported when it is first asked for something."""

    def __init__(self, name: str) -> None:
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Look it up once; the variant, and with it Mitsuba's classes, stays.

        Raises:
            AttributeError: There is no such attribute.
        """
        if name.startswith("__"):  # of those who look at this object, as doctests do
            raise AttributeError(name)
        _start()
        value = getattr(sys.modules[self._name], name)
        setattr(self, name, value)
        return value


mi: Any = _Woken("mitsuba")
dr: Any = _Woken("drjit")


@cache
def _begin() -> tuple[Any, int]:
    """Return the module and the process that started it."""
    backend = choose_variant()
    if backend.llvm is not None:
        os.environ["DRJIT_LIBLLVM_PATH"] = str(backend.llvm)
    import mitsuba

    mitsuba.set_variant(backend.variant)
    level = logging.WARNING if backend.variant == "scalar_rgb" else logging.INFO
    logger.log(level, "rendering with %s: %s", backend.variant, backend.reason)
    return mitsuba, os.getpid()


def _libraries(folder: Path) -> Iterator[Path]:
    """Yield shared LLVM libraries in ``folder``, its llvm-* folders and its multiarch folders."""
    for pattern in ("libLLVM*", "llvm-*/lib/libLLVM*", "*-linux-gnu/libLLVM*", "llvm*/libLLVM*"):
        for path in folder.glob(pattern):
            if re.fullmatch(r"libLLVM(-\d+)?(\.\d+)*\.(so(\.\d+)*|dylib)(\.\d+)?", path.name):
                yield path


def _newest_first(libraries: Iterator[Path] | list[Path]) -> list[Path]:
    def release(path: Path) -> tuple[int, ...]:
        numbers = re.findall(r"\d+", f"{path.resolve().parent.parent.name} {path.resolve().name}")
        return tuple(int(number) for number in numbers)[-3:]

    return sorted(libraries, key=lambda path: (release(path), path.name), reverse=True)


def _cuda_driver() -> str | None:
    """Return the CUDA driver's version without waking the device (a fork must stay possible)."""
    name = "nvcuda.dll" if sys.platform == "win32" else "libcuda.so.1"
    try:
        library = ctypes.CDLL(name)
    except OSError:
        return None
    number = ctypes.c_int()
    return str(number.value) if library.cuDriverGetVersion(ctypes.byref(number)) == 0 else None


def _stamp(library: Path) -> str:
    try:
        status = library.resolve().stat()
    except OSError:
        return "absent"
    return f"{library.resolve()} {status.st_mtime_ns} {status.st_size}"


def _probe(variant: str, library: Path | None, stamp: str) -> str:
    """Return why ``variant`` does not work with ``library``; "" if it does. Remembered on disk."""
    versions = [version("mitsuba"), version("drjit"), _PROBE]
    key = hashlib.sha256("\n".join([variant, stamp, *versions]).encode()).hexdigest()[:16]
    record = cache_folder() / "backend" / f"{key}.json"
    if (key, os.getpid()) in _GIVEN_UP:
        return _TIMED_OUT
    try:
        return str(json.loads(read_bytes(record))["fault"])
    except (OSError, ValueError, KeyError, TypeError):
        pass
    fault = _run_probe(variant, library)
    if fault == _TIMED_OUT:  # a busy machine says nothing about the library
        _GIVEN_UP.add((key, os.getpid()))  # but a process keeps to one variant: it names pictures
        return fault
    try:
        write_json(record, {"variant": variant, "stamp": stamp, "fault": fault})
    except InputError as error:
        logger.debug("the verdict is not kept: %s", error)
    return fault


def _run_probe(variant: str, library: Path | None) -> str:
    environment = dict(os.environ)
    if library is not None:
        environment["DRJIT_LIBLLVM_PATH"] = str(library)
    try:
        child = subprocess.run(
            [sys.executable, "-c", _PROBE, variant],
            env=environment,
            capture_output=True,
            text=True,
            timeout=_PROBE_SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        return _TIMED_OUT
    if child.returncode == 0:
        return ""
    words = (child.stderr or child.stdout).strip().splitlines()
    last = words[-1].strip()[:200] if words else ""
    return f"status {child.returncode}{': ' + last if last else ''}"
