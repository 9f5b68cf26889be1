"""Pairs of films become patches; training and validation share nobody."""

from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.maker import FakeMaker
from lightning import LightningModule, Trainer
from lrsr.data import ProbeDataModule
from lrsr.data.cache import RenderCache
from lrsr.data.patches import PatchDataset, cut_patches
from lrsr.data.probes import load_probes, stack
from omegaconf import OmegaConf

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Cast, Roster
from lrsr.images import luminance, resize_bicubic


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    return tmp_path / "cache"


def module(folder: Path, maker: FakeMaker, **settings: Any) -> ProbeDataModule:
    settings = {"count": 6, "progress": False, **settings}
    return ProbeDataModule(cache=folder, maker=maker, **settings)


def ready(folder: Path, maker: FakeMaker, **settings: Any) -> ProbeDataModule:
    data = module(folder, maker, **settings)
    data.prepare_data()
    data.setup("fit")
    return data


def everything(data: ProbeDataModule) -> tuple[torch.Tensor, torch.Tensor]:
    patches = data.train_dataloader().dataset
    assert isinstance(patches, PatchDataset)
    return patches[range(len(patches))]


def test_patches_are_those_of_the_two_films_through_the_camera(
    folder: Path, maker: FakeMaker
) -> None:
    data = ready(folder, maker, compressions=["heavy"], camera=Camera(exposure_ev=-0.5))
    cache = RenderCache(folder)
    lr, _ = stack(load_probes(data.recipes("train", 1), cache, Camera("heavy", -0.5), maker=maker))
    hr, _ = stack(load_probes(data.recipes("train", 2), cache, Camera("none", -0.5), maker=maker))
    wanted = cut_patches(luminance(resize_bicubic(lr, 2)), luminance(hr))
    inputs, targets = everything(data)
    assert inputs.shape == (6 * 9, 1, 33, 33)
    assert targets.shape == (6 * 9, 1, 21, 21)
    assert torch.allclose(inputs, wanted[0], atol=1e-6)
    assert torch.allclose(targets, wanted[1], atol=1e-6)


def test_input_and_target_show_the_same_place(folder: Path, maker: FakeMaker) -> None:
    inputs, targets = everything(ready(folder, maker, scale=4))
    assert len(inputs) == 6 * 49
    assert float((inputs[..., 6:-6, 6:-6] - targets).square().mean()) < 1e-3
    assert float((inputs[..., :-12, :-12] - targets).square().mean()) > 2e-3


def test_both_films_have_the_lens_and_the_standpoint(folder: Path, maker: FakeMaker) -> None:
    data = module(folder, maker, lens="single", standpoint="scface_far")
    recipes = [*data.recipes("train", 1), *data.recipes("validation", 2)]
    assert {(recipe.lens, recipe.standpoint) for recipe in recipes} == {("single", "scface_far")}


def test_training_and_validation_share_nobody(folder: Path, maker: FakeMaker) -> None:
    data = module(folder, maker, count=40, start=3, validation_fraction=0.25)
    train = {recipe.identity_id for recipe in data.recipes("train", 1)}
    validation = {recipe.identity_id for recipe in data.recipes("validation", 1)}
    assert (len(train), len(validation)) == (40, 10)
    assert not train & validation
    assert min(train) == "train-00003"


def test_validation_gives_whole_images_one_at_a_time(folder: Path, maker: FakeMaker) -> None:
    data = ready(folder, maker, count=20, ipd_px=[8, 11])
    images = list(data.val_dataloader())
    assert [tuple(hr.shape) for _, hr in images] == [(1, 1, 64, 64)] * 2 + [(1, 1, 88, 88)] * 2
    assert all(lr.shape == hr.shape for lr, hr in images)


def test_conditions_multiply(folder: Path, maker: FakeMaker) -> None:
    data = module(
        folder, maker, poses=["frontal", "left"], lightings=["frontal", "side"], ipd_px=[8.0, 9.0]
    )
    assert len(data.recipes("train", 1)) == 6 * 8


