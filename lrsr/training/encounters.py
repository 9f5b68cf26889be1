"""How do two cameras see the same people? Small probes, and everybody's enrolled picture.

Both are rendered and photographed at their own sizes: the probe is no shrunken enrolled picture.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.configuration import as_number, require
from lrsr.identities.person import Person
from lrsr.pictures.picture import stack
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.pictures.render import CHUNK
from lrsr.recognition.mixed_resolution import cut_faces
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Film, Scene
from lrsr.training.rendered import Rendered

_LEAST_PX = 4.0


class Met(NamedTuple):
    """Aligned faces, of a group of people.

    Attributes:
        probes: ``(n, p)``, as :func:`lrsr.recognition.mixed_resolution.cut_faces` makes them.
        people: ``(n,)``, whose row of ``gallery`` shows the same person.
        gallery: ``(people, q)``.
    """

    probes: NDArray[np.float32]
    people: NDArray[np.int64]
    gallery: NDArray[np.float32]


@dataclass(kw_only=True, eq=False)
class Encounters(Rendered):
    """Probes and enrolled pictures of people to learn from, and of validation people.

    See the base's attributes, too; ``quality`` is that of the probes.

    Attributes:
        poses: How heads may be held in probes.
        lightings: What light may reach them there.
        compressions: A probe is taken with each.
        views: How many of the poses × lightings each person is seen in, drawn by seed.
        probe_ipd_px: Of the probes.
        gallery_lighting: Of enrolled pictures, which are frontal and taken without flaws.
        gallery_ipd_px: Of enrolled pictures.
        gallery_samples: Rays per pixel of enrolled pictures.

    Raises:
        InputError: A value is out of its range.
    """

    poses: Sequence[Pose]
    lightings: Sequence[Lighting]
    compressions: Sequence[str]
    views: int
    probe_ipd_px: float
    gallery_lighting: Lighting
    gallery_ipd_px: float
    gallery_samples: int
    batch_size: int = field(init=False, default=1)  # of no use: all is seen at once

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("probe_ipd_px", "gallery_ipd_px"):
            ipd_px = as_number(getattr(self, name), f"data.{name}")
            require(_LEAST_PX <= ipd_px <= 35, f"data.{name}", ipd_px, "4 to 35 px")
        shared = (self.lens, self.standpoint)
        day = (self.expression, self.another_day)
        both = product(self.poses, self.lightings)
        self.scenes = [Scene(lighting, pose, *shared, *day) for pose, lighting in both]
        count = len(self.scenes)
        require(count > 0, "data.poses, lightings", [], "at least one of each")
        require(1 <= self.views <= count, "data.views", self.views, f"1 to {count} poses x lights")
        require(len(self.compressions) > 0, "data.compressions", [], "at least one")
        require(self.gallery_samples >= 1, "data.gallery_samples", self.gallery_samples, ">= 1")
        self.cameras = [self.camera.compressing(name) for name in self.compressions]
        self.clean = self.camera.clean()
        self.enrolled = Scene(self.gallery_lighting, lens=self.lens, standpoint=self.standpoint)

    def probes(self, people: Sequence[Person]) -> list[Recipe]:
        """Return what everybody is rendered as when met: person by person."""
        film = Film(self.probe_ipd_px)
        return [
            Recipe(person, scene, film, self.quality).seeded(self.seed, "probe")
            for person in people
            for scene in self._seen(person)
        ]

    def gallery(self, people: Sequence[Person]) -> list[Recipe]:
        """Return what everybody is rendered as when enrolled."""
        quality = replace(self.quality, samples_per_pixel=self.gallery_samples)
        film = Film(self.gallery_ipd_px)
        return [
            Recipe(person, self.enrolled, film, quality).seeded(self.seed, "gallery")
            for person in people
        ]

    def _seen(self, person: Person) -> list[Scene]:
        draw = random.Random(derived_seed(self.seed, "views", person.split, person.index))
        return draw.sample(self.scenes, self.views)

    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""
        for people in (self.people, self.validation_people):
            yield from product(self.gallery(people), [self.clean])
            yield from product(self.probes(people), self.cameras[:1])

    def setup(self, stage: str | None = None) -> None:
        """Take and align all faces, once.

        Args:
            stage: Lightning's; all stages need both.
        """
        if not hasattr(self, "training"):
            self.training, self.validation = map(self._met, (self.people, self.validation_people))

    def _met(self, people: Sequence[Person]) -> Met:
        recipes, number = self.probes(people), np.arange(len(people)).repeat(self.views)
        probes = [self._cut(recipes, camera, self.probe_ipd_px) for camera in self.cameras]
        gallery = self._cut(self.gallery(people), self.clean, self.gallery_ipd_px)
        return Met(np.concatenate(probes), np.tile(number, len(self.cameras)), gallery)

    def _cut(self, recipes: Sequence[Recipe], camera: Camera, ipd_px: float) -> NDArray[np.float32]:
        parts = []
        for start in range(0, len(recipes), CHUNK):
            taken = self.taken(recipes[start : start + CHUNK], camera)
            parts.append(cut_faces(*stack(list(taken)), ipd_px)[0])
        return np.concatenate(parts)

    def in_words(self) -> str:
        """Tell how people were seen."""
        named = {
            "poses": [pose.name for pose in self.poses],
            "lights": [lighting.name for lighting in self.lightings],
            "compressions": list(self.compressions),
        }
        told = [f"{name} {', '.join(dict.fromkeys(some))}" for name, some in named.items()]
        told += [f"skin {self.quality.skin.name}", f"lens {self.lens.name}"]
        return f"probes: {'; '.join(told)}; enrolled: {self.gallery_lighting.name} light, no flaws"
