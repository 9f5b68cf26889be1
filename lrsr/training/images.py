"""What does a super-resolution network learn from pictures? Any folder, by the field's protocol.

Pictures are cropped to a multiple of the scale, the small ones made of them, and the PSNR is that
of whole pictures (Dong et al. 2016, arXiv:1501.00092, section 4).
"""

import hashlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.camera import Camera
from lrsr.camera.spectral import SpectralColour
from lrsr.configuration import as_number, as_whole, require
from lrsr.errors import InputError
from lrsr.paths import path_if_any, user_path
from lrsr.pictures.folder import read_folder
from lrsr.pictures.image_files import read_image
from lrsr.pictures.recipe import derived_seed
from lrsr.training.patches import Pair, Patches
from lrsr.training.patchwork import Batch, Patchwork
from lrsr.training.shrinking.shrinking import Shrinking

_TOGETHER = 16
"""Pictures of one size that are shrunk at once."""

_OF_PEOPLE = ("identities", "rendering", "lens", "standpoint", "expression", "another_day")


@dataclass(kw_only=True, eq=False)
class Images(Patchwork):
    """Patches of pictures for training, whole ones for validation; see the base's attributes, too.

    Attributes:
        root: Folder of the pictures, see :func:`lrsr.pictures.folder.read_folder`.
        scale: 2, 3 or 4, how many times smaller they become.
        degradation: How.
        camera: The configured one.
        pictures: How many are learned from, drawn by the seed so that fewer are among more; None:
            all.
        crop_px: Side of the square that an epoch shows of a larger picture; None: all of it.
        validation_root: Folder of what is validated on; None: a part of ``root``.
        validation_fraction: Which part, 0 to 1, at least one picture; drawn by the seed.
        patches: Cuts what the network takes and what it should return.

    Raises:
        InputError: A setting is out of range, there are too few pictures, one is in both parts, or
            the camera cannot take pictures for light.
    """

    root: Path
    scale: int
    degradation: Shrinking
    camera: Camera
    pictures: int | None = None
    crop_px: int | None = None
    validation_root: Path | None = None
    validation_fraction: float = 0.1
    patches: Patches
    batch_size: int
    seed: int

    def __post_init__(self) -> None:
        super().__init__()
        self.root = user_path(self.root, "data.root")
        self.validation_root = path_if_any(self.validation_root, "data.validation_root")
        for name in ("scale", "batch_size", "seed"):
            setattr(self, name, as_whole(getattr(self, name), f"data.{name}"))
        require(self.scale in (2, 3, 4), "data.scale", self.scale, "2, 3 or 4")
        require(self.batch_size >= 1, "data.batch_size", self.batch_size, "a number >= 1")
        self._check_crop()
        if self.degradation.reads_camera and isinstance(self.camera.colour, SpectralColour):
            raise InputError(
                f"camera={self.camera.name}: its measured filters look at spectral bands, and"
                " pictures have three colours; choose another camera, or data=rendered"
            )
        self.learned, self.judged = self._parted()
        if both := {*self.learned} & {*self.judged}:
            raise InputError(f"{min(both)} is to be learned and to validate: choose other folders")

    def _check_crop(self) -> None:
        if self.crop_px is None:
            return
        self.crop_px = as_whole(self.crop_px, "data.crop_px")
        least = self.scale * self.patches.least_px(self.scale)
        wish = f"null, or at least the {least} px of a patch"
        require(self.crop_px >= least, "data.crop_px", self.crop_px, wish)

    def _parted(self) -> tuple[list[Path], list[Path]]:
        """Return the files to learn from and those to validate on."""
        files = _files(self.root)
        np.random.default_rng(derived_seed(self.seed, "pictures")).shuffle(files)
        if self.validation_root is not None:
            judged = _files(self.validation_root)
        else:
            share = as_number(self.validation_fraction, "data.validation_fraction")
            require(0 < share < 1, "data.validation_fraction", share, "a number > 0 and < 1")
            count = max(1, round(share * len(files)))
            judged, files = files[:count], files[count:]
        most = len(files)
        wish = f"more than the {len(judged)} to validate on, or data.validation_root=DIR"
        require(most > 0, "data.root", f"{self.root} with 1 picture", wish)
        if self.pictures is not None:
            self.pictures = as_whole(self.pictures, "data.pictures")
            wish = f"1 to {most}, or null: so many are left to learn from"
            require(1 <= self.pictures <= most, "data.pictures", self.pictures, wish)
        return files[: self.pictures], judged

    def about(self) -> dict[str, Any]:
        """Return what all of it depends on, in plain values: which files, by name and size."""
        return {
            "pictures": len(self.learned),
            "validation_pictures": len(self.judged),
            "files": _digest(self.learned),
            "validation_files": _digest(self.judged),
        }

    @property
    def unread(self) -> Mapping[str, str]:
        """Return sections of the configuration that change nothing, and why."""
        unread = dict.fromkeys(_OF_PEOPLE, "data=images shows nobody rendered; leave it")
        if not self.degradation.reads_camera:
            unread["camera"] = "only degradation=camera reads it; leave it, or give that"
        return unread

    @property
    def redrawn(self) -> bool:
        """Do the pairs differ from epoch to epoch?"""
        return self.degradation.redrawn or any(self._is_cropped(one) for one in self._read)

    @property
    def lr_made_by(self) -> str:
        """How the small pictures are made, in words."""
        return self.degradation.in_words(self.camera, of_films=False)

    def read(self) -> None:
        """Read the pictures to learn from, once.

        Raises:
            InputError: A file is no picture, or smaller than a patch.
        """
        if not hasattr(self, "_read"):
            self._read = [self._stored(path) for path in self.learned]

    def setup(self, stage: str | None = None) -> None:
        """Read the pictures, then see the base.

        Args:
            stage: Lightning's; all stages need both.
        """
        self.read()
        super().setup(stage)

    def _stored(self, path: Path) -> torch.Tensor:
        """Read a picture in 8 bits, cropped to a multiple of the scale.

        Raises:
            InputError: The file is no picture, or smaller than a patch.
        """
        image = read_image(path)
        height, width = (side - side % self.scale for side in image.shape[1:])
        least = self.scale * self.patches.least_px(self.scale)
        if min(height, width) < least:
            raise InputError(
                f"{path} has {image.shape[2]}x{image.shape[1]} pixels: wanted {least} or more on"
                " each side, as a patch is; take it away"
            )
        return image[:, :height, :width].mul(255).round().to(torch.uint8)

    def pairs(self, epoch: int | None) -> Iterator[Batch]:
        """Yield small and true srgb pictures, a few of one size at a time."""
        if epoch is None:
            for index, path in enumerate(self.judged):
                yield from self._shrunk([self._stored(path)], epoch, index)
            return
        alike: dict[torch.Size, list[torch.Tensor]] = {}
        for index, picture in enumerate(self._read):
            shown = self._cropped(picture, epoch, index) if self._is_cropped(picture) else picture
            alike.setdefault(shown.shape, []).append(shown)
        start = 0
        for members in alike.values():
            for first in range(0, len(members), _TOGETHER):
                few = members[first : first + _TOGETHER]
                yield from self._shrunk(few, epoch, start)
                start += len(few)

    def _shrunk(
        self, pictures: Sequence[torch.Tensor], epoch: int | None, start: int
    ) -> Iterator[Pair]:
        seeds = self.degradation_seeds(epoch, start, len(pictures))
        return self.degradation(torch.stack([*pictures]) / 255, self.scale, seeds, self.camera)

    def _is_cropped(self, picture: torch.Tensor) -> bool:
        return self.crop_px is not None and max(picture.shape[1:]) > self.crop_px

    def _cropped(self, picture: torch.Tensor, epoch: int, index: int) -> torch.Tensor:
        """Cut the square, or what there is of it, that an epoch shows."""
        rng = np.random.default_rng(derived_seed(self.seed, "crop", epoch, index))
        most = (self.crop_px or 0) // self.scale * self.scale
        height, width = (min(side, most) for side in picture.shape[1:])
        top = int(rng.integers(picture.shape[1] - height + 1))
        left = int(rng.integers(picture.shape[2] - width + 1))
        return picture[:, top : top + height, left : left + width]


def _files(folder: Path) -> list[Path]:
    """Return the pictures of a folder, in the order of their names.

    Raises:
        InputError: See :func:`lrsr.pictures.folder.read_folder`.
    """
    return sorted((folder / entry.file).resolve() for entry in read_folder(folder))


def _digest(paths: Sequence[Path]) -> str:
    told = "".join(f"{path.name} {path.stat().st_size}\n" for path in paths)
    return hashlib.sha256(told.encode()).hexdigest()[:16]
