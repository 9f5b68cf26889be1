"""Which faces does an embedder learn from? Rendered people, each seen in many ways.

Each person to learn is rendered a few times **sharp** (about as large as the aligned crop, so that
training can make any smaller face of them) and a few times **small** (as the camera really delivers
them at 7 to 16 px between the eyes). Other people choose the best epoch.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import DataLoader, TensorDataset

from lrsr.camera import Camera
from lrsr.configuration import as_list, as_number, as_whole, require
from lrsr.identities.person import Person
from lrsr.images import resize_bicubic, scale_points
from lrsr.pictures.picture import Picture, stack
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.recognition.alignment import align
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.training.order import EpochOrder
from lrsr.training.rendered import Rendered
from lrsr.training.variety import Variety

_LARGE_PX = 32.0  # between the eyes: from here on a validation view takes `sharp_samples`


@dataclass(kw_only=True, eq=False)
class Faces(Rendered):
    """Aligned faces of people to learn, and sets of validation faces that meet a gallery.

    See the base's attributes, too; ``quality`` is that of the small views.

    Attributes:
        variety: Poses, lights and expressions.
        gallery_lighting: Of the validation gallery, frontal.
        probe_lighting: Of the validation probes, frontal.
        validation_ipd_px: Sizes of the validation probes.
        sharp_views: Renderings per person at ``sharp_ipd_px``; the first one is frontal.
        small_views: Renderings per person at ``small_ipd_px``.
        sharp_ipd_px: Lowest and highest IPD of the sharp views, px.
        small_ipd_px: Lowest and highest IPD of the small views, px.
        compressions: A small view is shown after each.
        enlargements: And each time enlarged bicubically by each of these; 1 is as it is.
        sharp_samples: Rays per pixel of sharp views.
        validation_samples: Rays per pixel of small validation views; an experiment takes 2048.
        antialias: Average when alignment makes a face smaller; goes into the contract.
        views: Faces of each person in an epoch, half of them sharp where there are both kinds.

    Raises:
        InputError: A value is out of its range.
    """

    variety: Variety
    gallery_lighting: Lighting
    probe_lighting: Lighting
    validation_ipd_px: Sequence[float]
    sharp_views: int
    small_views: int
    sharp_ipd_px: Sequence[float]
    small_ipd_px: Sequence[float]
    compressions: Sequence[str]
    enlargements: Sequence[int]
    sharp_samples: int
    validation_samples: int
    antialias: bool
    views: int

    def __post_init__(self) -> None:
        super().__post_init__()
        least = {"sharp_views": 1, "small_views": 0, "views": 1, "batch_size": 2}
        for name, count in least.items():
            value = getattr(self, name)
            require(value >= count, f"data.{name}", value, f"at least {count}")
        for name in ("sharp_ipd_px", "small_ipd_px"):
            given = as_list(getattr(self, name), f"data.{name}")
            ipds = [as_number(ipd, f"data.{name}") for ipd in given]
            holds = len(ipds) == 2 and 0 < ipds[0] <= ipds[1]
            require(holds, f"data.{name}", ipds, "0 < lowest <= highest")
        for ipd in self.validation_ipd_px:
            as_number(ipd, "data.validation_ipd_px")
        for factor in self.enlargements:
            as_whole(factor, "data.enlargements")
        require(len(self.people) >= 2, "identities.count", len(self.people), "at least 2")
        self.cameras = [self.camera.compressing(name) for name in self.compressions]
        self.plain, self.clean = self.camera.compressing("none"), self.camera.clean()
        self.enrolled = Scene(self.gallery_lighting, lens=self.lens, standpoint=self.standpoint)

    def training_recipes(self) -> list[Recipe]:
        """Return every view of every person to learn: person by person, sharp ones first."""
        return [view for person in self.people for view in self._views(person)]

    def validation_recipes(self) -> dict[str, list[Recipe]]:
        """Return the views of the validation people: "gallery", then "ipd64", "ipd14", ..."""
        probed = replace(
            self.enrolled,
            lighting=self.probe_lighting,
            expression=self.expression,
            another_day=self.another_day,
        )
        probes = {f"ipd{ipd:g}": self._frontal(ipd, probed) for ipd in self.validation_ipd_px}
        return {"gallery": self._frontal(64.0, self.enrolled), **probes}

    def _views(self, person: Person) -> Iterator[Recipe]:
        rng = np.random.default_rng(derived_seed(self.seed, "faces", person.index))
        of_expression = np.random.default_rng(derived_seed(self.seed, "expressions", person.index))
        for view in range(self.sharp_views + self.small_views):
            sharp = view < self.sharp_views
            low, high = self.sharp_ipd_px if sharp else self.small_ipd_px
            pose, lighting = self.variety.pose(rng), self.variety.lighting(rng)
            expression = self.variety.expression(of_expression)
            scene = replace(self.enrolled, lighting=lighting)
            if view > 0:
                expression = expression if expression.units else self.expression
                day = self.another_day.later(view - 1)
                scene = replace(scene, pose=pose, expression=expression, another_day=day)
            film = Film(round(rng.uniform(low, high), 2))
            quality = self._sampled(self.sharp_samples) if sharp else self.quality
            seed = derived_seed(self.seed, "faces", person.index, view)
            yield Recipe(person, scene, film, quality, seed)

    def _frontal(self, ipd_px: float, scene: Scene) -> list[Recipe]:
        samples = self.sharp_samples if ipd_px >= _LARGE_PX else self.validation_samples
        return [
            Recipe(person, scene, Film(ipd_px), self._sampled(samples)).seeded(self.seed, "probe")
            for person in self.validation_people
        ]

    def _sampled(self, samples: int) -> Quality:
        return replace(self.quality, samples_per_pixel=samples)

    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""
        for name, recipes in self.validation_recipes().items():
            yield from product(recipes, [self._validating(name)])
        yield from product(self.training_recipes(), [self.plain])

    def _validating(self, name: str) -> Camera:
        return self.clean if name == "gallery" else self.plain

    def setup(self, stage: str | None = None) -> None:
        """Take and align all faces, once: a sharp view once, a small one in all its guises.

        Args:
            stage: Lightning's; all stages need both.
        """
        if hasattr(self, "faces"):
            return
        recipes, each = self.training_recipes(), self.sharp_views + self.small_views
        is_sharp = np.arange(len(recipes)) % each < self.sharp_views
        sharp, small = np.flatnonzero(is_sharp), np.flatnonzero(~is_sharp)
        crops: list[torch.Tensor] = []
        rows: list[int] = []
        guises = [(small, camera, self.enlargements) for camera in self.cameras]
        for members, camera, factors in [(sharp, self.plain, [1]), *guises]:
            pictures = self.taken([recipes[row] for row in members], camera)
            for row, picture in zip(members, pictures, strict=True):
                crops += [self._crop(picture, factor) for factor in factors]
                rows += [int(row)] * len(factors)
        at = torch.tensor(rows)
        self.faces = TensorDataset(torch.stack(crops), at // each, at % each < self.sharp_views)
        self.validation: Any = []
        for name, recipes in self.validation_recipes().items():
            pictures = self.taken(recipes, self._validating(name))
            self.validation.append((name, torch.stack([self._crop(one) for one in pictures])))

    def _crop(self, picture: Picture, factor: int = 1) -> torch.Tensor:
        """Enlarge a picture bicubically by ``factor`` and align it: ``(3, 112, 112)`` uint8."""
        image, landmarks = picture.image[None], stack([picture])[1]
        if factor > 1:
            image = resize_bicubic(image, factor).clamp(0, 1)
        crops, _ = align(image, scale_points(landmarks, factor).numpy(), antialias=self.antialias)
        return crops[0].mul(255).round().to(torch.uint8)

    def train_dataloader(self) -> DataLoader[tuple[torch.Tensor, ...]]:
        """Return batches of crops ``(B, 3, 112, 112)`` uint8, who each is, and which are sharp."""
        _, people, sharp = (tensor.numpy() for tensor in self.faces.tensors)
        draw = partial(_draw_views, people, sharp, self.views)
        order = EpochOrder(draw, batch_size=self.batch_size, seed=self.seed)
        return DataLoader(self.faces, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[tuple[str, torch.Tensor]]:
        """Return sets of faces: a name and ``(people, 3, 112, 112)`` uint8; the gallery first."""
        return DataLoader(self.validation, batch_size=None)


def _draw_views(
    people: NDArray[np.int64], sharp: NDArray[np.bool_], views: int, rng: np.random.Generator
) -> NDArray[np.int64]:
    """Draw rows of every person, half of them sharp where there are both kinds.

    Args:
        people: ``(N,)``, 0, 1, ...
        sharp: ``(N,)``.
        views: Rows of each person.
        rng: Source of the choice.

    Returns:
        ``(people * views,)``, person by person.
    """
    drawn = []
    for person in range(int(people.max()) + 1):
        kinds = [np.flatnonzero((people == person) & (sharp == kind)) for kind in (True, False)]
        kinds = [rows for rows in kinds if len(rows)]
        for number, rows in enumerate(kinds):
            share = (views + number) // len(kinds)
            drawn.append(rng.choice(rows, share, replace=share > len(rows)))
    return np.concatenate(drawn)
