"""What does a super-resolution network train on? Probes, rendered on the fly where missing.

The low-resolution input is no shrunken picture: it is the ×1 film of the scene through the camera,
compressed, and the target is the ×2 or ×4 film of the same scene, with the same exposure and
without the camera's flaws. Film and reference are aligned by construction.
"""

import random
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

import torch
from lightning import LightningDataModule
from lrsr.data.cache import RenderCache
from lrsr.data.maker import Maker
from lrsr.data.probes import filmed, load_probes, render_missing, stack
from lrsr.data.recipe import ProbeRecipe, derived_seed
from torch.utils.data import BatchSampler, DataLoader, RandomSampler

from lrsr.camera import Camera
from lrsr.data.patches import PairDataset, PatchDataset, cut_patches, luminance_pair
from lrsr.errors import InputError
from lrsr.identities.roster import UNCHECKED, Cast
from lrsr.identities.splits import Split
from lrsr.paths import cache_folder
from lrsr.rendering.geometry import film_size_px

if TYPE_CHECKING:
    from lrsr.rendering.lens import Lens
    from lrsr.rendering.scene import Lighting, Pose
    from lrsr.rendering.skin import Skin
    from lrsr.rendering.standpoint import Standpoint

Pair = tuple[torch.Tensor, torch.Tensor]
_CHUNK = 64


