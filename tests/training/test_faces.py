from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from fakes.painted import PaintedMaker

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.person import Person
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import filmed
from lrsr.presets import preset
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.pose import FRONTAL
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.training.faces import Faces, _draw_views
from lrsr.training.variety import Variety


def lessons(cache: RenderCache, maker: PaintedMaker, count: int = 3, **changes: Any) -> Faces:
    share = changes.pop("expression_share", 0.0)
    lightings = [preset("lighting", name) for name in ("frontal", "above")]
    given: dict[str, Any] = {
        "people": [Person("train", index) for index in range(count)],
        "validation_people": [Person("validation", index) for index in range(2)],
        "variety": Variety(
            [FRONTAL], lightings, [preset("expression", "smile")], 0.3, share, [35, 20, 5]
        ),
        "gallery_lighting": lightings[0],
        "probe_lighting": lightings[1],
        "validation_ipd_px": [64, 14, 11, 8],
        "validation_samples": 256,
        "sharp_views": 2,
        "small_views": 1,
        "sharp_ipd_px": [32, 36],
        "small_ipd_px": [7, 16],
        "sharp_samples": 16,
        "compressions": ["none", "small", "heavy"],
        "enlargements": [1, 4],
        "antialias": True,
        "views": 2,
        "lens": PINHOLE,
        "standpoint": LEVEL,
        "quality": Quality(96),
        "camera": Camera(),
        "batch_size": 2,
        "seed": 0,
        "progress": False,
    }
    return Faces(cache=cache, maker=maker, **{**given, **changes})


@pytest.fixture
def few(cache: RenderCache, painter: PaintedMaker) -> Faces:
    return lessons(cache, painter)


@pytest.fixture
def ready(few: Faces) -> Faces:
    few.prepare_data()
    few.setup()
    return few


def test_every_person_is_seen_frontally_once_and_small_as_asked(few: Faces) -> None:
    views = [recipe for recipe in few.training_recipes() if recipe.person.index == 1]
    assert views[0].scene.pose == FRONTAL
    assert [32 <= view.film.ipd_px <= 36 for view in views] == [True, True, False]
    assert 7 <= views[2].film.ipd_px <= 16
    assert [view.quality.samples_per_pixel for view in views] == [16, 16, 96]


def test_recipes_follow_from_the_seed_and_not_from_how_many_there_are(
    few: Faces, cache: RenderCache, painter: PaintedMaker
) -> None:
    more, other = lessons(cache, painter, 5), lessons(cache, painter, seed=1)
    assert more.training_recipes()[:9] == few.training_recipes()
    assert other.training_recipes() != few.training_recipes()


def test_all_samplers_differ(few: Faces) -> None:
    seeds = [recipe.seed for recipe in few.training_recipes()]
    assert len(set(seeds)) == len(seeds)


def test_everything_is_rendered_beforehand(ready: Faces, painter: PaintedMaker) -> None:
    recipes = {filmed(*shot) for shot in ready.shots()}
    assert len(recipes) == 3 * 3 + 2 * 5


def test_camera_lens_and_standpoint_count(cache: RenderCache, painter: PaintedMaker) -> None:
    plain = lessons(cache, painter).about()["renderings"]
    for other in (
        {"lens": preset("lens", "single")},
        {"standpoint": preset("standpoint", "scface_far")},
        {"camera": Camera(supersampling=2)},
        {"quality": Quality(97)},
    ):
        assert lessons(cache, painter, **other).about()["renderings"] != plain


def test_sharp_faces_come_once_and_small_ones_in_six_guises(ready: Faces) -> None:
    crops, people, sharp = ready.faces.tensors
    assert (crops.shape, crops.dtype) == ((3 * (2 + 6), 3, 112, 112), torch.uint8)
    for person in range(3):
        assert int(((people == person) & sharp).sum()) == 2
        assert int(((people == person) & ~sharp).sum()) == 6


def test_faces_of_one_person_are_alike(ready: Faces) -> None:
    faces, people, _ = ready.faces.tensors
    crops = faces.float().flatten(1)
    likeness = torch.corrcoef(crops - crops.mean(0))
    same = people[:, None] == people[None]
    assert float(likeness[same].min()) > float(likeness[~same].max())


def test_validation_meets_the_gallery_at_four_sizes(ready: Faces) -> None:
    sets = dict(ready.val_dataloader())
    assert list(sets) == ["gallery", "ipd64", "ipd14", "ipd11", "ipd8"]
    assert all(crops.shape == (2, 3, 112, 112) for crops in sets.values())


def test_batches_are_crops_people_and_sharpness(ready: Faces) -> None:
    crops, people, sharp = next(iter(ready.train_dataloader()))
    assert (crops.shape, crops.dtype) == ((2, 3, 112, 112), torch.uint8)
    assert (people.dtype, sharp.dtype) == (torch.int64, torch.bool)


def test_each_person_is_drawn_as_often_half_of_it_sharp() -> None:
    people, sharp = np.repeat(np.arange(3), 8), np.tile(np.arange(8) < 2, 3)
    rows = _draw_views(people, sharp, 5, np.random.default_rng(0))
    for person in range(3):
        drawn = rows[people[rows] == person]
        assert len(drawn) == 5
        assert int(sharp[drawn].sum()) == 2


def test_another_day_and_an_expression_come_after_the_first_view(
    cache: RenderCache, painter: PaintedMaker
) -> None:
    day, smile = preset("another_day", "everything"), preset("expression", "smile")
    data = lessons(cache, painter, another_day=day, expression=smile)
    plain = lessons(cache, painter)
    views = data.training_recipes()[:3]
    assert views[0] == plain.training_recipes()[0]  # as enrolled
    assert [view.scene.another_day for view in views[1:]] == [day, day.later(1)]
    assert {view.scene.expression.name for view in views[1:]} == {"smile"}
    told, usual = data.validation_recipes(), plain.validation_recipes()
    assert told["gallery"] == usual["gallery"]
    assert {probe.scene.another_day for probe in told["ipd8"]} == {day}
    assert {probe.scene.expression.name for probe in told["ipd8"]} == {"smile"}


def test_expressions_change_nothing_but_the_faces(
    cache: RenderCache, painter: PaintedMaker
) -> None:
    def at_rest(recipe: Recipe) -> Recipe:
        return replace(recipe, scene=replace(recipe.scene, expression=NEUTRAL))

    plain, acting = (
        lessons(cache, painter, 12, expression_share=share).training_recipes()
        for share in (0.0, 0.5)
    )
    assert {recipe.scene.expression.name for recipe in plain} == {"neutral"}
    assert [at_rest(recipe) for recipe in acting] == plain
    shown = [recipe.scene.expression != NEUTRAL for recipe in acting]
    assert not any(shown[::3])  # the first view of each person
    assert 5 < sum(shown) < 25


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"people": [Person("train", 0)]}, "identities.count=1: wanted at least 2"),
        ({"sharp_views": 0}, "data.sharp_views=0: wanted at least 1"),
        ({"views": 0}, "data.views=0: wanted at least 1"),
        ({"batch_size": 1}, "data.batch_size=1: wanted at least 2"),
        ({"small_ipd_px": (9, 7)}, r"data.small_ipd_px=\[9.0, 7.0\]: wanted 0 < lowest"),
    ],
    ids=["people", "sharp", "views", "batch", "ipd"],
)
def test_impossible_settings_are_refused(
    cache: RenderCache, painter: PaintedMaker, wrong: dict[str, Any], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        lessons(cache, painter, **wrong)
