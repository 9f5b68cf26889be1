"""What does a super-resolution network train on? Pictures, rendered on the fly where missing.

The low-resolution input is no shrunken picture: it is the ×1 film of the scene through the camera,
compressed, and the target is the ×2 or ×4 film of the same scene, with the same exposure and
without the camera's flaws. Film and reference are aligned by construction.
"""

import random
from collections.abc import Iterator, Sequence
from itertools import groupby, product
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch.utils.data import DataLoader, TensorDataset

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.pictures.maker import Maker
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.pictures.picture import stack
from lrsr.pictures.render import CHUNK
from lrsr.rendering.geometry import film_size_px
from lrsr.rendering.lens import Lens
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.standpoint import Standpoint
from lrsr.training.order import EpochOrder
from lrsr.training.patches import Pair, Patches
from lrsr.training.rendered import Rendered


class Pairs(Rendered):
    """Patches for training, whole srgb pictures for validation.

    ``prepare_data`` renders what the cache lacks, with a bar; ``setup`` cuts the patches into two
    contiguous tensors (SRCNN: 6 kB a pair; 9 patches of a 64×64 target, 49 of 128×128).

    Args:
        people: See :class:`Rendered`, as the next one.
        validation_people: At least one.
        scale: 2 or 4, how many times larger the target is.
        poses: How heads may be held.
        lightings: What light may reach them.
        lens: Of both pictures.
        standpoint: Of both pictures.
        ipd_px: Interpupillary distances of the ×1 film, px.
        views: How many of the poses × lightings × distances each person is seen in, drawn by ``seed``.
        compressions: Of the input; the target has none.
        films: Scales of the films of input and target, e.g. ``[[1, 2], [2, 4]]``: the second pair
            shows a 2× network that is applied twice what its second pass meets. None: 1 to scale.
        quality: Of the renderings.
        camera: Takes the inputs; its own compression is not used. The targets are taken without
            its flaws, with its exposure.
        patches: Cuts what the network takes and what it should return.
        batch_size: Patches a step.
        seed: Of noise, views and the order of the patches, any whole number.
        cache: See :class:`Rendered`, as the next two.
        progress: Of rendering.
        maker: Of renderings.

    Raises:
        InputError: A number is out of range, or the films do not fit the scale.
    """

    def __init__(
        self,
        people: Sequence[Person],
        validation_people: Sequence[Person],
        *,
        scale: int,
        poses: Sequence[Pose],
        lightings: Sequence[Lighting],
        lens: Lens,
        standpoint: Standpoint,
        ipd_px: Sequence[float],
        views: int,
        compressions: Sequence[str],
        films: Sequence[Sequence[int]] | None = None,
        quality: Quality,
        camera: Camera,
        patches: Patches,
        batch_size: int,
        seed: int,
        cache: Path | None = None,
        progress: bool = True,
        maker: Maker | None = None,
    ) -> None:
        super().__init__(people, validation_people, cache=cache, progress=progress, maker=maker)
        self.scale, self.quality, self.patches = scale, quality, patches
        self.distances = [float(x) for x in ipd_px]
        scenes = [Scene(light, pose, lens, standpoint) for pose, light in product(poses, lightings)]
        self.conditions = list(product(scenes, self.distances))
        self.views, self.batch_size, self.seed = views, batch_size, seed
        self.films = [(int(lr), int(hr)) for lr, hr in films or [(1, scale)]]
        self.cameras = [camera.compressing(name) for name in compressions]
        self.clean = camera.clean()
        self._check()

    def _check(self) -> None:
        wanted: dict[str, tuple[bool, object, str]] = {
            "ipd_px": (len(self.distances) > 0, [], "at least one"),
            "poses and lightings": (len(self.conditions) > 0, [], "at least one of each"),
            "scale": (self.scale in (2, 4), self.scale, "2 or 4"),
            "views": (
                1 <= self.views <= len(self.conditions),
                self.views,
                f"1 to {len(self.conditions)}, the number of poses x lightings x distances",
            ),
            "films": (
                all(hr == lr * self.scale for lr, hr in self.films),
                self.films,
                f"films that differ by the factor {self.scale}",
            ),
            "compressions": (len(self.cameras) > 0, [], "at least one"),
            "batch_size": (self.batch_size >= 1, self.batch_size, "a number >= 1"),
        }
        for name, (holds, value, wish) in wanted.items():
            if not holds:
                raise InputError(f"data.{name}={value}: wanted {wish}")
        smallest = film_size_px(min(self.distances)) * min(lr for lr, _ in self.films)
        if smallest < self.patches.least_px(self.scale):
            raise InputError(
                f"data.ipd_px={min(self.distances):g}: its pictures are {smallest} px wide, smaller"
                " than a patch; give a larger ipd_px"
            )

    def recipes(self, people: Sequence[Person], film: int) -> list[Recipe]:
        """Return what everybody is rendered as, on a film of that scale."""
        return [
            Recipe(person, scene, Film(ipd_px, film), self.quality, seed=0).seeded(
                self.seed, "probe"
            )
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
        for people, films in product((self.people, self.validation_people), self.films):
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
        cut = [self.patches.cut(*pair) for pair in self._batches(self.people)]
        inputs, targets = zip(*cut, strict=True)
        self.train_patches = TensorDataset(torch.cat(inputs), torch.cat(targets))
        whole = self._batches(self.validation_people)
        self.validation_pairs: Any = [one for pair in whole for one in zip(*pair, strict=True)]

    def _batches(self, people: Sequence[Person]) -> Iterator[Pair]:
        """Yield small and true srgb pictures, each batch of one size."""
        for camera, (lr_film, hr_film) in product(self.cameras, self.films):
            both = zip(self.recipes(people, lr_film), self.recipes(people, hr_film), strict=True)
            ordered = sorted(both, key=lambda pair: pair[0].film.ipd_px)
            for _, alike in groupby(ordered, key=lambda pair: pair[0].film.ipd_px):
                members = list(alike)
                for start in range(0, len(members), CHUNK):
                    small, true = zip(*members[start : start + CHUNK], strict=True)
                    yield (
                        stack(list(self.taken(small, camera)))[0],
                        stack(list(self.taken(true, self.clean)))[0],
                    )

    def train_dataloader(self) -> DataLoader[Pair]:
        """Return batches of what the network takes and should return, in an order of the epoch's."""
        rows = np.arange(len(self.train_patches))
        order = EpochOrder(lambda rng: rows.copy(), batch_size=self.batch_size, seed=self.seed)
        return DataLoader(self.train_patches, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[Pair]:
        """Return whole srgb pictures, ``(1, 3, H, W)`` small and true, one at a time, in order."""
        return DataLoader(self.validation_pairs, batch_size=1)
