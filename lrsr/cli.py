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
from contextlib import AbstractContextManager, contextmanager, nullcontext, suppress
from difflib import get_close_matches
from io import TextIOWrapper
from pathlib import Path
from tempfile import TemporaryDirectory
from types import FrameType
from typing import TYPE_CHECKING, Any, Never, TextIO, cast

from lrsr import __version__
from lrsr.errors import InputError
from lrsr.failures import explain
from lrsr.overrides import Overrides, pieces_of, quoted_word
from lrsr.paths import config_folder, prepare_home, user_path

if TYPE_CHECKING:
    from omegaconf import DictConfig

_COMMANDS = {
    "demo": "the whole story in minutes, into one report.html",
    "render": "probes, references and gallery into a folder",
    "train": "sr=srcnn4x|fsrcnn4x|edsr4x|imdn4x|sparnet4x (or 2x), recognition=arcface, and more",
    "eval": "an experiment: results.json, report.html",
    "score": "anybody's scores in files: the same tables, likelihood ratios, pages",
    "compare": "two pictures: their score, and its likelihood ratio by scores=FILE",
    "upscale": "any picture by any upscaler: lrsr upscale FILE|FOLDER... out=DIR sr=srcnn2",
    "identities": "contact sheet, who they are, uniqueness check; export=DIR: meshes",
    "reconstruct": "heads from photographs in images=DIR, for identities.photographs=",
    "generate": "photographs of people whom a generator=FILE.onnx makes up, for reconstruct",
    "calibrate-reconstructor": "another network for lrsr reconstruct, model=FILE.onnx",
    "fit-camera": "a camera preset from real pictures in images=DIR",
    "models": "list, pull NAME, add FILE, verify, remove NAME: networks of other people",
}
"""What each does; ``lrsr.tasks.run_COMMAND`` does it."""

_OPERANDS = {"score": "files", "compare": "files", "upscale": "images"}
"""Commands that take words without a key, and the setting that they are."""

_LOGS_KEY, _LOGS = "hydra.launcher.submitit_folder", "runs/submitit/%j"
"""A folder for each of submitit's jobs."""

