"""Which faces does an embedder learn from? Rendered people, each seen in many ways.

Each person to learn is rendered a few times **sharp** (about as large as the aligned crop, so that
training can make any smaller face of them) and a few times **small** (as the camera really delivers
them at 7 to 16 px between the eyes). Other people choose the best epoch.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from torch.utils.data import DataLoader, TensorDataset

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL, Expression
from lrsr.identities.person import Person
from lrsr.images import resize_bicubic, scale_points
from lrsr.pictures.maker import Maker
from lrsr.pictures.picture import Picture
from lrsr.pictures.recipe import Recipe, derived_seed
from lrsr.recognition.alignment import align
from lrsr.rendering.lens import Lens
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import FRONTAL, Pose
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.rendering.standpoint import Standpoint
from lrsr.training.order import EpochOrder
from lrsr.training.rendered import Rendered
from lrsr.training.variety import Variety

_LARGE_PX = 32.0  # between the eyes: from here on a validation view takes `sharp_samples`


class Faces(Rendered):
    """Aligned faces of people to learn, and sets of validation faces that meet a gallery.

    Args:
        people: See :class:`Rendered`; at least 2, as the next one.
        validation_people: Who meets the gallery.
        poses: Named ones; see :class:`~lrsr.training.variety.Variety`, as the next three.
        lightings: Named ones.
        expressions: Shown at 20 to 80 %.
        named_share: How often a named pose or lighting is drawn instead of a random one, 0..1.
        lens: Of every picture.
        standpoint: Of every picture.
        gallery_lighting: Of the validation gallery, frontal.
        probe_lighting: Of the validation probes, frontal.
        validation_ipd_px: Sizes of the validation probes.
        sharp_views: Renderings per person at ``sharp_ipd_px``; the first one is frontal.
        small_views: Renderings per person at ``small_ipd_px``.
        sharp_ipd_px: Lowest and highest IPD of the sharp views, px.
        small_ipd_px: Lowest and highest IPD of the small views, px.
        expression_share: How many of the views, but never the first, show a mild expression, 0..1.
        compressions: A small view is shown after each.
        enlargements: And each time enlarged bicubically by each of these; 1 is as it is.
        quality: Of the renderings; its rays are those of the small views.
        sharp_samples: Rays per pixel of sharp views.
        validation_samples: Rays per pixel of small validation views; an experiment takes 2048.
        camera: Takes the pictures; its own compression is not used.
        antialias: Average when alignment makes a face smaller; goes into the contract.
        views: Faces of each person in an epoch, half of them sharp where there are both kinds.
        batch_size: Faces in a step.
        seed: Poses, lights, samplers and the order follow from it, any whole number.
        cache: See :class:`Rendered`, as the next two.
        progress: Of rendering.
        maker: Of renderings.

    Raises:
        InputError: A value is out of its range.
    """

    def __init__(
        self,
        people: Sequence[Person],
        validation_people: Sequence[Person],
        *,
        poses: Sequence[Pose],
        lightings: Sequence[Lighting],
        expressions: Sequence[Expression],
        named_share: float,
        lens: Lens,
        standpoint: Standpoint,
        gallery_lighting: Lighting,
        probe_lighting: Lighting,
        validation_ipd_px: Sequence[float],
        sharp_views: int,
        small_views: int,
        sharp_ipd_px: Sequence[float],
        small_ipd_px: Sequence[float],
        expression_share: float,
        compressions: Sequence[str],
        enlargements: Sequence[int],
        quality: Quality,
        sharp_samples: int,
        validation_samples: int,
        camera: Camera,
        antialias: bool,
        views: int,
        batch_size: int,
        seed: int,
        cache: Path | None = None,
        progress: bool = True,
        maker: Maker | None = None,
    ) -> None:
        super().__init__(people, validation_people, cache=cache, progress=progress, maker=maker)
        self.variety = Variety(poses, lightings, expressions, named_share)
        self.enrolled = Scene(gallery_lighting, lens=lens, standpoint=standpoint)
        self.probed = replace(self.enrolled, lighting=probe_lighting)
        self.validation_ipd_px = validation_ipd_px
        self.sharp_views, self.small_views = sharp_views, small_views
        self.sharp_ipd_px, self.small_ipd_px = sharp_ipd_px, small_ipd_px
        self.expression_share, self.enlargements = expression_share, enlargements
        self.cameras = [camera.compressing(name) for name in compressions]
        self.plain, self.clean = camera.compressing("none"), camera.clean()
        self.quality = quality
        self.sharp_quality = replace(quality, samples_per_pixel=sharp_samples)
        self.validation_quality = replace(quality, samples_per_pixel=validation_samples)
        self.antialias, self.views, self.batch_size, self.seed = antialias, views, batch_size, seed
        self._check()

    def _check(self) -> None:
        least = {"sharp_views": 1, "small_views": 0, "views": 1, "batch_size": 2}
        wanted: dict[str, tuple[bool, object, str]] = {
            f"data.{name}": (getattr(self, name) >= count, getattr(self, name), f"at least {count}")
            for name, count in least.items()
        }
        for name in ("sharp_ipd_px", "small_ipd_px"):
            ipds = [float(ipd) for ipd in getattr(self, name)]
            holds = len(ipds) == 2 and 0 < ipds[0] <= ipds[1]
            wanted[f"data.{name}"] = (holds, ipds, "0 < lowest <= highest")
        share, both = self.expression_share, (len(self.people), len(self.validation_people))
        wanted["data.expression_share"] = (0 <= share <= 1, share, "0 to 1")
        wanted["people and validation people"] = (min(both) >= 2, both, "at least 2 of each")
        for name, (holds, value, wish) in wanted.items():
            if not holds:
                raise InputError(f"{name}={value}: wanted {wish}")

    def training_recipes(self) -> list[Recipe]:
        """Return every view of every person to learn: person by person, sharp ones first."""
        return [view for person in self.people for view in self._views(person)]

    def validation_recipes(self) -> dict[str, list[Recipe]]:
        """Return the views of the validation people: "gallery", then "ipd64", "ipd14", ..."""
        probes = {f"ipd{ipd:g}": self._frontal(ipd, self.probed) for ipd in self.validation_ipd_px}
        return {"gallery": self._frontal(64.0, self.enrolled), **probes}

    def _views(self, person: Person) -> Iterator[Recipe]:
        rng = np.random.default_rng(derived_seed(self.seed, "faces", person.index))
        of_expression = np.random.default_rng(derived_seed(self.seed, "expressions", person.index))
        for view in range(self.sharp_views + self.small_views):
            sharp = view < self.sharp_views
            low, high = self.sharp_ipd_px if sharp else self.small_ipd_px
            pose, lighting = self.variety.pose(rng), self.variety.lighting(rng)
            acted = self.variety.expression(of_expression)
            acting = view > 0 and of_expression.random() < self.expression_share
            scene = replace(
                self.enrolled,
                lighting=lighting,
                pose=pose if view else FRONTAL,
                expression=acted if acting else NEUTRAL,
            )
            yield Recipe(
                person,
                scene,
                Film(round(rng.uniform(low, high), 2)),
                self.sharp_quality if sharp else self.quality,
                seed=derived_seed(self.seed, "faces", person.index, view),
            )

    def _frontal(self, ipd_px: float, scene: Scene) -> list[Recipe]:
        quality = self.sharp_quality if ipd_px >= _LARGE_PX else self.validation_quality
        return [
            Recipe(person, scene, Film(ipd_px), quality, seed=0).seeded(self.seed, "probe")
            for person in self.validation_people
        ]

    def shots(self) -> Iterator[tuple[Recipe, Camera]]:
        """Yield every picture that is needed and who takes it."""
        for name, recipes in self.validation_recipes().items():
            yield from product(recipes, [self.clean if name == "gallery" else self.plain])
        yield from product(self.training_recipes(), [self.plain])

    def setup(self, stage: str | None = None) -> None:
        """Take and align all faces, once: a sharp view once, a small one in all its guises.

        Args:
            stage: Lightning's; all stages need both.
        """
        if hasattr(self, "faces"):
            return
        recipes, each = self.training_recipes(), self.sharp_views + self.small_views
        sharp = [row for row in range(len(recipes)) if row % each < self.sharp_views]
        small = [row for row in range(len(recipes)) if row % each >= self.sharp_views]
        crops: list[torch.Tensor] = []
        rows: list[int] = []
        shown = [(sharp, self.plain, [1]), *((small, one, self.enlargements) for one in self.cameras)]
        for members, camera, factors in shown:
            pictures = self.taken([recipes[row] for row in members], camera)
            for row, picture in zip(members, pictures, strict=True):
                crops += [self._crop(picture, factor) for factor in factors]
                rows += [row] * len(factors)
        at = torch.tensor(rows)
        self.faces = TensorDataset(torch.stack(crops), at // each, at % each < self.sharp_views)
        self.validation: Any = [
            (
                name,
                torch.stack(
                    [
                        self._crop(picture, 1)
                        for picture in self.taken(
                            recipes, self.clean if name == "gallery" else self.plain
                        )
                    ]
                ),
            )
            for name, recipes in self.validation_recipes().items()
        ]

    def _crop(self, picture: Picture, factor: int) -> torch.Tensor:
        """Enlarge a picture bicubically by ``factor`` and align it: ``(3, 112, 112)`` uint8."""
        image, landmarks = picture.image[None], picture.landmarks_px
        if factor > 1:
            image = resize_bicubic(image, factor).clamp(0, 1)
        crops, _ = align(image, scale_points(landmarks, factor)[None].numpy(), antialias=self.antialias)
        return crops[0].mul(255).round().to(torch.uint8)

    def train_dataloader(self) -> DataLoader[tuple[torch.Tensor, ...]]:
        """Return batches of crops ``(B, 3, 112, 112)`` uint8, who each is, and which are sharp."""
        _, people, sharp = (tensor.numpy() for tensor in self.faces.tensors)
        draw = partial(draw_views, people, sharp, self.views)
        order = EpochOrder(draw, batch_size=self.batch_size, seed=self.seed)
        return DataLoader(self.faces, sampler=order, batch_size=None)

    def val_dataloader(self) -> DataLoader[tuple[str, torch.Tensor]]:
        """Return sets of faces, a name and ``(people, 3, 112, 112)`` uint8 each, the gallery first."""
        return DataLoader(self.validation, batch_size=None)


def draw_views(
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
