"""Who renders what is missing? This process or several, each one person at a time."""

import logging
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing import get_all_start_methods, get_context
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lrsr.errors import InputError
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.claims import Claims
from lrsr.pictures.maker import Maker
from lrsr.pictures.recipe import Recipe

if TYPE_CHECKING:
    from lrsr.identities.head import Head

People = Mapping[str, Sequence[Recipe]]
"""The recipes that show one head, by a name that it has in every process."""

_METHOD = "forkserver" if "forkserver" in get_all_start_methods() else "spawn"
"""How processes begin: never as forks of this one, which may have started Mitsuba."""
_LOADED = ["lrsr.identities.morphable", "lrsr.rendering.renderer"]
"""Takes seconds, and more of them for each process that would load it itself."""

logger = logging.getLogger(__name__)


def missing_of(recipes: Iterable[Recipe], cache: RenderCache, maker: Maker) -> list[Recipe]:
    """Return what the cache lacks or holds damaged, each recipe once."""
    versions = maker.versions
    keyed = {cache.key(recipe, versions): recipe for recipe in recipes}
    return [recipe for key, recipe in keyed.items() if cache.get(key) is None]


def render_people(
    people: People,
    cache: RenderCache,
    maker: Maker,
    tell: Callable[[int], object],
    *,
    wait: bool = True,
) -> dict[str, Sequence[Recipe]]:
    """Render people in this process, but for those whom another one has in hand.

    A head is built once, in a second thread while the one before is being rendered.

    Args:
        people: Whose pictures are missing.
        cache: Receives every picture as soon as it is done.
        maker: Builds and renders.
        tell: Is told of every picture that is there.
        wait: At the end, for people whom others have in hand; they are rendered here if the others
            have not done it.

    Returns:
        Whom others have in hand, if they are not waited for.

    Raises:
        InputError: The cache cannot be written or the disk is full.
    """
    with Claims(cache.folder) as claims:
        work = _Work(cache, maker, claims, tell)
        elsewhere: dict[str, Sequence[Recipe]] = {}
        for name, recipes, head in _heads(maker, work.claimed(people, elsewhere)):
            work.render(name, recipes, head)
        if not wait:
            return elsewhere
        if elsewhere:
            logger.info("%d people are in the hands of other processes: waiting", len(elsewhere))
        for name, recipes in elsewhere.items():
            claims.take(name, wait=True)
            if lacking := work.lacking(name, recipes):  # it was killed
                work.render(name, lacking, maker.head(lacking[0]))
    return {}


@dataclass(frozen=True)
class _Work:
    """What this process does with people whom it has claimed."""

    cache: RenderCache
    maker: Maker
    claims: Claims
    tell: Callable[[int], object]

    def claimed(
        self, people: People, elsewhere: dict[str, Sequence[Recipe]]
    ) -> Iterator[tuple[str, Sequence[Recipe]]]:
        """Claim one after the other, and yield what they lack; note those who are not free."""
        for name, recipes in people.items():
            if not self.claims.take(name):
                elsewhere[name] = recipes
            elif lacking := self.lacking(name, recipes):
                yield name, lacking

    def lacking(self, name: str, recipes: Sequence[Recipe]) -> list[Recipe]:
        """Return what nobody has rendered; whoever lacks nothing is given back."""
        lacking = missing_of(recipes, self.cache, self.maker)
        self.tell(len(recipes) - len(lacking))
        if not lacking:
            self.claims.give_back(name)
        return lacking

    def render(self, name: str, recipes: Sequence[Recipe], head: "Head") -> None:
        """Render all pictures of somebody and give them back."""
        versions = self.maker.versions
        for recipe in recipes:
            self.cache.put(self.cache.key(recipe, versions), self.maker.render(head, recipe))
            self.tell(1)
        self.claims.give_back(name)


def _heads(
    maker: Maker, people: Iterable[tuple[str, Sequence[Recipe]]]
) -> Iterator[tuple[str, Sequence[Recipe], "Head"]]:
    """Build one head ahead of the one that is being rendered."""
    builder = ThreadPoolExecutor(max_workers=1, thread_name_prefix="lrsr-head")
    ahead: list[tuple[str, Sequence[Recipe], Any]] = []
    try:
        for name, recipes in people:
            ahead.append((name, recipes, builder.submit(maker.head, recipes[0])))
            if len(ahead) > 1:
                before, theirs, head = ahead.pop(0)
                yield before, theirs, head.result()
        for name, recipes, head in ahead:
            yield name, recipes, head.result()
    finally:
        builder.shutdown(wait=False, cancel_futures=True)


def render_in_processes(
    people: People, cache: RenderCache, maker: Maker, tell: Callable[[int], object]
) -> dict[str, Sequence[Recipe]]:
    """Render people in ``cache.processes`` processes, each with its share of the cores.

    Args:
        people: Whose pictures are missing.
        cache: Receives every picture as soon as it is done.
        maker: Builds and renders; a copy of it goes to every process.
        tell: Is told of every person's pictures.

    Returns:
        Whom other commands have in hand.

    Raises:
        InputError: The cache cannot be written, the disk is full, or a process was killed.
    """
    count, context = min(cache.processes, len(people)), get_context(_METHOD)
    if _METHOD == "forkserver":
        context.set_forkserver_preload(_LOADED)
    elsewhere: dict[str, Sequence[Recipe]] = {}
    begin = (context.Value("i", 0), count)
    with ProcessPoolExecutor(count, context, initializer=_begin, initargs=begin) as pool:
        try:
            jobs = {
                name: pool.submit(_render_one, cache.folder, maker, name, recipes)
                for name, recipes in people.items()
            }
            for name, job in jobs.items():
                elsewhere |= job.result()
                tell(len(people[name]) if name not in elsewhere else 0)
        except BrokenProcessPool as error:
            raise InputError(
                f"processes={cache.processes}: one was killed; if memory is short, give fewer"
            ) from error
        finally:
            pool.shutdown(wait=True, cancel_futures=True)
    return elsewhere


def _begin(started: Any, count: int) -> None:
    """Leave Ctrl-C to the parent, and take every n-th core, of which the renderer uses all."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    with started.get_lock():
        number = started.value
        started.value += 1
    with suppress(AttributeError, OSError):  # only Linux has it
        cores = sorted(os.sched_getaffinity(0))
        os.sched_setaffinity(0, cores[number::count] or cores)


def _render_one(
    folder: Path, maker: Maker, name: str, recipes: Sequence[Recipe]
) -> dict[str, Sequence[Recipe]]:
    return render_people({name: recipes}, RenderCache(folder), maker, lambda _: None, wait=False)
