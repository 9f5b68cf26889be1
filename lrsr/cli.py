"""What does ``lrsr COMMAND [key=value ...]`` do, and how does it end?

Exit status: 0 done, 2 the user's input was wrong or the machine refuses (one line on stderr), 1 a
fault of ours, 130 interrupted, 143 told to stop (SIGTERM). ``--debug`` anywhere on the line shows
the traceback instead of the line.

A camera's file may come from anybody and is checked. What else Hydra takes from the line, such as
``--config-dir``, ``--config-path`` (absolute) or ``hydra.*``, can run anything, as its user can.
"""

import importlib
import logging
import os
import re
import signal
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from difflib import get_close_matches
from io import TextIOWrapper
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import TYPE_CHECKING, Any, Never, TextIO

from lrsr import __version__
from lrsr.errors import InputError
from lrsr.failures import explain
from lrsr.overrides import Overrides, pieces_of
from lrsr.paths import config_folder, prepare_home, user_path

if TYPE_CHECKING:
    from omegaconf import DictConfig


@dataclass(frozen=True)
class Command:
    """One word after ``lrsr``.

    Attributes:
        does: One line for the help page.
        task: ``module:function`` that takes the composed configuration and returns a folder.
    """

    does: str
    task: str


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
Values need no quotes but the shell's: out='my probes (1)'. With --multirun a comma parts values.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command and return its exit status.

    Args:
        argv: The words after ``lrsr``; ``sys.argv[1:]`` when None.
    """
    if argv is None:
        _open_streams()
    words = list(sys.argv[1:] if argv is None else argv)
    debug = "--debug" in words
    words = [word for word in words if word != "--debug"]
    with _signals() as received:
        try:
            return _ended(words, debug)
        except KeyboardInterrupt:
            number = received[0] if received else signal.SIGINT
            verb = "interrupted" if number == signal.SIGINT else "stopped"
            _tell(f"{verb}; run the same command again to go on")
            return 128 + number
        finally:
            try:
                sys.stdout.flush()
            except (OSError, ValueError):
                _give_up(sys.stdout)


def _ended(words: list[str], debug: bool) -> int:
    try:
        _run_or_help(words)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader of a pipe, such as `head`, has had enough
        _give_up(sys.stdout)
        return 141
    except SystemExit as stop:  # argparse, inside Hydra
        return stop.code if isinstance(stop.code, int) else 2
    except Exception as error:
        if debug:
            raise
        status, lines = explain(error, words)
        _tell(*lines)
        return status
    return 0


def _run_or_help(words: list[str]) -> None:
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    if {"-V", "--version"} & set(words):
        sys.stdout.write(f"lrsr {__version__}\n")
    elif not words or words[0] in {"-h", "--help"}:
        sys.stdout.write(USAGE)
    else:
        logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
        _run(words[0], words[1:])


def _run(name: str, words: list[str]) -> None:
    if name not in COMMANDS:
        near = get_close_matches(name, COMMANDS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"choose one of {', '.join(COMMANDS)}"
        raise InputError(f"no command {name!r}: {hint}")
    _check_working_folder()
    prepare_home()
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors reach `main`, which says them in one line
    from hydra import version  # a quarter of a second that `lrsr --help` need not pay
    from hydra._internal.utils import _run_hydra, get_args_parser

    parser = get_args_parser()
    parser.error = _refuse_option  # type: ignore[method-assign]
    args = parser.parse_intermixed_args(words)
    asked = [option for option in ("cfg", "info", "multirun", "run") if getattr(args, option)]
    if len(asked) > 1:
        _refuse_option(f"--{asked[0]} and --{asked[1]} exclude each other")
    if args.experimental_rerun or (args.resolve and not (args.cfg or args.help)):
        _refuse_option("--experimental-rerun is not for lrsr, and --resolve goes with --cfg")
    version.setbase("1.3")
    failures: list[Exception] = []
    with _mended(args, name) as overrides:
        args.overrides = overrides
        _run_hydra(
            args=args,
            args_parser=parser,
            task_function=_task(COMMANDS[name].task, failures),
            config_path=args.config_path,
            config_name=name,
        )
    if len(failures) == 1:
        raise failures[0]
    if failures:
        raise ExceptionGroup("several runs failed", failures)


def _refuse_option(message: str) -> Never:
    raise InputError(f"{message}: settings are written key=value; lrsr COMMAND --help lists them")


def _check_working_folder() -> None:
    try:
        Path.cwd()
    except FileNotFoundError:
        raise InputError("the working folder was removed: go to another one") from None


@contextmanager
def _mended(args: Any, name: str) -> Iterator[list[str]]:
    """Give the overrides as Hydra reads what was meant, and it a folder for what it writes.

    That is multirun.yaml and an empty folder for each job: the runs' own say more.

    Raises:
        InputError: A word cannot be read, or a folder or a camera's file does not exist.
    """
    main = args.config_path = _given_folder("config-path", args.config_path) or str(config_folder())
    extra = args.config_dir = _given_folder("config-dir", args.config_dir)
    sweep = args.multirun or "hydra.mode=MULTIRUN" in args.overrides
    folders = [Path(folder) for folder in (main, extra) if folder]
    if not sweep and not any(map(_CAMERA.match, args.overrides)):
        yield Overrides(args.config_name or name, folders).mended(args.overrides)
        return
    with TemporaryDirectory() as scratch:
        words = [_with_given_cameras(word, Path(scratch), sweep) for word in args.overrides]
        overrides = Overrides(args.config_name or name, [*folders, Path(scratch)], sweep)
        ours = [f'hydra.sweep.dir="{scratch}"', f'hydra.searchpath=["file://{scratch}"]']
        yield [*ours, *overrides.mended(words)]


def _given_folder(option: str, text: str | None) -> str | None:
    if text is None:
        return None
    path = user_path(text)
    if not path.is_dir():
        raise InputError(f"--{option} {text}: no such folder")
    return str(path)


_CAMERA = re.compile(r"(\+{0,2}camera=)(.*)", re.DOTALL)


def _with_given_cameras(word: str, scratch: Path, sweep: bool) -> str:
    """Let ``camera=PATH.yaml`` name a file: it becomes an option of the group for this run."""
    found = _CAMERA.fullmatch(word)
    if found is None:
        return word
    pieces = [_given_camera(piece, scratch) for piece in pieces_of(found[2], sweep)]
    return found[1] + ",".join(pieces)


def _given_camera(text: str, scratch: Path) -> str:
    """Return the option for a file; a preset's name is returned as it is.

    Raises:
        InputError: There is no such file, or it is no camera.
    """
    text = text[1:-1] if text[:1] in {'"', "'"} and text[-1:] == text[:1] else text
    if os.sep not in text and not text.lower().endswith((".yaml", ".yml")):
        return text
    from omegaconf import OmegaConf  # and what it needs only for such a file

    from lrsr.camera.preset_file import read_preset_file

    settings = read_preset_file(user_path(text))
    folder = scratch / "camera"
    folder.mkdir(exist_ok=True)
    option = f"given_file_{len(list(folder.iterdir()))}"  # no shipped preset's name
    content = OmegaConf.to_yaml(OmegaConf.create(settings))
    (folder / f"{option}.yaml").write_text(content, encoding="utf-8")
    return option


def _task(path: str, failures: list[Exception]) -> "Callable[[DictConfig], None]":
    """Wrap a task for Hydra, which would print a line of its own about what it lets through.

    In a multirun the jobs after a failed one are still done.
    """
    module, function = path.split(":")

    def run(config: "DictConfig") -> None:
        try:
            task: Callable[[DictConfig], Path] = getattr(importlib.import_module(module), function)
            _say(task(config))
        except Exception as error:
            failures.append(error)

    return run


def _say(folder: Path) -> None:
    """Print where the result is; if nobody can read that, the work is done all the same."""
    try:
        sys.stdout.write(f"{folder}\n")
        sys.stdout.flush()
    except (OSError, ValueError) as error:  # a full disk, no reader, or letters it cannot show
        _give_up(sys.stdout)
        _tell(f"done: {folder} (standard output: {error})")


def _tell(*lines: str) -> None:
    with suppress(OSError, ValueError):
        sys.stderr.write("".join(f"lrsr: {line}\n" for line in lines))
        sys.stderr.flush()


def _give_up(stream: TextIO) -> None:
    """Send what is still written there to nowhere, so that Python's exit does not fail on it."""
    with suppress(OSError, ValueError):
        os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())


def _open_streams() -> None:
    """Open closed standard streams, whose numbers data files would get; let all show any letter."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w" if number else "r", closefd=False))
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


@contextmanager
def _signals() -> Iterator[list[int]]:
    """Let SIGTERM end the work as Ctrl-C does, everything tidied up; give what was received."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)
        raise KeyboardInterrupt

    numbers = (signal.SIGINT, signal.SIGTERM)
    before = {number: signal.getsignal(number) for number in numbers}
    before = {k: old for k, old in before.items() if old not in {None, signal.SIG_IGN}}
    if threading.current_thread() is not threading.main_thread():
        before = {}
    for number in before:
        signal.signal(number, stop)
    try:
        yield received
    finally:
        for number, old in before.items():
            signal.signal(number, old)