def test_every_compression_is_seen_without_a_further_rendering(
    folder: Path, maker: FakeMaker
) -> None:
    inputs, _ = everything(ready(folder, maker, compressions=["none", "small", "heavy"]))
    assert len(inputs) == 3 * 6 * 9
    assert len(maker.renders) == 2 * (6 + 1)


def test_views_are_drawn_for_each_person_and_the_same_for_every_film(
    folder: Path, maker: FakeMaker
) -> None:
    settings: dict[str, Any] = {
        "poses": ["frontal", "left", "up", "down"],
        "lightings": ["frontal", "side"],
        "count": 30,
        "views": 2,
    }
    data = module(folder, maker, **settings)
    lr, hr = data.recipes("train", 1), data.recipes("train", 2)
    assert len(lr) == 60
    assert [(r.index, r.pose, r.lighting) for r in lr] == [
        (r.index, r.pose, r.lighting) for r in hr
    ]
    assert len({(r.pose, r.lighting) for r in lr}) == 8
    assert lr == module(folder, maker, **settings).recipes("train", 1)
    assert lr != module(folder, maker, **settings, seed=1).recipes("train", 1)


def test_pairs_add_films(folder: Path, maker: FakeMaker) -> None:
    data = ready(folder, maker, pairs=[[1, 2], [2, 4]])
    assert {recipe.scale for recipe in maker.renders} == {1, 2, 4}
    assert len(everything(data)[0]) == 6 * (9 + 49)
    assert [hr.shape[-1] for _, hr in data.val_dataloader()] == [64, 128]


def test_noise_differs_between_input_and_target(folder: Path, maker: FakeMaker) -> None:
    data = module(folder, maker)
    seeds = [r.seed for film in (1, 2) for r in data.recipes("train", film)]
    assert len(set(seeds)) == len(seeds)


def test_the_order_is_shuffled_by_the_seed_and_new_in_every_epoch(
    folder: Path, maker: FakeMaker
) -> None:
    def epochs(seed: int) -> list[float]:
        loader = ready(folder, maker, seed=seed, batch_size=54).train_dataloader()
        return [float(inputs[0].sum()) for _ in range(3) for inputs, _ in loader]

    first = epochs(0)
    assert len(set(first)) == 3
    assert epochs(0) == first


def test_batches_are_full_and_a_short_set_is_one_batch(folder: Path, maker: FakeMaker) -> None:
    sizes = [len(inputs) for inputs, _ in ready(folder, maker, batch_size=20).train_dataloader()]
    assert sizes == [20, 20]
    sizes = [len(inputs) for inputs, _ in ready(folder, maker).train_dataloader()]
    assert sizes == [54]


def test_what_is_rendered_is_not_rendered_again(folder: Path, maker: FakeMaker) -> None:
    ready(folder, maker)
    count = len(maker.renders)
    data = ready(folder, maker)
    data.setup("validate")
    assert len(maker.renders) == count


def test_the_composed_configuration_is_taken_as_it_is(folder: Path, maker: FakeMaker) -> None:
    composed = OmegaConf.create(
        {"poses": ["up"], "ipd_px": [8, 11], "pairs": [[1, 2]], "compressions": ["none"]}
    )
    data = module(folder, maker, **{str(name): value for name, value in composed.items()})
    assert data.distances == [8.0, 11.0]
    assert {recipe.pose for recipe in data.recipes("train", 1)} == {"up"}


class Blank(LightningModule):
    def __init__(self) -> None:
        super().__init__()
        self.level = torch.nn.Parameter(torch.zeros(()))

    def training_step(self, batch: tuple[torch.Tensor, torch.Tensor]) -> torch.Tensor:
        return (self.level - batch[1]).square().mean()

    def validation_step(self, batch: tuple[torch.Tensor, torch.Tensor]) -> None:
        self.log("val/psnr_db", -10 * torch.log10((self.level - batch[1]).square().mean()))

    def configure_optimizers(self) -> torch.optim.Optimizer:
        return torch.optim.Adam(self.parameters(), 0.1)


