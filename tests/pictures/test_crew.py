"""Several processes fill one cache: nobody twice, nothing lost, the same bytes."""

import fcntl
import json
import os
import signal
import subprocess
import sys
from multiprocessing import get_context
from pathlib import Path

import pytest
from fakes.elsewhere import finish, run_script
from fakes.maker import FakeMaker
from fakes.scenes import recipe

from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.pictures import crew
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.claims import Claims
from lrsr.pictures.crew import render_people
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import render_missing

TESTS = Path(__file__).parents[1]


def recipes(people: int) -> list[Recipe]:
    return [recipe(index, scale=scale, ipd_px=4) for scale in (1, 2) for index in range(people)]


def content(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob("*/*")}


class Dying(FakeMaker):
    """Is killed, as for a lack of memory."""

    def head(self, recipe: Recipe) -> Head:
        os.kill(os.getpid(), signal.SIGKILL)
        return super().head(recipe)


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("alone")
    render_missing(recipes(6), RenderCache(folder), progress=False, maker=FakeMaker())
    return folder


def test_two_processes_leave_the_same_bytes_as_one(alone: Path, tmp_path: Path) -> None:
    cache = RenderCache(tmp_path, processes=2)
    maker = FakeMaker()
    assert render_missing(recipes(6), cache, progress=False, maker=maker) == 12
    assert maker.renders == []  # all of it was done by others
    assert content(tmp_path) == content(alone)


def test_a_process_that_is_killed_is_told_in_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(crew, "get_context", lambda _: get_context("fork"))  # starts at once
    cache = RenderCache(tmp_path, processes=2)
    with pytest.raises(InputError, match="processes=2: one was killed; if memory is short"):
        render_missing(recipes(2), cache, progress=False, maker=Dying())


@pytest.mark.parametrize("processes", [0, -1])
def test_there_is_at_least_one_process(processes: int, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=f"processes={processes}: wanted at least 1"):
        RenderCache(tmp_path, processes)


THREE = """
import json, os, sys
from pathlib import Path
from fakes.maker import FakeMaker
from fakes.scenes import recipe
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.render import render_missing

wanted = [recipe(index, scale=scale, ipd_px=4) for scale in (1, 2) for index in range(6)]
for _ in range(3):  # commands at once
    if os.fork() == 0:
        maker = FakeMaker(0.02)
        render_missing(wanted, RenderCache(Path(sys.argv[1])), progress=False, maker=maker)
        made = [[made.person.index, made.film.scale] for made in maker.renders]
        os.write(1, (json.dumps(made) + "\\n").encode())
        os._exit(0)
for _ in range(3):
    os.wait()
"""


def test_commands_that_share_a_cache_render_nothing_twice(alone: Path, tmp_path: Path) -> None:
    ended = finish(tmp_path / "told", run_script, THREE, str(tmp_path / "cache"))
    made = [one for line in ended.out.splitlines() for one in json.loads(line)]
    assert sorted(made) == [[index, scale] for index in range(6) for scale in (1, 2)], ended.err
    assert content(tmp_path / "cache") == content(alone)


HOLDER = """
import sys
from multiprocessing import get_context
from pathlib import Path
from lrsr.pictures.claims import Claims

with Claims(Path(sys.argv[1])) as claims:
    print(claims.take("anna"), flush=True)
    sys.stdin.readline()
"""


@pytest.fixture
def holder(tmp_path: Path) -> "subprocess.Popen[str]":
    """Another process that has Anna in hand."""
    command = [sys.executable, "-c", HOLDER, str(tmp_path)]
    process = subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, cwd=TESTS
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "True\n"
    return process


def test_whom_another_process_has_in_hand_is_left_to_it_until_it_ends(
    holder: "subprocess.Popen[str]", tmp_path: Path
) -> None:
    cache, maker, told = RenderCache(tmp_path), FakeMaker(), []
    people = {"anna": recipes(1), "bert": [recipe(3, ipd_px=4)]}
    left = render_people(people, cache, maker, told.append, wait=False)
    assert ([*left], len(maker.renders), sum(told)) == (["anna"], 1, 1)
    holder.kill()
    holder.communicate()
    assert render_people(people, cache, maker, told.append) == {}
    assert len(maker.renders) == 3


def test_a_claim_ends_when_it_is_given_back(
    holder: "subprocess.Popen[str]", tmp_path: Path
) -> None:
    with Claims(tmp_path) as claims:
        assert not claims.take("anna")
        assert claims.take("bert")
        holder.communicate("\n")
        assert claims.take("anna", wait=True)
        claims.give_back("anna")


def test_on_a_disk_without_locks_everybody_gets_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise OSError(38, "Function not implemented")

    monkeypatch.setattr(fcntl, "lockf", refuse)
    with Claims(tmp_path) as claims:
        assert claims.take("anna")
        claims.give_back("anna")


def test_a_folder_that_cannot_be_written_is_refused(tmp_path: Path) -> None:
    (tmp_path / ".claims").mkdir()
    with pytest.raises(InputError, match=r"cannot write .*\.claims"):
        Claims(tmp_path)
