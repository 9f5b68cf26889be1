"""A process of its own: only that can be killed, or hold a folder against this one.

It begins as a fork of a server that has PyTorch and Lightning loaded, and has started nothing.
"""

import os
import runpy
import sys
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import NamedTuple

_SERVER = get_context("forkserver")
_SERVER.set_forkserver_preload(["lrsr.camera.camera", "lrsr.training.run"])


class Ended(NamedTuple):
    """What a process that has ended said."""

    status: int | None
    out: str
    err: str


def begin(
    told: Path, work: Callable[..., int | None], *words: object, daemon: bool = True
) -> BaseProcess:
    """Begin some work; what it returns is the status of the process.

    Args:
        told: The folder for what it writes to its standard streams, as files out and err.
        work: A function that another process can import.
        words: What it is given.
        daemon: Is it killed with this process? It may start no others then, but by ``os.fork``.
    """
    told.mkdir(exist_ok=True)
    process = _SERVER.Process(target=_do, args=(told, work, words), daemon=daemon)
    process.start()
    return process


def finish(told: Path, work: Callable[..., int | None], *words: object) -> Ended:
    """Do some work, which may start processes of its own, to its end."""
    process = begin(told, work, *words, daemon=False)
    process.join()
    return Ended(process.exitcode, (told / "out").read_text(), (told / "err").read_text())


def run_script(script: str, *words: str) -> None:
    """Work as ``python -c`` would, with words in ``sys.argv``."""
    sys.argv[1:] = words
    exec(compile(script, "<script>", "exec"), {"__name__": "__main__"})


def run_module(name: str, *words: str, **environment: str) -> None:
    """Work as ``python -m`` would."""
    os.environ |= environment
    sys.argv[1:] = words
    runpy.run_module(name, run_name="__main__")


def _do(told: Path, work: Callable[..., int | None], words: tuple[object, ...]) -> None:
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(told / name, os.O_WRONLY | os.O_CREAT), number)
    sys.exit(work(*words))
