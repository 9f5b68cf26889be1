"""Who renders first, from where, and how many at once must not matter."""

import threading
import weakref
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Thread

import numpy as np
import pytest
from fakes import first_use
from fakes.elsewhere import finish
from fakes.scenes import POSES, Studio
from oracles.heads import stand_in

from lrsr.identities.morphable import sample_head
from lrsr.presets import preset
from lrsr.rendering.backend import alone
from lrsr.rendering.live_scene import LiveScene


class Value:
    """Something that a scene holds."""


ASK = {"ipd_px": 4.0, "samples_per_pixel": 16}

FIRST = {
    "threads, of one renderer and of their own, then the main one": (first_use.threads, 6),
    "children that a renderer starts": (first_use.children, 3),
    "a forked child before its parent": (first_use.fork, 2),
}


@pytest.mark.parametrize(("first", "count"), FIRST.values(), ids=FIRST)
def test_the_first_use_may_be_anywhere(
    first: Callable[[], first_use.Seen], count: int, tmp_path: Path
) -> None:
    """Case 15: one of two threads died of "module 'mitsuba' has no attribute 'set_variant'"."""
    ended = finish(tmp_path / "told", first_use.tell, first)
    assert ended.out.splitlines()[-1:] == [f"{count} 1 []"], ended.err
    # A child that is forked after a render says what to do.
    last = ended.err.splitlines()[-1]
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
