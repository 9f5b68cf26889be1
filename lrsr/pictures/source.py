"""Where do an experiment's pictures come from? From people to be rendered, or from a folder."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.photographs.person import Photographed
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.folder import Entry, read_folder, read_picture
from lrsr.pictures.maker import Maker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import CHUNK, filmed, render_missing, take_pictures

_MOST_VALUES = 2**24
"""64 MiB, and sixteen times that when all are enlarged four times."""


@dataclass(frozen=True)
class Rendered:
    """Pictures of people who are rendered where the cache lacks them.

    Attributes:
        recipes: What is shown.
        camera: Takes the pictures.
        cache: Where renderings are kept.
        maker: Renders what is missing; Mitsuba when None.
        progress: Show bars.
    """

    recipes: Sequence[Recipe]
    camera: Camera
    cache: RenderCache
    maker: Maker | None = None
    progress: bool = True

    @property
    def identity_ids(self) -> Sequence[str]:
        """Who each picture shows."""
        return [recipe.person.id for recipe in self.recipes]

    @property
    def names(self) -> Sequence[str]:
        """What each picture is called: after its person, of whom there is one."""
        return self.identity_ids

    def load(self, start: int, stop: int) -> list[Picture]:
        """Return the pictures ``start`` to ``stop - 1``; what is not rendered yet is rendered.

        Raises:
            InputError: The cache cannot be read or written.
        """
        part = self.recipes[start:stop]
        return take_pictures(
            part, self.cache, self.camera, progress=self.progress, maker=self.maker
        )


@dataclass(frozen=True)
class Photographs:
    """Pictures of a folder; see :mod:`lrsr.pictures.folder`.

    Attributes:
        root: The folder.
        entries: Which of its pictures, in order.
        finer: Its other pictures of the kind, on films of other scales.
        later: Those that are later frames of a burst.
    """

    root: Path
    entries: Sequence[Entry] = ()
    finer: Sequence[Entry] = ()
    later: Sequence[Entry] = ()

    @property
    def identity_ids(self) -> Sequence[str]:
        """Who each picture shows."""
        return [entry.identity_id for entry in self.entries]

    @property
    def names(self) -> Sequence[str]:
        """The file of each picture."""
        return [entry.file for entry in self.entries]

    def load(self, start: int, stop: int) -> list[Picture]:
        """Read the pictures ``start`` to ``stop - 1``.

        Raises:
            InputError: One cannot be read.
        """
        return [read_picture(self.root, entry) for entry in self.entries[start:stop]]


@dataclass(frozen=True)
class Bursts:
    """Pictures with the later frames of their bursts.

    Attributes:
        frames: A source for each frame, of the same people in the same order.
    """

    frames: "Sequence[Rendered | Photographs]"

    @property
    def identity_ids(self) -> Sequence[str]:
        """Who each burst shows."""
        return self.frames[0].identity_ids

    @property
    def names(self) -> Sequence[str]:
        """What the first frame of each is called."""
        return self.frames[0].names

    def load(self, start: int, stop: int) -> list[Picture]:
        """Return the bursts ``start`` to ``stop - 1``; what is not rendered yet is rendered.

        Raises:
            InputError: A picture cannot be read, or a cache not written.
        """
        first, *later = [source.load(start, stop) for source in self.frames]
        return [
            replace(picture, later=tuple(frame[i] for frame in later))
            for i, picture in enumerate(first)
        ]


Source = Rendered | Photographs | Bursts
"""Pictures in an order that does not change, a few in memory at a time."""


def read_photographs(root: Path, kind: str) -> Photographs:
    """Find the pictures of a folder that can be probes, or a gallery.

    Args:
        root: Any folder of pictures.
        kind: "probe" or "gallery": pictures of the other kind are left out, if the manifest says.

    Raises:
        InputError: There is no such folder, or no such picture in it.
    """
    of_kind = [entry for entry in read_folder(root) if entry.kind in ("", kind)]
    chosen = [entry for entry in of_kind if (entry.scale, entry.frame) == (1, 0)]
    if not chosen:
        raise InputError(f"{root} holds no pictures of the kind {kind}: give another folder")
    finer = [entry for entry in of_kind if entry.scale > 1]
    later = [entry for entry in of_kind if entry.scale == 1 and entry.frame > 0]
    return Photographs(root, chosen, finer, later)


def references_of(probes: Photographs, scale: int) -> Photographs | None:
    """Find the true reference of every probe of a folder; None if one is missing.

    It shows the same person in the same scene, on a film ``scale`` times finer; ``lrsr render``
    writes such files.
    """
    seen = {_scene(entry): entry for entry in probes.finer if entry.scale == scale}
    if not all(_scene(entry) in seen for entry in probes.entries):
        return None
    return Photographs(probes.root, [seen[_scene(entry)] for entry in probes.entries])


def enrolled_photographs(photographed: Sequence[Photographed]) -> Photographs:
    """Return the very photographs of people, who may be rendered from them or from others."""
    entries = [
        Entry(
            file=person.file,
            identity_id=person.id,
            kind="gallery",
            landmarks_px=tuple(number for point in person.five_px for number in point),
        )
        for person in photographed
    ]
    return Photographs(Path("/"), entries)


def bursts_of(probes: Photographs, frames: int) -> Bursts:
    """Find the later frames of every probe of a folder.

    They show the same person under the same names (pose, lighting, ...), whatever the angles;
    ``lrsr render frames=N`` writes such files, and a manifest of one's own needs the column
    ``frame``.

    Args:
        probes: The first frames.
        frames: How many of each burst, at least 1.

    Raises:
        InputError: A frame is missing.
    """
    seen = {(_burst(entry), entry.frame): entry for entry in probes.later}
    sources = [probes]
    for number in range(1, frames):
        for entry in probes.entries:
            if (_burst(entry), number) not in seen:
                raise InputError(
                    f"{probes.root}: {entry.file} has no frame {number}: its manifest needs a row"
                    f" with frame={number} of {entry.identity_id}, or ask for fewer frames"
                )
        later = [seen[_burst(entry), number] for entry in probes.entries]
        sources.append(Photographs(probes.root, later))
    return Bursts(sources)


def _scene(entry: Entry) -> tuple[object, ...]:
    return (*_burst(entry), entry.yaw_deg, entry.pitch_deg, entry.roll_deg, entry.frame)


def _burst(entry: Entry) -> tuple[object, ...]:
    worn = (entry.pose, entry.expression, entry.another_day)
    seen = (entry.lighting, entry.lens, entry.standpoint, entry.skin)
    return (entry.identity_id, *worn, *seen, entry.ipd_px, entry.run_seed)


def chunks(source: Source) -> Iterator[tuple[slice, list[Picture]]]:
    """Yield the pictures of a source a few at a time, with their places.

    Of photographs, which may be large, as many as have :data:`_MOST_VALUES` together.
    """
    total = len(source.identity_ids)
    step = CHUNK if all(isinstance(one, Rendered) for one in _frames(source)) else 1
    some: list[Picture] = []
    for start in range(0, total, step):
        stop = min(start + step, total)
        some += source.load(start, stop)
        values = sum(one.image.numel() for one in some)
        if len(some) >= CHUNK or values >= _MOST_VALUES or stop == total:
            yield slice(stop - len(some), stop), some
            some = []


def render_sources(sources: Sequence[Source], share: tuple[int, int] = (0, 1)) -> int:
    """Render whatever the caches of all sources lack, under one bar; return how many pictures.

    Args:
        sources: What is wanted.
        share: Of the people, (k, n): those whose number leaves k when divided by n.

    Raises:
        InputError: A cache cannot be written.
    """
    every = [one for source in sources for one in _frames(source)]
    rendered = [source for source in every if isinstance(source, Rendered)]
    if not rendered:
        return 0
    first = rendered[0]
    part, parts = share
    films = [
        filmed(recipe, source.camera)
        for source in rendered
        for recipe in source.recipes
        if recipe.person.index % parts == part
    ]
    return render_missing(films, first.cache, progress=first.progress, maker=first.maker)


def _frames(source: Source) -> "Sequence[Rendered | Photographs]":
    return source.frames if isinstance(source, Bursts) else [source]
