"""Who renders first, from where, and how many at once must not matter."""

import os
import subprocess
import sys
import threading
import weakref
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
from fakes.scenes import POSES, Studio
from oracles.heads import stand_in

from lrsr.identities.morphable import sample_head
from lrsr.presets import preset
from lrsr.rendering.backend import alone
from lrsr.rendering.live_scene import LiveScene


class Value:
    """Something that a scene holds."""


ASK = {"ipd_px": 4.0, "samples_per_pixel": 16}

HEADER = """
import multiprocessing, sys, threading
import numpy as np
from fakes.scenes import Studio
from oracles.heads import stand_in
from lrsr.rendering import render

def picture(_=0, render=render):
    return float(render(stand_in(0), ipd_px=4.0, samples_per_pixel=16).image.double().mean())

def own():
    return picture(render=Studio().render)

def in_threads(functions):
    seen, faults = [], []
    def work(function):
        try:
            seen.append(function())
        except BaseException as error:
            faults.append(f"{type(error).__name__}: {error}")
    threads = [threading.Thread(target=work, args=(function,)) for function in functions]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    return seen, faults

def in_child(method):
    with multiprocessing.get_context(method).Pool(1) as pool:
        return pool.map_async(picture, [0]).get(timeout=120)[0]
"""

FIRST = {
    "threads, of one renderer and of their own, then the main one": (
        "seen, faults = in_threads([picture] * 3 + [own] * 2); seen += [picture()]",
        6,
    ),
    "children that a renderer starts": (
        "seen, faults = [picture(), in_child('spawn'), in_child('forkserver')], []",
        3,
    ),
    "a forked child before its parent": ("seen, faults = [in_child('fork'), picture()], []", 2),
}


def run(tmp_path: Path, body: str) -> subprocess.CompletedProcess[str]:
    script = tmp_path / "first.py"
    indented = body.replace("\n", "\n    ")
    script.write_text(f"{HEADER}\nif __name__ == '__main__':\n    {indented}\n")
    environment = {**os.environ, "PYTHONWARNINGS": "ignore"}  # multiprocessing's, of forks
    paths = [str(Path(__file__).parents[1]), os.environ.get("PYTHONPATH", "")]
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, paths))
    return subprocess.run(
        [sys.executable, str(script)], env=environment, text=True, timeout=300,
        capture_output=True, check=False,
    )  # fmt: skip


@pytest.mark.parametrize(("body", "count"), FIRST.values(), ids=FIRST)
def test_the_first_use_may_be_anywhere(tmp_path: Path, body: str, count: int) -> None:
    """Case 15: one of two threads died of "module 'mitsuba' has no attribute 'set_variant'"."""
    done = run(
        tmp_path, f"{body}\nprint(len(seen), len(set(seen)), faults, flush=True)\nin_child('fork')"
    )
    assert done.stdout.splitlines()[-1:] == [f"{count} 1 []"], done.stderr
    # A child that is forked after a render says what to do.
    last = done.stderr.splitlines()[-1]
    assert last.startswith("lrsr.errors.InputError: process ")
    assert "forked after its parent had started Mitsuba" in last
    assert last.endswith("start it by multiprocessing's 'spawn' or 'forkserver'")


def test_threads_of_one_renderer_get_what_they_asked_for(renderer: Studio) -> None:
    jobs = [(stand_in(number % 3), pose) for number, pose in enumerate([*POSES] * 3)]
    wanted = [renderer.render(head, pose=pose, **ASK).image for head, pose in jobs]
    with ThreadPoolExecutor(4) as pool:
        seen = list(pool.map(lambda job: renderer.render(job[0], pose=job[1], **ASK).image, jobs))
    assert all(a.equal(b) for a, b in zip(wanted, seen, strict=True))


def test_a_scene_that_nobody_wants_waits_for_the_picture_of_another_thread() -> None:
    """Dr.Jit goes through all scenes that live, and said "unknown variable" of one that left."""
    kept, held, gone = [LiveScene(preset("rendering/skin", "reflective"))], Value(), Event()
    kept[0]._around["something"] = held
    left = weakref.ref(held)
    del held

    def drop() -> None:
        kept.clear()
        gone.set()

    with alone():
        Thread(target=drop).start()
        assert not gone.wait(0.2)
        assert left() is not None
    assert gone.wait(10)
    assert left() is None


def test_heads_are_built_while_another_is_rendered(renderer: Studio) -> None:
    wanted = renderer.render(stand_in(0), **ASK).image
    heads = []
    builder = threading.Thread(target=lambda: heads.append(sample_head(3, texture_size=64)))
    builder.start()
    while builder.is_alive():
        assert renderer.render(stand_in(0), **ASK).image.equal(wanted)
    builder.join()
    plain = sample_head(3, texture_size=64)
    for built, part in zip(heads[0].parts, plain.parts, strict=True):
        np.testing.assert_array_equal(built.vertices, part.vertices)
        np.testing.assert_array_equal(built.albedo, part.albedo)
