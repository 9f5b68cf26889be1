"""What does a super-resolution network learn from people? Pictures, rendered where missing.

The low-resolution input is no shrunken picture: it is the ×1 film of the scene through the camera,
and the target is the ×2, ×3 or ×4 film of the same scene, with the same exposure and without the
camera's flaws. Film and reference are aligned by construction. A degradation that no camera of a
scene can have, such as one drawn anew in each epoch, is made of the target instead.
"""

import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import torch

from lrsr.camera import Camera
from lrsr.configuration import as_list, as_number, as_whole, require
from lrsr.identities.person import Person
from lrsr.pictures.picture import stack
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.pictures.render import CHUNK
from lrsr.rendering.geometry import film_size_px
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Film, Scene
from lrsr.training.patches import Pair, Patches
from lrsr.training.patchwork import Batch, Patchwork
from lrsr.training.rendered import Rendered
from lrsr.training.shrinking.shrinking import Shrinking


@dataclass(kw_only=True, eq=False)
class Pairs(Patchwork, Rendered):
    """Patches for training, whole srgb pictures for validation; see the bases' attributes, too.

    ``prepare_data`` renders what the cache lacks, with a bar.

    Attributes:
        scale: 2, 3 or 4, how many times larger the target is.
        poses: How heads may be held.
        lightings: What light may reach them.
        ipd_px: Interpupillary distances of the ×1 film, px.
        views: How many of the poses × lightings × distances each person is seen in, drawn by seed.
        degradation: How the input comes to be.
        films: Scales of the films of input and target, e.g. ``[[1, 2], [2, 4]]``: the second pair
            shows a 2× network that is applied twice what its second pass meets. None: 1 to scale.
        patches: Cuts what the network takes and what it should return.

    Raises:
        InputError: A number is out of range, or the films do not fit the scale.
    """

    scale: int
    poses: Sequence[Pose]
    lightings: Sequence[Lighting]
    ipd_px: Sequence[float]
    views: int
    degradation: Shrinking
    films: Sequence[Sequence[int]] | None = None
    patches: Patches

    def __post_init__(self) -> None:
        super().__post_init__()
        shared = (self.lens, self.standpoint, self.expression, self.another_day)
        scenes = [
            Scene(lighting, pose, *shared) for pose, lighting in product(self.poses, self.lightings)
        ]
        self.ipd_px = [as_number(ipd, "data.ipd_px") for ipd in self.ipd_px]
        self.conditions = list(product(scenes, self.ipd_px))
        films = [(1, self.scale)] if self.films is None else as_list(self.films, "data.films")
        pairs = [as_list(pair, "data.films") for pair in films]
        require(all(len(pair) == 2 for pair in pairs), "data.films", films, "pairs, e.g. [[1,2]]")
        self.steps = [tuple(as_whole(film, "data.films") for film in pair) for pair in pairs]
        self.cameras = self.degradation.cameras(self.camera)
        self.clean = self.camera.clean()
        self._kept: dict[str, list[Pair]] = {}
        self._check()

    def _check(self) -> None:
        count = len(self.conditions)
        require(count > 0, "data.poses, lightings, ipd_px", [], "at least one of each")
        require(self.scale in (2, 3, 4), "data.scale", self.scale, "2, 3 or 4")
        wish = f"1 to {count}, the number of poses x lightings x distances"
        require(1 <= self.views <= count, "data.views", self.views, wish)
        fit = all(hr == lr * self.scale for lr, hr in self.steps)
        require(fit, "data.films", self.steps, f"films that differ by the factor {self.scale}")
        require(self.batch_size >= 1, "data.batch_size", self.batch_size, "a number >= 1")
        smallest = film_size_px(min(self.ipd_px)) * min(lr for lr, _ in self.steps)
        least = self.patches.least_px(self.scale)
        wish = f"pictures at least {least} px wide, as a patch is, not {smallest}"
        require(smallest >= least, "data.ipd_px", min(self.ipd_px), wish)

    def recipes(self, people: Sequence[Person], film: int) -> list[Recipe]:
        """Return what everybody is rendered as, on a film of that scale."""
        return [
            Recipe(person, scene, Film(ipd_px, film), self.quality).seeded(self.seed, "probe")
            for person in people
            for scene, ipd_px in self._seen(person)
        ]

    def _seen(self, person: Person) -> list[tuple[Scene, float]]:
        if self.views == len(self.conditions):
            return self.conditions
        draw = random.Random(derived_seed(self.seed, "views", person.split, person.index))
        return draw.sample(self.conditions, self.views)

    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""
        for people in (self.people, self.validation_people):
            yield from self._shots_of(people)

    def _shots_of(self, people: Sequence[Person]) -> Iterator[tuple[Recipe, Camera]]:
        for small, true in self.steps:
            yield from product(self.recipes(people, small), self.cameras[:1])
            yield from product(self.recipes(people, true), [self.clean])

    def about(self) -> dict[str, Any]:
        """Return what all of it depends on, and apart, what is validated on."""
        judged = self.digest(self._shots_of(self.validation_people))
        return super().about() | {"validation_renderings": judged}

    @property
    def unread(self) -> Mapping[str, str]:
        """Return sections of the configuration that change nothing, and why."""
        why = "only degradation=camera reads it; leave it, or give that"
        return {} if self.degradation.reads_camera else {"camera": why}

    @property
    def redrawn(self) -> bool:
        """Do the pairs differ from epoch to epoch?"""
        return self.degradation.redrawn

    @property
    def lr_made_by(self) -> str:
        """How the small pictures are made, in words."""
        return self.degradation.in_words(self.camera, of_films=True)

    def pairs(self, epoch: int | None) -> Iterator[Batch]:
        """Yield small and true srgb pictures, each batch of one size, and the true landmarks."""
        people = self.validation_people if epoch is None else self.people
        return self._filmed(people) if self.cameras else self._shrunk(people, epoch)

    def _filmed(self, people: Sequence[Person]) -> Iterator[Batch]:
        """Yield pictures of the small film, and of the fine one."""
        for camera, films in product(self.cameras, self.steps):
            for small, true in self._batches(people, films):
                inputs, _ = self._stacked(small, camera)
                yield inputs, *self._stacked(true, self.clean)

    def _shrunk(self, people: Sequence[Person], epoch: int | None) -> Iterator[Batch]:
        """Yield pictures of the fine film and what the degradation makes of them."""
        start = 0
        for stored, landmarks_px in self._sharp(people):
            seeds = self.degradation_seeds(epoch, start, len(stored))
            at = 0
            for pair in self.degradation(stored / 255, self.scale, seeds, self.camera):
                yield *pair, landmarks_px[at : at + len(pair[0])]
                at += len(pair[0])
            start += len(stored)

    def _sharp(self, people: Sequence[Person]) -> list[Pair]:
        """Return pictures of the fine films in 8 bits, and their landmarks, taken once."""
        split = people[0].split
        if split not in self._kept:
            recipes = (few for _, true in self.steps for few in self._batches(people, [true]))
            taken = (self._stacked(few, self.clean) for (few,) in recipes)
            self._kept[split] = [
                (images.mul(255).round().to(torch.uint8), points) for images, points in taken
            ]
        return self._kept[split]

    def _batches(
        self, people: Sequence[Person], films: Sequence[int]
    ) -> Iterator[tuple[Sequence[Recipe], ...]]:
        """Yield recipes of the same scenes on each film, a few of one size at a time."""
        alike: dict[float, list[tuple[Recipe, ...]]] = {}
        for scene in zip(*(self.recipes(people, film) for film in films), strict=True):
            alike.setdefault(scene[0].film.ipd_px, []).append(scene)
        for members in alike.values():
            for start in range(0, len(members), CHUNK):
                yield tuple(zip(*members[start : start + CHUNK], strict=True))

    def _stacked(self, recipes: Sequence[Recipe], camera: Camera) -> Pair:
        return stack(list(self.taken(recipes, camera)))
