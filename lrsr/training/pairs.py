"""What does a super-resolution network train on? Pictures, rendered on the fly where missing.

The low-resolution input is no shrunken picture: it is the ×1 film of the scene through the camera,
compressed, and the target is the ×2 or ×4 film of the same scene, with the same exposure and
without the camera's flaws. Film and reference are aligned by construction.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import torch
from torch.utils.data import DataLoader, TensorDataset

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
from lrsr.training.order import EpochOrder
from lrsr.training.patches import Pair, Patches
from lrsr.training.rendered import Rendered


@dataclass(kw_only=True, eq=False)
class Pairs(Rendered):
    """Patches for training, whole srgb pictures for validation; see the base's attributes, too.

    ``prepare_data`` renders what the cache lacks, with a bar; ``setup`` cuts the patches into two
    contiguous tensors (SRCNN: 6 kB a pair; 9 patches of a 64×64 target, 49 of 128×128). Targets are
    taken without the camera's flaws, with its exposure.

    Attributes:
        scale: 2, 3 or 4, how many times larger the target is.
        poses: How heads may be held.
        lightings: What light may reach them.
        ipd_px: Interpupillary distances of the ×1 film, px.
        views: How many of the poses × lightings × distances each person is seen in, drawn by seed.
        compressions: Of the input; the target has none.
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
    compressions: Sequence[str]
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
        self.cameras = [self.camera.compressing(name) for name in self.compressions]
        self.clean = self.camera.clean()
        self._check()

    def _check(self) -> None:
        count = len(self.conditions)
        require(count > 0, "data.poses, lightings, ipd_px", [], "at least one of each")
        require(self.scale in (2, 3, 4), "data.scale", self.scale, "2, 3 or 4")
        wish = f"1 to {count}, the number of poses x lightings x distances"
        require(1 <= self.views <= count, "data.views", self.views, wish)
        fit = all(hr == lr * self.scale for lr, hr in self.steps)
        require(fit, "data.films", self.steps, f"films that differ by the factor {self.scale}")
        require(len(self.cameras) > 0, "data.compressions", [], "at least one")
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
        for people, films in product((self.people, self.validation_people), self.steps):
            for film, camera in zip(films, (self.cameras[0], self.clean), strict=True):
                for recipe in self.recipes(people, film):
                    yield recipe, camera

    def setup(self, stage: str | None = None) -> None:
        """Cut the training patches and take the validation pictures, once.

        Args:
            stage: Lightning's; all stages need both.
        """
        if hasattr(self, "train_patches"):
            return
        cut = [self.patches.cut(*batch) for batch in self._batches(self.people)]
        self.train_patches = TensorDataset(*map(torch.cat, zip(*cut, strict=True)))
        whole = self._batches(self.validation_people)
        self.validation_pairs: Any = [
            one for batch in whole for one in zip(*batch[:2], strict=True)
        ]

    def _batches(self, people: Sequence[Person]) -> Iterator[tuple[torch.Tensor, ...]]:
        """Yield small and true srgb pictures, each batch of one size, and the true landmarks."""
        for camera, (lr_film, hr_film) in product(self.cameras, self.steps):
            both = zip(self.recipes(people, lr_film), self.recipes(people, hr_film), strict=True)
            alike: dict[float, list[tuple[Recipe, Recipe]]] = {}
            for pair in both:
                alike.setdefault(pair[0].film.ipd_px, []).append(pair)
            for members in alike.values():
                for start in range(0, len(members), CHUNK):
                    small, true = zip(*members[start : start + CHUNK], strict=True)
                    inputs, _ = stack(list(self.taken(small, camera)))
                    yield inputs, *stack(list(self.taken(true, self.clean)))

    def train_dataloader(self) -> DataLoader[tuple[torch.Tensor, ...]]:
        """Return batches of what the network takes and should return, in the epoch's order."""
        rows = np.arange(len(self.train_patches))
        order = EpochOrder(lambda rng: rows.copy(), batch_size=self.batch_size, seed=self.seed)
        return DataLoader(self.train_patches, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[Pair]:
        """Return whole srgb pictures, ``(1, 3, H, W)`` small and true, one at a time, in order."""
        return DataLoader(self.validation_pairs, batch_size=1)
