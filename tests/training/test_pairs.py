"""Pairs of films become patches; training and validation share nobody."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
import torch
from fakes.maker import FakeMaker
from lightning import LightningModule, Trainer

from lrsr.camera import Camera
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.picture import stack
from lrsr.pictures.render import take_pictures
from lrsr.presets import preset
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.training.pairs import Pairs
from lrsr.training.patches import FacePatches, LuminancePatches, RgbPatches
from lrsr.training.shrinking.clean import Clean
from lrsr.training.shrinking.one_camera import OneCamera

NAMED = {"poses": "pose", "lightings": "lighting"}


def module(cache: RenderCache, maker: FakeMaker, count: int = 6, **settings: Any) -> Pairs:
    given: dict[str, Any] = {
        "people": [Person("train", index) for index in range(count)],
        "validation_people": [Person("validation", 0)],
        "poses": ["frontal"],
        "lightings": ["frontal"],
        "ipd_px": [8.0],
        "degradation": OneCamera(),
        "views": 1,
        "scale": 2,
        "patches": LuminancePatches(),
        "lens": PINHOLE,
        "standpoint": LEVEL,
        "quality": Quality(),
        "camera": Camera(),
        "batch_size": 128,
        "seed": 0,
        "progress": False,
        **settings,
    }
    for name, group in NAMED.items():
        given[name] = [preset(group, one) for one in given[name]]
    return Pairs(cache=cache, maker=maker, **given)


def ready(cache: RenderCache, maker: FakeMaker, **settings: Any) -> Pairs:
    data = module(cache, maker, **settings)
    data.prepare_data()
    data.setup("fit")
    return data


def everything(data: Pairs) -> tuple[torch.Tensor, ...]:
    return data.cut(0)


def test_another_day_and_an_expression_are_those_of_both_films(
    cache: RenderCache, maker: FakeMaker
) -> None:
    day, smile = preset("another_day", "hair"), preset("expression", "smile")
    data = module(cache, maker, another_day=day, expression=smile)
    scenes = [recipe.scene for film in (1, 2) for recipe in data.recipes(data.people, film)]
    assert {scene.another_day for scene in scenes} == {day}
    assert {scene.expression.name for scene in scenes} == {"smile"}


def test_patches_are_those_of_the_two_films_through_the_camera(
    cache: RenderCache, maker: FakeMaker
) -> None:
    data = ready(cache, maker, degradation=OneCamera(["heavy"]), camera=Camera(exposure_ev=-0.5))
    of_film = [data.recipes(data.people, film) for film in (1, 2)]
    lr, _ = stack(take_pictures(of_film[0], cache, Camera("heavy", -0.5), maker=maker))
    hr, _ = stack(take_pictures(of_film[1], cache, Camera("none", -0.5), maker=maker))
    wanted = LuminancePatches().cut(lr, hr)
    inputs, targets = everything(data)
    assert inputs.shape == (6 * 9, 1, 33, 33)
    assert targets.shape == (6 * 9, 1, 21, 21)
    assert torch.allclose(inputs, wanted[0], atol=1e-6)
    assert torch.allclose(targets, wanted[1], atol=1e-6)


def test_input_and_target_show_the_same_place(cache: RenderCache, maker: FakeMaker) -> None:
    inputs, targets = everything(ready(cache, maker, scale=4))
    assert len(inputs) == 6 * 49
    assert float((inputs[..., 6:-6, 6:-6] - targets).square().mean()) < 1e-3
    assert float((inputs[..., :-12, :-12] - targets).square().mean()) > 2e-3


def test_colours_come_as_the_camera_stored_them(cache: RenderCache, maker: FakeMaker) -> None:
    inputs, targets = everything(ready(cache, maker, scale=4, patches=RgbPatches(16, 8)))
    assert inputs.shape == (6 * 9, 3, 16, 16)
    assert targets.shape == (6 * 9, 3, 64, 64)
    shrunken = torch.nn.functional.avg_pool2d(targets, 4)
    assert float((shrunken - inputs).square().mean()) < 1e-3


def test_faces_come_with_where_their_landmarks_are_on_the_target(
    cache: RenderCache, maker: FakeMaker
) -> None:
    data = ready(cache, maker, patches=FacePatches(32), count=2)
    inputs, targets, landmarks_px = everything(data)
    _, wanted = stack(take_pictures(data.recipes(data.people, 2), cache, Camera(), maker=maker))
    assert (inputs.shape, targets.shape) == ((2, 3, 32, 32), (2, 3, 64, 64))
    assert torch.equal(landmarks_px, wanted)
    assert all(len(pair) == 2 for pair in data.val_dataloader())


def test_both_films_have_the_lens_and_the_standpoint(cache: RenderCache, maker: FakeMaker) -> None:
    seen = {"lens": preset("lens", "single"), "standpoint": preset("standpoint", "scface_far")}
    data = module(cache, maker, **seen)
    recipes = [*data.recipes(data.people, 1), *data.recipes(data.validation_people, 2)]
    assert {(one.scene.lens, one.scene.standpoint) for one in recipes} == {tuple(seen.values())}


def test_training_and_validation_share_nobody(cache: RenderCache, maker: FakeMaker) -> None:
    people = [Person("train", 1), Person("train", 2)]
    with pytest.raises(InputError, match="train-00002 is to be learned and to validate"):
        module(cache, maker, people=people, validation_people=people[1:])


def test_validation_gives_whole_images_one_at_a_time(cache: RenderCache, maker: FakeMaker) -> None:
    others = [Person("validation", index) for index in range(2)]
    data = ready(cache, maker, validation_people=others, ipd_px=[8, 11], views=2)
    images = list(data.val_dataloader())
    assert [tuple(hr.shape) for _, hr in images] == [(1, 3, 64, 64)] * 2 + [(1, 3, 88, 88)] * 2
    assert [tuple(lr.shape) for lr, _ in images] == [(1, 3, 32, 32)] * 2 + [(1, 3, 44, 44)] * 2


def test_conditions_multiply(cache: RenderCache, maker: FakeMaker) -> None:
    shown: dict[str, Any] = {"poses": ["frontal", "left"], "lightings": ["frontal", "side"]}
    data = module(cache, maker, **shown, ipd_px=[8.0, 9.0], views=8)
    assert len(data.recipes(data.people, 1)) == 6 * 8


def test_every_compression_is_seen_without_a_further_rendering(
    cache: RenderCache, maker: FakeMaker
) -> None:
    inputs, _ = everything(ready(cache, maker, degradation=OneCamera(["none", "small", "heavy"])))
    assert len(inputs) == 3 * 6 * 9
    assert len(maker.renders) == 2 * (6 + 1)


def test_views_are_drawn_for_each_person_and_the_same_for_every_film(
    cache: RenderCache, maker: FakeMaker
) -> None:
    settings: dict[str, Any] = {
        "poses": ["frontal", "left", "up", "down"],
        "lightings": ["frontal", "side"],
        "count": 30,
        "views": 2,
    }
    data = module(cache, maker, **settings)
    lr, hr = data.recipes(data.people, 1), data.recipes(data.people, 2)
    assert len(lr) == 60
    assert [(r.person, r.scene) for r in lr] == [(r.person, r.scene) for r in hr]
    assert len({(r.scene.pose, r.scene.lighting) for r in lr}) == 8
    assert lr == module(cache, maker, **settings).recipes(data.people, 1)
    assert lr != module(cache, maker, **settings, seed=1).recipes(data.people, 1)


def test_more_films_add_pairs(cache: RenderCache, maker: FakeMaker) -> None:
    data = ready(cache, maker, films=[[1, 2], [2, 4]])
    assert {recipe.film.scale for recipe in maker.renders} == {1, 2, 4}
    assert len(everything(data)[0]) == 6 * (9 + 49)
    assert [hr.shape[-1] for _, hr in data.val_dataloader()] == [64, 128]


def test_noise_differs_between_input_and_target(cache: RenderCache, maker: FakeMaker) -> None:
    data = module(cache, maker)
    seeds = [r.seed for film in (1, 2) for r in data.recipes(data.people, film)]
    assert len(set(seeds)) == len(seeds)


def test_the_order_is_shuffled_by_the_seed_and_new_in_every_epoch(
    cache: RenderCache, maker: FakeMaker
) -> None:
    def epochs(seed: int) -> list[float]:
        loader: Any = ready(cache, maker, seed=seed, batch_size=54).train_dataloader()
        first = []
        for epoch in range(3):
            loader.sampler.set_epoch(epoch)
            first += [float(inputs[0].sum()) for inputs, _ in loader]
        return first

    first = epochs(0)
    assert len(set(first)) == 3
    assert epochs(0) == first


def test_batches_are_full_and_a_short_set_is_one_batch(
    cache: RenderCache, maker: FakeMaker
) -> None:
    sizes = [len(inputs) for inputs, _ in ready(cache, maker, batch_size=20).train_dataloader()]
    assert sizes == [27, 27]
    sizes = [len(inputs) for inputs, _ in ready(cache, maker).train_dataloader()]
    assert sizes == [54]


def test_what_is_rendered_is_not_rendered_again(cache: RenderCache, maker: FakeMaker) -> None:
    ready(cache, maker)
    count = len(maker.renders)
    data = ready(cache, maker)
    data.setup("validate")
    assert len(maker.renders) == count


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
def test_lightning_trains_on_it(cache: RenderCache, maker: FakeMaker, tmp_path: Path) -> None:
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
    trainer.fit(model, datamodule=module(cache, maker, batch_size=9))
    assert 0.2 < float(model.level.detach()) < 0.8
    assert trainer.global_step == 5 * 6


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"scale": 5}, "data.scale=5: wanted 2, 3 or 4"),
        ({"people": []}, "identities.count=0: wanted somebody"),
        ({"views": 2}, "data.views=2: wanted 1 to 1"),
        ({"views": 0}, "data.views=0: wanted 1 to 1"),
        ({"films": [[1, 4]]}, r"data.films=\[\(1, 4\)\]: wanted films that differ by the factor 2"),
        ({"ipd_px": []}, r"data.poses, lightings, ipd_px=\[\]: wanted at least one"),
        ({"batch_size": 0}, "data.batch_size=0: wanted a number >= 1"),
    ],
    ids=lambda value: "".join(value) if isinstance(value, dict) else "",
)
def test_a_wrong_setting_is_one_line(
    cache: RenderCache, maker: FakeMaker, settings: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        module(cache, maker, **settings)


def test_images_smaller_than_a_patch_are_refused_before_they_are_rendered(
    cache: RenderCache, maker: FakeMaker
) -> None:
    with pytest.raises(InputError, match=r"data.ipd_px=4.*: wanted pictures at least 17 px wide"):
        module(cache, maker, ipd_px=[8, 4], views=2)
    assert maker.renders == []


def test_what_it_depends_on_is_who_how_and_which_renderings(
    cache: RenderCache, maker: FakeMaker
) -> None:
    about = module(cache, maker).about()
    assert about == module(cache, maker).about()
    assert (about["people"], about["validation_people"]) == (6, 1)
    assert about["versions.renderer"] == "1"
    redrawn = [replace(person, draw=1) for person in module(cache, maker).people]
    for other in ({"people": redrawn}, {"seed": 1}, {"poses": ["left"]}, {"quality": Quality(8)}):
        assert module(cache, maker, **other).about()["renderings"] != about["renderings"]
    maker.versions = {**maker.versions, "renderer": "2"}
    assert module(cache, maker).about()["versions.renderer"] == "2"


def test_inputs_have_the_flaws_of_the_camera_and_targets_have_not(
    cache: RenderCache, maker: FakeMaker
) -> None:
    flawed = Camera(exposure_ev=-0.5, supersampling=4, sensor=Sensor(200.0))
    data = ready(cache, maker, camera=flawed)
    made = len(maker.renders)
    assert {recipe.film.scale for recipe in maker.renders} == {2, 4}
    plain = ready(cache, maker, camera=Camera(exposure_ev=-0.5))
    assert len(maker.renders) == made * 3 // 2  # the inputs, once more, and no target
    assert torch.equal(everything(data)[1], everything(plain)[1])
    assert not torch.equal(everything(data)[0], everything(plain)[0])


def test_inputs_and_targets_of_measured_filters_come_from_bands(
    cache: RenderCache, maker: FakeMaker
) -> None:
    data = ready(cache, maker, camera=Camera(colour=SpectralColour("nikon_d5100")))
    assert {(recipe.film.scale, recipe.film.bands) for recipe in maker.renders} == {
        (1, 35),
        (2, 35),
    }
    assert all(bool(torch.isfinite(patches).all()) for patches in everything(data))


def random_cameras() -> Any:
    return preset("degradation", "random_cameras")


def test_what_is_drawn_needs_the_fine_film_only_and_is_new_in_every_epoch(
    cache: RenderCache, maker: FakeMaker
) -> None:
    data = ready(cache, maker, degradation=random_cameras())
    assert {recipe.film.scale for recipe in maker.renders} == {2}
    first, again, other = data.cut(0), data.cut(0), data.cut(1)
    assert [len(patches) for patches in first] == [54, 54]
    assert torch.equal(first[0], again[0])
    assert not torch.equal(first[0], other[0])
    loader: Any = data.train_dataloader()
    loader.sampler.set_epoch(1)
    shown = torch.cat([inputs for inputs, _ in loader])
    assert sorted(shown.sum((1, 2, 3)).tolist()) == sorted(other[0].sum((1, 2, 3)).tolist())


def test_validation_pictures_are_degraded_once_for_all_epochs(
    cache: RenderCache, maker: FakeMaker
) -> None:
    judged = [
        [small for small, _ in ready(cache, maker, degradation=random_cameras()).val_dataloader()]
        for _ in range(2)
    ]
    assert all(map(torch.equal, *judged))


def test_a_clean_film_is_that_of_a_camera_without_flaws(
    cache: RenderCache, maker: FakeMaker
) -> None:
    flawed = Camera("heavy", sensor=Sensor(200.0))
    plain = ready(cache, maker)
    clean = ready(cache, maker, camera=flawed, degradation=Clean())
    assert all(map(torch.equal, clean.cut(0), plain.cut(0)))


def test_a_camera_that_nothing_reads_is_told(cache: RenderCache, maker: FakeMaker) -> None:
    assert module(cache, maker).unread == {}
    assert set(module(cache, maker, degradation=Clean()).unread) == {"camera"}


@pytest.mark.parametrize("scale", [2, 3, 4])
def test_targets_of_every_scale_show_the_place_of_the_input(
    scale: int, cache: RenderCache, maker: FakeMaker
) -> None:
    ((small, true, _),) = module(cache, maker, scale=scale).pairs(None)
    assert true.shape[-1] == scale * small.shape[-1]


def test_the_card_says_how_the_small_pictures_are_made(
    cache: RenderCache, maker: FakeMaker
) -> None:
    assert "no down-sampling" in module(cache, maker).lr_made_by
    assert "drawn at random" in module(cache, maker, degradation=random_cameras()).lr_made_by


def test_what_is_validated_on_is_told_apart(cache: RenderCache, maker: FakeMaker) -> None:
    few, many = (module(cache, maker, count=count).about() for count in (2, 6))
    assert few["validation_renderings"] == many["validation_renderings"]
    assert few["renderings"] != many["renderings"]


@pytest.mark.parametrize("name", ["camera", "random_cameras"])
def test_landmarks_go_with_their_pictures(name: str, cache: RenderCache, maker: FakeMaker) -> None:
    data = module(cache, maker, degradation=preset("degradation", name))
    points = torch.cat([landmarks for _, _, landmarks in data.pairs(0)])
    recipes = data.recipes(data.people, 2)
    taken = take_pictures(recipes, cache, Camera(), maker=maker)
    assert torch.equal(points, stack(taken)[1])