_USAGE = f"""lrsr {__version__}: what can still be recognised in a face ten pixels wide?

usage: lrsr COMMAND [key=value ...] [--cfg job] [--multirun] [--help] [--debug]

commands:
{chr(10).join(f"  {name:<23} {does}" for name, does in _COMMANDS.items())}

examples:
  lrsr demo
  lrsr eval experiment=super_resolution identities.count=200 options=[1,4]
  lrsr render identities.count=3 pose=left lighting=above ipd_px=8 out=probes
  lrsr score runs/eval/.../scores.csv calibration=pav
  lrsr compare probe.png enrolled.png scores=runs/eval/.../scores.csv
  lrsr upscale holidays portrait.jpg out=larger sr=srcnn4
  lrsr train sr=srcnn4x identities.count=300
  lrsr identities identities.count=1500 identities.sex=female
  lrsr identities export=meshes identities.count=3 pose=left
  lrsr generate generator=synthesis.onnx out=people count=200
  lrsr reconstruct images=portraits out=heads
  lrsr render identities.photographs=heads pose=left out=probes
  lrsr fit-camera images=probes name=lobby
  lrsr render camera=runs/fit-camera/.../lobby.yaml out=probes
  lrsr models add theirs.onnx contract=insightface
  lrsr eval recognition=[shipped,dlib,theirs]

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
    given = list(sys.argv[1:] if argv is None else argv)
    words = [word for word in given if word != "--debug"]
    with _terminated() as received:
        try:
            _run_or_help(words)
            sys.stdout.flush()
        except KeyboardInterrupt:
            _tell(
                f"{'stopped' if received else 'interrupted'}; run the same command again to go on"
            )
            return 143 if received else 130
        except BrokenPipeError:  # the reader of a pipe, such as `head`, has had enough
            return 141
        except SystemExit as stop:  # argparse, inside Hydra
            return stop.code if isinstance(stop.code, int) else 2
        except Exception as error:
            if words != given:
                raise
            causes = error.exceptions if isinstance(error, ExceptionGroup) else [error]
            told = [(explain(cause, words), getattr(cause, "__notes__", [])) for cause in causes]
            for (_, line), jobs in told:
                _tell(": ".join([*jobs, line]))
            return min(status for (status, _), _ in told)  # a fault of ours outweighs the user's
        finally:
            _give_up_stdout()
    return 0


def _run_or_help(words: list[str]) -> None:
    if words[:1] == ["help"]:
        words = [*words[1:], "--help"]
    if {"-V", "--version"} & set(words):
        sys.stdout.write(f"lrsr {__version__}\n")
    elif not words or words[0] in {"-h", "--help"}:
        sys.stdout.write(_USAGE)
    else:
        logging.basicConfig(level=logging.INFO, stream=sys.stderr, format="%(name)s: %(message)s")
        rest = words[1:] if words[0] != "models" else _with_action(words[1:])
        _run(words[0], rest)


def _with_action(words: list[str]) -> list[str]:
    """Let ``pull NAME`` mean ``action=pull names=[NAME]``."""
    plain = [word for word in words if "=" not in word and not word.startswith("-")]
    quoted = ",".join(quoted_word(word) for word in plain[1:])
    given = [f"action={plain[0]}", f"names=[{quoted}]"] if plain else []
    return [*given, *(word for word in words if word not in plain)]


def _run(name: str, words: list[str]) -> None:
    if name not in _COMMANDS:
        near = get_close_matches(name, _COMMANDS, n=1)
        hint = f"did you mean {near[0]!r}?" if near else f"choose one of {', '.join(_COMMANDS)}"
        raise InputError(f"no command {name!r}: {hint}")
    Path.cwd()  # fails where it was removed
    prepare_home()
    os.environ["HYDRA_FULL_ERROR"] = "1"  # errors reach `main`, which says them in one line
    from hydra import version  # a quarter of a second that `lrsr --help` need not pay
    from hydra._internal.utils import _run_hydra, get_args_parser

    parser = get_args_parser()
    parser.error = _refuse_option  # type: ignore[method-assign]
    args = parser.parse_intermixed_args(words)
    version.setbase("1.3")
    failures: list[Exception] = []
    with _mode_of_the_line(args), TemporaryDirectory() as scratch:
        args.overrides, composing = _mended(args, name, Path(scratch))
        try:
            with composing:
                _run_hydra(
                    args=args,
                    args_parser=parser,
                    task_function=_task(f"run_{name.replace('-', '_')}", failures),
                    config_path=str(config_folder()),
                    config_name=name,
                )
        except ValueError as error:  # Hydra's word for options that exclude each other
            _refuse_option(str(error))
    if args.multirun and failures:
        raise ExceptionGroup("some jobs of the multirun failed", failures)
    if failures:
        raise failures[0]


@contextmanager
def _mode_of_the_line(args: Any) -> Iterator[None]:
    """Spare Hydra a whole composition to learn its mode; only the user's own words can say one."""
    from hydra._internal.hydra import Hydra

    asks = Hydra.get_mode
    if not (args.config_path or args.config_dir or "hydra." in " ".join(args.overrides)):
        Hydra.get_mode = lambda *_, **__: None  # type: ignore[method-assign]  # as in conf/
    try:
        yield
    finally:
        Hydra.get_mode = asks  # type: ignore[method-assign]


def _refuse_option(message: str) -> Never:
    raise InputError(f"{message}: settings are written key=value; lrsr COMMAND --help lists them")


@contextmanager
def _composing(
    check: "Callable[[DictConfig], None]", explained: AbstractContextManager[None]
) -> Iterator[None]:
    """Check the keys in Hydra's own composition, which then need not be made twice."""
    from hydra._internal.config_loader_impl import ConfigLoaderImpl

    applies = ConfigLoaderImpl._apply_overrides_to_config

    def check_and_apply(words: Any, config: "DictConfig") -> None:  # of groups alone, so far
        check(config)
        applies(words, config)

    ConfigLoaderImpl._apply_overrides_to_config = staticmethod(check_and_apply)  # type: ignore[assignment]
    try:
        with explained:
            yield
    finally:
        ConfigLoaderImpl._apply_overrides_to_config = staticmethod(applies)  # type: ignore[method-assign]


def _mended(args: Any, name: str, scratch: Path) -> tuple[list[str], AbstractContextManager[None]]:
    """Return the overrides as Hydra reads what was meant, and where it is to compose them.

    In ``scratch`` go cameras of the user's, and in a multirun what Hydra writes: multirun.yaml and
    an empty folder for each job, which say less than the runs' own. What submitit's jobs are told
    and print stays in ``runs``, for other machines do not see ``scratch``.
    """
    given = [args.config_path or config_folder(), *filter(None, [args.config_dir])]
    folders = [*(Path(folder).absolute() for folder in given), scratch]
    words = _with_operands(args.overrides, name)
    words = [_with_given_cameras(word, scratch, args.multirun) for word in words]
    submitit = any(word.startswith("hydra/launcher=submitit") for word in words)
    if submitit and not any(word.startswith(_LOGS_KEY) for word in words):
        words.append(f"{_LOGS_KEY}={quoted_word(f'{Path.cwd()}/{_LOGS}')}")
    overrides = Overrides(args.config_name or name, folders, args.multirun)
    composing: AbstractContextManager[None] = nullcontext()
    if args.multirun:  # whose options Hydra does not compose before the first job
        mended = overrides.mended(words)
    else:
        mended, check, explained = overrides.unchecked(words)
        composing = _composing(check, explained)
    first = [f'hydra.sweep.dir="{scratch}"', f'hydra.searchpath=["file://{scratch}"]']
    return [*first, *mended], composing


