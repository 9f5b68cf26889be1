"""What does ``lrsr COMMAND [key=value ...]`` do, and how does it end?

Exit status: 0 done, 2 the user's input was wrong (one line on stderr), 1 a fault of ours, 130
interrupted. ``--debug`` anywhere on the line shows the traceback instead of the line.
"""

import importlib
import logging
import os
import re
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from lrsr import __version__
from lrsr.errors import InputError
from lrsr.paths import config_folder

if TYPE_CHECKING:
    from omegaconf import DictConfig


@dataclass(frozen=True)
class Command:
    """One word after ``lrsr``.

    Attributes:
        does: One line for the help page.
        task: ``module:function`` that takes the composed configuration; None: a later version.
    """

    does: str
    task: str | None = None


COMMANDS = {
    "demo": Command("the whole story in minutes, into one report.html", "lrsr.tasks:run_demo"),
    "render": Command("probes, references and gallery into a folder", "lrsr.tasks:run_render"),
    "train": Command("sr=srcnn2x|srcnn4x or recognition=arcface", "lrsr.tasks:run_train"),
    "eval": Command("an experiment: results.json, report.html", "lrsr.tasks:run_eval"),
    "identities": Command(
        "contact sheet, who they are, uniqueness check", "lrsr.tasks:run_identities"
    ),
    "fit-camera": Command(
        "a camera preset from real pictures in images=DIR", "lrsr.tasks:run_fit_camera"
    ),
    "models": Command("list, verify and pull weights (not in this version)"),
}

USAGE = f"""lrsr {__version__}: what can still be recognised in a face ten pixels wide?

usage: lrsr COMMAND [key=value ...] [--cfg job] [--multirun] [--help] [--debug]

commands:
{chr(10).join(f"  {name:<11} {command.does}" for name, command in COMMANDS.items())}

examples:
  lrsr demo
  lrsr eval experiment=super_resolution identities.count=200 options=[1,4]
  lrsr render identities.count=3 pose=left lighting=above ipd_px=8 out=probes
  lrsr train sr=srcnn4x identities.count=300
  lrsr identities identities.count=1500 identities.sex=female
  lrsr fit-camera images=probes name=lobby
  lrsr render camera=runs/fit-camera/.../lobby.yaml out=probes

lrsr COMMAND --help lists what can be overridden; lrsr COMMAND --cfg job prints the configuration.
"""

logger = logging.getLogger(__name__)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    Args:
        argv: The words after ``lrsr``; ``sys.argv[1:]`` when None.
    """
    words = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    if not words or words[0] in {"-h", "--help"}:
        sys.stdout.write(USAGE)
        return 0
    if words[0] in {"-V", "--version"}:
        sys.stdout.write(f"lrsr {__version__}\n")
        return 0
    logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
    try:
        _run(words[0], words[1:])
    except KeyboardInterrupt:
        sys.stderr.write("lrsr: interrupted; run the same command again to go on\n")
        return 130
    except BrokenPipeError:  # the reader of a pipe, such as `head`, has had enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except SystemExit as stop:  # argparse, inside Hydra
        return stop.code if isinstance(stop.code, int) else 2
    except Exception as error:
        if debug:
            raise
        return _explain(error)
    return 0


def _run(name: str, overrides: list[str]) -> None:
    if name not in COMMANDS:
        near = get_close_matches(name, COMMANDS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"choose one of {', '.join(COMMANDS)}"
        raise InputError(f"no command {name!r}: {hint}")
    command = COMMANDS[name]
    if command.task is None:
        raise InputError(f"lrsr {name} is not in version {__version__}: it comes with a later one")
    folder = config_folder()
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors reach `main`, which says them in one line
    import hydra  # a quarter of a second that `lrsr --help` need not pay

    arguments = sys.argv
    sys.argv = [f"lrsr {name}", *overrides]
    failures: list[Exception] = []
    task = _task(command.task, failures)
    try:
        with _given_camera(overrides) as words:
            sys.argv[1:] = words
            hydra.main(version_base="1.3", config_path=str(folder), config_name=name)(task)()
    finally:
        sys.argv = arguments
    if failures:
        raise failures[0]


@contextmanager
def _given_camera(overrides: list[str]) -> Iterator[list[str]]:
    """Let ``camera=PATH.yaml`` name a file: it becomes an option of the group for this run.

    Raises:
        InputError: There is no such file, or it describes no camera.
    """
    paths = [word.removeprefix("camera=") for word in overrides if _CAMERA_FILE.fullmatch(word)]
    if not paths:
        yield overrides
        return
    from omegaconf import OmegaConf  # and what it needs only for such a file

    from lrsr.camera.preset_file import read_preset_file

    settings = read_preset_file(Path(paths[-1]).expanduser())
    with TemporaryDirectory() as folder:
        option = Path(folder) / "camera" / "given_file.yaml"  # no shipped preset's name
        option.parent.mkdir()
        option.write_text(OmegaConf.to_yaml(OmegaConf.create(settings)), encoding="utf-8")
        # In its place: Hydra's parser wants all overrides side by side.
        words = [_CAMERA_FILE.sub("camera=given_file", word) for word in overrides]
        yield [*words, "--config-dir", folder]


_CAMERA_FILE = re.compile(r"camera=.+\.ya?ml")


def _task(path: str, failures: list[Exception]) -> "Callable[[DictConfig], None]":
    """Wrap a task for Hydra, which would print a line of its own about what it lets through.

    In a multirun the jobs after a failed one are still done.
    """
    module, function = path.split(":")

    def run(config: "DictConfig") -> None:
        task: Callable[[DictConfig], Path] = getattr(importlib.import_module(module), function)
        try:
            sys.stdout.write(f"{task(config)}\n")
        except Exception as error:
            failures.append(error)

    return run


def _explain(error: BaseException) -> int:
    """Say what went wrong in one line on stderr; return 2 for the user's input, 1 for ours."""
    from hydra.errors import HydraException  # a quarter of a second, only on the way out
    from omegaconf.errors import (
        InterpolationToMissingValueError,
        MissingMandatoryValue,
        OmegaConfBaseException,
    )

    cause: BaseException | None = error
    while cause is not None and not isinstance(cause, InputError):
        cause = cause.__cause__
    if cause is not None:
        sys.stderr.write(f"lrsr: {_one_line(cause)}\n")
        return 2
    if isinstance(error, MissingMandatoryValue | InterpolationToMissingValueError):
        key = _one_line(error).rsplit(": ", maxsplit=1)[-1]
        sys.stderr.write(f"lrsr: {key} must be given: add {key}=...\n")
        return 2
    if isinstance(error, HydraException | OmegaConfBaseException):
        sys.stderr.write(f"lrsr: {_one_line(error)} (--cfg job prints every setting)\n")
        return 2
    sys.stderr.write(
        f"lrsr: a fault of ours: {type(error).__name__}: {_one_line(error)}"
        " (the same command with --debug shows where)\n"
    )
    return 1


def _one_line(error: BaseException) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    if "Config search path:" in lines:  # Hydra's own folders help nobody
        lines = lines[: lines.index("Config search path:")]
    return "; ".join(line for line in lines if not line.startswith(("full_key", "object_type")))