class ProbeDataModule(LightningDataModule):
    """Luminance patches for training, whole images for validation, of people who share nothing.

    Training people are ``start`` to ``start + count - 1`` of the split "train"; validation people
    come from the split "validation", which is disjoint from it and from "test" by construction.
    ``prepare_data`` renders what the cache lacks, with a bar; ``setup`` cuts the patches into two
    contiguous tensors (6 kB a pair of patches; 9 patches of a 64×64 target, 49 of 128×128).

    Args:
        scale: 2 or 4, how many times larger the target is.
        count: Training people, >= 1.
        start: Number of the first one.
        validation_fraction: Validation people per training person, rounded, at least one.
        poses: Names or poses.
        lightings: Names or lightings.
        ipd_px: Interpupillary distances of the ×1 film, px, one or several.
        compressions: Of the input; the target has none.
        views: How many of the poses × lightings × distances each person is seen in, drawn by
            ``seed``; None: all.
        pairs: Scales of the films of input and target, e.g. ``[[1, 2], [2, 4]]``: the second pair
            shows a 2× network that is applied twice what its second pass meets. None: 1 to scale.
        lens: Of both pictures, name or any surfaces.
        standpoint: Of both pictures, name or any place of the camera.
        camera: Takes the inputs; its own compression is not used. None: the reference camera, which
            takes the targets in any case, with the exposure of this one.
        cache: Folder of the render cache; None: the user's.
        samples_per_pixel: Of the ×1 film.
        texture_size: Of the heads' albedo, px.
        skin: Name of a skin, or any other.
        max_depth: Longest light path.
        batch_size: Patches a step.
        patch_px: Side of an input patch.
        label_px: Side of a target patch.
        stride_px: From patch to patch.
        cast: From whom people are drawn, and who of them was redrawn.
        seed: Of noise, views and the order of the patches.
        workers: Processes that gather batches; 0 is fastest, as everything is in memory.
        progress: Show a bar while rendering.
        maker: Builds and renders; Mitsuba when None.

    Raises:
        InputError: A number is out of range, or the pairs do not fit the scale.
    """

    def __init__(
        self,
        *,
        scale: int = 2,
        count: int = 1000,
        start: int = 0,
        validation_fraction: float = 0.1,
        poses: Sequence["str | Pose"] = ("frontal",),
        lightings: Sequence["str | Lighting"] = ("frontal",),
        ipd_px: float | Sequence[float] = 8.0,
        compressions: Sequence[str] = ("none",),
        views: int | None = None,
        pairs: Sequence[Sequence[int]] | None = None,
        lens: "str | Lens" = "pinhole",
        standpoint: "str | Standpoint" = "level",
        camera: Camera | None = None,
        cache: str | Path | None = None,
        samples_per_pixel: int = 2048,
        texture_size: int = 1024,
        skin: "str | Skin" = "reflective",
        max_depth: int = 5,
        batch_size: int = 128,
        patch_px: int = 33,
        label_px: int = 21,
        stride_px: int = 14,
        cast: Cast = UNCHECKED,
        seed: int = 0,
        workers: int = 0,
        progress: bool = True,
        maker: Maker | None = None,
    ) -> None:
        super().__init__()
        self.scale = scale
        self.count, self.start = count, start
        self.validation_count = max(1, round(count * validation_fraction))
        self.distances = [float(x) for x in (ipd_px if isinstance(ipd_px, Sequence) else [ipd_px])]
        self.conditions = list(product(poses, lightings, self.distances))
        self.views = len(self.conditions) if views is None else views
        self.pairs = [(int(lr), int(hr)) for lr, hr in pairs or [(1, scale)]]
        self.cameras = [(camera or Camera()).compressing(name) for name in compressions]
        self.cache = RenderCache(Path(cache) if cache else cache_folder())
        self.cast = cast
        self.template = ProbeRecipe(
            split="train",
            population=cast.population,
            index=start,
            samples_per_pixel=samples_per_pixel,
            texture_size=texture_size,
            skin=skin,
            max_depth=max_depth,
            lens=lens,
            standpoint=standpoint,
        )
        self.batch_size = batch_size
        self.patch_px, self.label_px, self.stride_px = patch_px, label_px, stride_px
        self.seed, self.workers, self.progress, self.maker = seed, workers, progress, maker
        self._patches: PatchDataset | None = None
        self._images: PairDataset | None = None
        self._check()

    def _check(self) -> None:
        wanted: dict[str, tuple[bool, object, str]] = {
            "ipd_px": (len(self.distances) > 0, [], "at least one"),
            "poses and lightings": (len(self.conditions) > 0, [], "at least one of each"),
            "scale": (self.scale in (2, 4), self.scale, "2 or 4"),
            "count": (self.count >= 1, self.count, "a number >= 1"),
            "views": (
                1 <= self.views <= len(self.conditions),
                self.views,
                f"1 to {len(self.conditions)}, the number of poses x lightings x distances",
            ),
            "pairs": (
                all(hr == lr * self.scale for lr, hr in self.pairs),
                self.pairs,
                f"films that differ by the factor {self.scale}",
            ),
            "compressions": (len(self.cameras) > 0, [], "at least one"),
        }
        for name, (holds, value, wish) in wanted.items():
            if not holds:
                raise InputError(f"data {name}={value}: wanted {wish}")
        for index in (self.start, self.start + self.count - 1):
            self.cast.draw("train", index)  # refuses who is not on the roster
        smallest = film_size_px(min(self.distances)) * min(hr for _, hr in self.pairs)
        if smallest < self.patch_px:
            raise InputError(
                f"data ipd_px={min(self.distances):g}: its targets are {smallest} px wide, smaller"
                f" than a patch of {self.patch_px}; give a larger ipd_px"
            )

    def recipes(self, split: Split, film: int) -> list[ProbeRecipe]:
        """Return what everybody of a split is rendered as, on a film of that scale."""
        first, count = (self.start, self.count)
        if split == "validation":
            first, count = 0, self.validation_count
        return [
            self._recipe(split, index, film, *condition)
            for index in range(first, first + count)
            for condition in self._seen(split, index)
        ]

    def _seen(self, split: Split, index: int) -> list[tuple["str | Pose", "str | Lighting", float]]:
        if self.views == len(self.conditions):
            return self.conditions
        draw = random.Random(derived_seed(self.seed, "views", split, index))
        return draw.sample(self.conditions, self.views)

    def _recipe(
        self,
        split: Split,
        index: int,
        film: int,
        pose: "str | Pose",
        lighting: "str | Lighting",
        ipd_px: float,
    ) -> ProbeRecipe:
        return replace(
            self.template,
            split=split,
            index=index,
            pose=pose,
            lighting=lighting,
            ipd_px=ipd_px,
            scale=film,
            draw=self.cast.draw(split, index),
        ).seeded(self.seed)

    def prepare_data(self) -> None:
        """Render what the cache lacks; stopped at any moment, the next call goes on.

        Raises:
            InputError: The cache cannot be written or the disk is full.
        """
        splits: tuple[Split, ...] = ("train", "validation")
        wanted = [
            recipe
            for split, (lr_film, hr_film) in product(splits, self.pairs)
            for recipe in (
                *(filmed(recipe, self.cameras[0]) for recipe in self.recipes(split, lr_film)),
                *(
                    filmed(recipe, self.cameras[0].clean())
                    for recipe in self.recipes(split, hr_film)
                ),
            )
        ]
        render_missing(wanted, self.cache, progress=self.progress, maker=self.maker)

    def setup(self, stage: str | None = None) -> None:
        """Cut the training patches and enlarge the validation images, once.

        Args:
            stage: Lightning's; all stages need both.
        """
        if self._patches is not None:
            return
        cut = [
            cut_patches(
                *pair, patch_px=self.patch_px, label_px=self.label_px, stride_px=self.stride_px
            )
            for pair in self._batches("train")
        ]
        inputs, targets = zip(*cut, strict=True)
        self._patches = PatchDataset(torch.cat(inputs), torch.cat(targets))
        self._images = PairDataset(
            [single for pair in self._batches("validation") for single in zip(*pair, strict=True)]
        )

    def _batches(self, split: Split) -> Iterator[Pair]:
        """Yield inputs and targets ``(B, 1, H, W)``, each batch of one size."""
        for camera, (lr_film, hr_film) in product(self.cameras, self.pairs):
            lr_recipes, hr_recipes = self.recipes(split, lr_film), self.recipes(split, hr_film)
            for ipd_px in self.distances:
                members = [i for i, recipe in enumerate(lr_recipes) if recipe.ipd_px == ipd_px]
                for start in range(0, len(members), _CHUNK):
                    chunk = members[start : start + _CHUNK]
                    yield luminance_pair(
                        self._images_of([lr_recipes[i] for i in chunk], camera),
                        self._images_of([hr_recipes[i] for i in chunk], camera.clean()),
                    )

    def _images_of(self, recipes: list[ProbeRecipe], camera: Camera) -> torch.Tensor:
        probes = load_probes(recipes, self.cache, camera, progress=self.progress, maker=self.maker)
        return stack(probes)[0]

    def train_dataloader(self) -> DataLoader[Pair]:
        """Return batches of ``(B, 1, 33, 33)`` inputs and ``(B, 1, 21, 21)`` targets, shuffled."""
        patches = _ready(self._patches)
        order = RandomSampler(patches, generator=torch.Generator().manual_seed(self.seed))
        batches = BatchSampler(order, self.batch_size, drop_last=len(patches) >= self.batch_size)
        return DataLoader(patches, sampler=batches, batch_size=None, num_workers=self.workers)

    def val_dataloader(self) -> DataLoader[Pair]:
        """Return whole images, ``(1, 1, H, W)`` input and target, one at a time, in order."""
        return DataLoader(_ready(self._images), batch_size=1, num_workers=self.workers)


_Data = TypeVar("_Data")


def _ready(data: _Data | None) -> _Data:
    if data is None:
        raise RuntimeError("the data module has no data yet: call prepare_data() and setup() first")
    return data
