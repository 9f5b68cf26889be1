"""Where do a network's lessons come from? They are rendered where the cache lacks them."""

import hashlib
from abc import abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from lightning.pytorch import LightningDataModule

from lrsr.camera import Camera
from lrsr.configuration import settle
from lrsr.errors import InputError
from lrsr.identities.day.another_day import SAME_DAY, AnotherDay
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.person import Person
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker, MitsubaMaker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import CHUNK, filmed, render_missing, take_pictures
from lrsr.rendering.lens import Lens
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import Standpoint


@dataclass(kw_only=True, eq=False)
class Rendered(LightningDataModule):
    """Pictures of people to learn from and of others, who share nothing with them, to validate on.

    Attributes:
        people: Who is learned from.
        validation_people: Who chooses the best epoch.
        lens: Of every picture.
        standpoint: Of every picture.
        expression: Of every picture that has no other, but enrolled ones.
        another_day: Of every picture but enrolled ones.
        quality: Of the renderings.
        camera: Takes the pictures; its own compression is not used.
        cache: Of renderings.
        batch_size: What is shown in a step.
        seed: All that is drawn follows from it, any whole number.
        maker: Builds and renders.
        progress: Show a bar while rendering.

    Raises:
        InputError: Somebody is in both, there is nobody to learn from, or a number is none.
    """

    people: Sequence[Person]
    validation_people: Sequence[Person]
    lens: Lens
    standpoint: Standpoint
    expression: Expression = NEUTRAL
    another_day: AnotherDay = SAME_DAY
    quality: Quality
    camera: Camera
    cache: RenderCache
    batch_size: int
    seed: int
    maker: Maker = field(default_factory=MitsubaMaker)
    progress: bool = True

    def __post_init__(self) -> None:
        super().__init__()
        settle(self, "data")
        if not self.people:
            raise InputError("identities.count=0: wanted somebody to learn from")
        known = {person.id for person in self.people}
        if both := known & {person.id for person in self.validation_people}:
            raise InputError(f"{min(both)} is to be learned and to validate: choose others")

    @abstractmethod
    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""

    def about(self) -> dict[str, Any]:
        """Return what all of it depends on, in plain values: who, how it is made, which keys."""
        return {
            "people": len(self.people),
            "validation_people": len(self.validation_people),
            **{f"versions.{name}": version for name, version in self.maker.versions.items()},
            "renderings": self.digest(self.shots()),
        }

    def digest(self, shots: Iterable[tuple[Recipe, Camera]]) -> str:
        """Return 16 hex digits that depend on every rendering."""
        keys = [self.cache.key(filmed(*shot), self.maker.versions) for shot in shots]
        return hashlib.sha256("".join(keys).encode()).hexdigest()[:16]

    @property
    def unread(self) -> Mapping[str, str]:
        """Return sections of the configuration that change nothing, and why: here none."""
        return {}

    def prepare_data(self) -> None:
        """Render what the cache lacks; stopped at any moment, the next call goes on.

        Raises:
            InputError: The cache cannot be written or the disk is full.
        """
        films = [filmed(*shot) for shot in self.shots()]
        render_missing(films, self.cache, maker=self.maker, progress=self.progress)

    def taken(self, recipes: Sequence[Recipe], camera: Camera) -> Iterator[Picture]:
        """Yield the pictures a few at a time: as floats they would not all fit in memory."""
        for start in range(0, len(recipes), CHUNK):
            chunk = recipes[start : start + CHUNK]
            yield from take_pictures(
                chunk, self.cache, camera, maker=self.maker, progress=self.progress
            )