def _with_operands(words: Sequence[str], name: str) -> list[str]:
    """Let words without a key be the setting that the command has for them, as a list."""
    operands = [word for word in words if _is_operand(word)]
    if name not in _OPERANDS or not operands:
        return [*words]
    from hydra.core.override_parser.types import Quote, QuotedString

    texts = ",".join(QuotedString(text, Quote.double).with_quotes() for text in operands)
    return [*(word for word in words if word not in operands), f"{_OPERANDS[name]}=[{texts}]"]


def _is_operand(word: str) -> bool:
    """Tell whether a word has no key: ``pics``, and ``./a=b`` or ``pics/a=b`` where that is."""
    key, equals, _ = word.partition("=")
    if equals:
        return os.sep in key and Path(word).exists()
    return word[:1] not in {"~", "+"}


def _with_given_cameras(word: str, scratch: Path, sweep: bool) -> str:
    """Let ``camera=PATH.yaml`` name a file: it becomes an option of the group for this run."""
    key, _, value = word.partition("=")
    if key.lstrip("+") != "camera":
        return word
    return f"{key}=" + ",".join(_given_camera(text, scratch) for text in pieces_of(value, sweep))


def _given_camera(text: str, scratch: Path) -> str:
    """Return the option for a file; a preset's name is returned as it is.

    Raises:
        InputError: There is no such file, or it is no camera.
    """
    text = re.sub(r"""^(["'])(.*)\1$""", r"\2", text)
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


def _task(function: str, failures: list[Exception]) -> "Callable[[DictConfig], None]":
    """Wrap a task for Hydra, which would print a line of its own about what it lets through.

    In a multirun the jobs after a failed one are still done, and each failure is told by its job;
    of those that a launcher such as joblib's runs in other processes, the first.
    """
    from hydra.core.hydra_config import HydraConfig
    from hydra.types import RunMode

    def run(config: "DictConfig") -> None:
        try:
            result: Path | None = getattr(importlib.import_module("lrsr.tasks"), function)(config)
            if result is not None:
                _say(result)
        except Exception as error:
            hydra = HydraConfig.get()
            if hydra.mode == RunMode.MULTIRUN:
                asked = " ".join(word.lstrip("+") for word in hydra.overrides.task)
                error.add_note(f"job {hydra.job.num} ({asked})")
                if not hydra.launcher._target_.startswith("hydra._internal."):
                    raise  # in a process of a launcher's own: Hydra brings it to ours
            failures.append(error)

    return run


def _say(folder: Path) -> None:
    """Print where the result is; if nobody can read that, the work is done all the same."""
    try:
        sys.stdout.write(f"{folder}\n")
        sys.stdout.flush()
    except (OSError, ValueError) as error:  # a full disk, no reader, or letters it cannot show
        _give_up_stdout()
        _tell(f"done: {folder} (standard output: {error})")


def _tell(line: str) -> None:
    with suppress(OSError, ValueError):
        sys.stderr.write(f"lrsr: {line}\n")


def _give_up_stdout() -> None:
    """Send what cannot be written to nowhere, so that Python's exit does not fail on it."""
    try:
        sys.stdout.flush()
    except (OSError, ValueError):
        with suppress(OSError, ValueError):
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _open_streams() -> None:
    """Open closed standard streams, whose numbers data files would get; let all show any letter."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest free number
        if getattr(sys, name) is None:
            setattr(sys, name, os.fdopen(number, "w" if number else "r", closefd=False))
        if number and isinstance(stream := getattr(sys, name), TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    sys.stderr = cast("TextIO", _Unfailing(sys.stderr))


class _Unfailing:
    """Standard error: the work goes on where its progress cannot be written or nobody reads it."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        with suppress(OSError, ValueError):
            self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        with suppress(OSError, ValueError):
            self._stream.flush()

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def _terminated() -> Iterator[list[int]]:
    """Let SIGTERM end the work as Ctrl-C does, everything tidied up; give what was received."""
    received: list[int] = []

    def stop(number: int, frame: FrameType | None) -> None:
        received.append(number)
        raise KeyboardInterrupt

    if threading.current_thread() is not threading.main_thread():
        yield received
        return
    before = signal.signal(signal.SIGTERM, stop)
    try:
        yield received
    finally:
        signal.signal(signal.SIGTERM, before)
