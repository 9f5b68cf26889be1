"""Synthetic pairs: smooth random pictures, halved, and enlarged again."""

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import torch
from lightning.pytorch import LightningDataModule
from torch.utils.data import DataLoader, Sampler, TensorDataset

from lrsr.images import resize_bicubic
from lrsr.sr.srcnn import SRCNN
from lrsr.sr.weights import Recipe, write_weights


class EpochOrder(Sampler[int]):
    """A shuffle that depends on the epoch alone, so that a resumed run sees the same patches."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.epoch = 0

    def set_epoch(self, epoch: int) -> None:
        self.epoch = epoch

    def __iter__(self) -> Iterator[int]:
        generator = torch.Generator().manual_seed(self.epoch)
        return iter(torch.randperm(self.size, generator=generator).tolist())

    def __len__(self) -> int:
        return self.size


def draw_pictures(count: int, size: int, seed: int) -> torch.Tensor:
    """Discs and bars with sharp edges, (count, 1, size, size), luminance in [16, 235] / 255."""
    generator = torch.Generator().manual_seed(seed)
    y, x = torch.meshgrid(torch.arange(size), torch.arange(size), indexing="ij")
    pictures = torch.full((count, 1, size, size), 0.5)
    for picture in pictures:
        for _ in range(12):
            cx, cy, r, tone = torch.rand(4, generator=generator).tolist()
            inside = (x - cx * size) ** 2 + (y - cy * size) ** 2 < (0.05 + 0.15 * r) ** 2 * size**2
            picture[0, inside] = 0.07 + 0.85 * tone
    return pictures


class SyntheticPairs(LightningDataModule):
    def __init__(self, *, batch_size: int = 16, count: int = 4) -> None:
        super().__init__()
        self.batch_size = batch_size
        self.train_pairs = self._pairs(count, 61, seed=1)
        self.val_pairs = self._pairs(2, 48, seed=2)

    @staticmethod
    def _pairs(count: int, size: int, seed: int) -> tuple[torch.Tensor, torch.Tensor]:
        size += size % 2
        target = draw_pictures(count, size, seed)
        return resize_bicubic(resize_bicubic(target, 0.5), 2), target

    def train_dataloader(self) -> DataLoader[tuple[torch.Tensor, ...]]:
        enlarged, target = self.train_pairs
        patches = enlarged.unfold(2, 33, 14).unfold(3, 33, 14).reshape(-1, 1, 33, 33)
        inner = target[..., 6:-6, 6:-6].unfold(2, 21, 14).unfold(3, 21, 14).reshape(-1, 1, 21, 21)
        dataset = TensorDataset(patches, inner)
        return DataLoader(dataset, batch_size=self.batch_size, sampler=EpochOrder(len(dataset)))

    def val_dataloader(self) -> DataLoader[tuple[torch.Tensor, ...]]:
        return DataLoader(TensorDataset(*self.val_pairs), batch_size=1)


@pytest.fixture
def pairs() -> SyntheticPairs:
    return SyntheticPairs()


@pytest.fixture(scope="session")
def many_pairs() -> SyntheticPairs:
    return SyntheticPairs(batch_size=8, count=80)


@pytest.fixture(autouse=True, scope="session")
def _one_thread() -> Iterator[None]:
    """Two threads on a busy machine are slower than one, and round differently."""
    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)


@pytest.fixture
def weights_file(tmp_path: Path) -> Callable[..., Path]:
    """Write random weights for a scale; near the identity unless told otherwise."""

    def write(scale: int, initialisation: str = "near-identity") -> Path:
        torch.manual_seed(scale)
        path = tmp_path / f"srcnn{scale}x.safetensors"
        network = SRCNN(initialisation=initialisation)
        write_weights(path, network, Recipe(scale=scale, lr_made_by="test"))
        return path

    return write