@pytest.mark.filterwarnings("ignore:.*does not have many workers:UserWarning")
@pytest.mark.filterwarnings("ignore:The number of training batches:UserWarning")
@pytest.mark.filterwarnings("ignore:.*LeafSpec.*is deprecated:FutureWarning")
def test_lightning_trains_on_it(folder: Path, maker: FakeMaker, tmp_path: Path) -> None:
    trainer = Trainer(
        max_epochs=5,
        accelerator="cpu",
        logger=False,
        enable_checkpointing=False,
        enable_progress_bar=False,
        enable_model_summary=False,
        default_root_dir=tmp_path,
    )
    model = Blank()
    trainer.fit(model, datamodule=module(folder, maker, batch_size=9))
    assert 0.2 < float(model.level.detach()) < 0.8
    assert trainer.global_step == 5 * 6


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scale": 3}, "data scale=3: wanted 2 or 4"),
        ({"count": 0}, "data count=0: wanted a number >= 1"),
        ({"views": 2}, "data views=2: wanted 1 to 1"),
        ({"views": 0}, "data views=0: wanted 1 to 1"),
        ({"pairs": [[1, 4]]}, r"data pairs=\[\(1, 4\)\]: wanted films that differ by the factor 2"),
        ({"compressions": []}, r"data compressions=\[\]: wanted at least one"),
        ({"compressions": ["much"]}, "compression 'much'"),
        ({"ipd_px": []}, r"data ipd_px=\[\]: wanted at least one"),
        ({"samples_per_pixel": 0}, "samples_per_pixel=0"),
    ],
    ids=lambda value: "".join(value) if isinstance(value, dict) else "",
)
def test_a_wrong_setting_is_one_line(
    folder: Path, maker: FakeMaker, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        module(folder, maker, **settings)


def test_images_smaller_than_a_patch_are_refused_before_they_are_rendered(
    folder: Path, maker: FakeMaker
) -> None:
    with pytest.raises(InputError, match="data ipd_px=4: its targets are 32 px wide, smaller than"):
        module(folder, maker, ipd_px=[8, 4])
    assert maker.renders == []


def test_loaders_want_the_data_first(folder: Path, maker: FakeMaker) -> None:
    with pytest.raises(RuntimeError, match=r"call prepare_data\(\) and setup\(\) first"):
        module(folder, maker).train_dataloader()


def test_who_is_cast_is_who_is_learned(folder: Path, maker: FakeMaker) -> None:
    women = Population("female")
    cast = Cast(women, Roster("train", 0, 6, women, RECIPE_VERSION, "dlib", 11.2, {4: 1}))
    data = module(folder, maker, cast=cast)
    assert [recipe.draw for recipe in data.recipes("train", 1)] == [0, 0, 0, 0, 1, 0]
    people = [*data.recipes("train", 1), *data.recipes("validation", 2)]
    assert {recipe.population for recipe in people} == {women}
    with pytest.raises(InputError, match="covers train 0 to 5"):
        module(folder, maker, cast=cast, count=7)


def test_inputs_have_the_flaws_of_the_camera_and_targets_have_not(
    folder: Path, maker: FakeMaker
) -> None:
    flawed = Camera(exposure_ev=-0.5, supersampling=4, sensor=Sensor(200.0))
    data = ready(folder, maker, camera=flawed)
    made = len(maker.renders)
    assert {recipe.scale for recipe in maker.renders} == {2, 4}
    plain = ready(folder, maker, camera=Camera(exposure_ev=-0.5))
    assert len(maker.renders) == made * 3 // 2  # the inputs, once more, and no target
    assert torch.equal(everything(data)[1], everything(plain)[1])
    assert not torch.equal(everything(data)[0], everything(plain)[0])


def test_inputs_and_targets_of_measured_filters_come_from_bands(
    folder: Path, maker: FakeMaker
) -> None:
    data = ready(folder, maker, camera=Camera(colour=SpectralColour("nikon_d5100")))
    assert {(recipe.scale, recipe.bands) for recipe in maker.renders} == {(1, 35), (2, 35)}
    assert all(bool(torch.isfinite(patches).all()) for patches in everything(data))
