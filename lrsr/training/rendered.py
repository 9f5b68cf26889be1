"""Where do a network's lessons come from? They are rendered where the cache lacks them."""

import hashlib
from abc import abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from lightning.pytorch import LightningDataModule

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.paths import cache_folder
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker, mitsuba_maker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import CHUNK, filmed, render_missing, take_pictures


class Rendered(LightningDataModule):
    """Pictures of people to learn from and of others, who share nothing with them, to validate on.

    Args:
        people: Who is learned from.
        validation_people: Who chooses the best epoch.
        cache: Folder of the render cache; None: the user's.
        progress: Show a bar while rendering.
        maker: Builds and renders; Mitsuba when None.

    Raises:
        InputError: Somebody is in both, or there is nobody to learn from.
    """

    def __init__(
        self,
        people: Sequence[Person],
        validation_people: Sequence[Person],
        *,
        cache: Path | None,
        progress: bool,
        maker: Maker | None,
    ) -> None:
        super().__init__()
        self.people, self.validation_people = list(people), list(validation_people)
        if not self.people:
            raise InputError("identities.count=0: wanted somebody to learn from")
        if both := {person.id for person in people} & {person.id for person in validation_people}:
            raise InputError(f"{min(both)} is to be learned and to validate: choose others")
        self.cache = RenderCache(cache or cache_folder())
        self.progress, self._maker = progress, maker

    @property
    def maker(self) -> Maker:
        """Who builds and renders."""
        self._maker = self._maker or mitsuba_maker()
        return self._maker

    @abstractmethod
    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""

    def about(self) -> dict[str, Any]:
        """Return what all of it depends on, in plain values: who, how it is made, and which keys."""
        versions = self.maker.versions
        keys = [self.cache.key(filmed(*shot), versions) for shot in self.shots()]
        return {
            "people": len(self.people),
            "validation_people": len(self.validation_people),
            **{f"versions.{name}": version for name, version in versions.items()},
            "renderings": hashlib.sha256("".join(keys).encode()).hexdigest()[:16],
        }

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
            yield from take_pictures(
                recipes[start : start + CHUNK],
                self.cache,
                camera,
                maker=self.maker,
                progress=self.progress,
            )
