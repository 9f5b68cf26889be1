"""A process of its own: only that can be killed, or hold a folder against this one.

It begins as a fork of a server that has PyTorch and Lightning loaded, and has started nothing.
"""

import os
import sys
from collections.abc import Callable
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path

_SERVER = get_context("forkserver")
_SERVER.set_forkserver_preload(["lrsr.camera.camera", "lrsr.training.run"])


def begin(told: Path, work: Callable[..., int | None], *words: object) -> BaseProcess:
    """Begin some work; what it returns is the status of the process.

    Args:
        told: The folder for what it writes to its standard streams, as files out and err.
        work: A function that another process can import.
        words: What it is given.
    """
    told.mkdir(exist_ok=True)
    process = _SERVER.Process(target=_do, args=(told, work, words), daemon=True)
    process.start()
    return process


def _do(told: Path, work: Callable[..., int | None], words: tuple[object, ...]) -> None:
    for number, name in ((1, "out"), (2, "err")):
        os.dup2(os.open(told / name, os.O_WRONLY | os.O_CREAT), number)
    sys.exit(work(*words))
