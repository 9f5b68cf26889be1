from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from fakes.maps import DottedMaker, average_adult, somebody
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.errors import InputError
from lrsr.identities.person import Person
from lrsr.identities.photographs.crop import Crop
from lrsr.identities.shape.basis import load_basis
from lrsr.pictures.cache import RenderCache
from lrsr.presets import preset
from lrsr.rendering.lens import PINHOLE
from lrsr.rendering.pose import FRONTAL, Pose
from lrsr.rendering.renderer import viewpoint_of
from lrsr.rendering.scene import Quality
from lrsr.rendering.standpoint import LEVEL
from lrsr.training.position_maps import PositionMaps, _draw_map, resting_map, skin_mask
from lrsr.training.variety import Variety

SMILE = preset("expression", "smile")


def lessons(cache: RenderCache, **changes: Any) -> PositionMaps:
    lightings = [preset("lighting", name) for name in ("frontal", "above")]
    variety = Variety([FRONTAL], lightings, [SMILE], 0.2, 0.5, [50, 25, 12])
    given: dict[str, Any] = {
        "people": [Person("train", index) for index in range(3)],
        "validation_people": [Person("validation", 0)],
        "variety": variety,
        "distance_m": [0.55, 2.5],
        "rendered_ipd_px": 28.0,
        "views": 2,
        "lens": PINHOLE,
        "standpoint": LEVEL,
        "quality": Quality(16),
        "camera": Camera(),
        "batch_size": 2,
        "seed": 0,
        "progress": False,
    }
    return PositionMaps(cache=cache, maker=DottedMaker(), **{**given, **changes})


def at(drawn: NDArray[np.float64], uv: NDArray[np.floating]) -> NDArray[np.float64]:
    """Return what a map ``(3, 64, 64)`` holds at places ``(N, 2)`` of the texture: ``(N, 3)``."""
    grid = torch.from_numpy(2 * uv.astype(np.float64) - 1)[None, None]
    found = torch.nn.functional.grid_sample(
        torch.from_numpy(drawn)[None], grid, align_corners=False
    )
    return found[0, :, 0].T.numpy()


@pytest.mark.parametrize(
    "pose", [FRONTAL, Pose("turned", 45, 10, -8)], ids=lambda pose: str(pose.name)
)
def test_a_map_says_where_nose_and_mouth_are(pose: Pose, cache: RenderCache) -> None:
    recipe = lessons(cache).recipes([Person("train", 0)])[0]
    recipe = replace(recipe, scene=replace(recipe.scene, pose=pose))
    head, crop = average_adult(), Crop((60.0, 50.0), 90.0, 0.3, 112)
    drawn = _draw_map(head, recipe, crop)
    true = DottedMaker().render(head, recipe).landmarks_px.numpy()[2:]
    surface = load_basis().surface
    places = at(drawn, surface.uv[surface.landmarks])[:, :2]
    off = np.linalg.norm(crop.back(places) - true, axis=1)
    assert off[0] < 1  # px, a texel being about 2
    assert off.max() < 3  # corners of the mouth lie beside its hole in the layout


def test_the_nose_is_nearer_than_the_pupils_by_as_much_as_it_protrudes(cache: RenderCache) -> None:
    recipe = lessons(cache).recipes([Person("train", 0)])[0]
    recipe = replace(recipe, scene=replace(recipe.scene, pose=FRONTAL))
    head, crop = somebody(), Crop((60.0, 50.0), 90.0, 0.3, 112)
    px_per_mm = recipe.film.ipd_px / head.ipd_mm / crop.scale
    surface = load_basis().surface
    (tip,) = at(_draw_map(head, recipe, crop), surface.uv[surface.landmarks[:1]])
    protrudes = head.landmarks[2, 2] - head.pupils[:, 2].mean()
    np.testing.assert_allclose(tip[2] / px_per_mm, protrudes, atol=3)  # half a texel beside the tip


def test_a_higher_camera_sees_the_head_from_above(cache: RenderCache) -> None:
    high = lessons(cache, standpoint=preset("standpoint", "scface_near"), distance_m=[2, 2])
    recipe = high.recipes([Person("train", 0)])[0]
    assert viewpoint_of(somebody(), recipe.scene, recipe.film).elevation_deg > 5


def test_the_mean_face_rests_upright_in_the_middle() -> None:
    rest = resting_map()
    surface = load_basis().surface
    nose, left, right = at(rest, surface.uv[surface.landmarks])
    assert abs(nose[0] - 55.5) < 0.5
    assert 50 < nose[1] < left[1] < 90
    assert right[0] - left[0] > 10
    skin = skin_mask()
    assert 2000 < skin.sum() == (skin & skin[:, ::-1]).sum()
    np.testing.assert_allclose(
        (rest[0] + rest[0, :, ::-1])[skin], 111, atol=1.5
    )  # its mirror image


def test_everybody_acts_once_and_is_seen_in_several_ways(cache: RenderCache) -> None:
    data = lessons(cache)
    recipes = data.recipes([Person("train", index) for index in range(30)])
    assert recipes[:4] == data.recipes(data.people)[:4]  # whoever else is there
    acted = [recipe.scene.expression for recipe in recipes]
    assert acted[::2] == acted[1::2]
    assert 5 < sum(bool(one.units) for one in acted[::2]) < 25
    away = [recipe.scene.standpoint.distance_m or 0.0 for recipe in recipes]
    assert 0.55 <= min(away) < 0.8
    assert 2.0 < max(away) <= 2.5
    assert 35 < max(abs(recipe.scene.pose.yaw_deg) for recipe in recipes) <= 50
    assert len({recipe.seed for recipe in recipes}) == len(recipes)


def test_faces_at_rest_have_the_expression_of_the_whole_run(cache: RenderCache) -> None:
    quiet = replace(lessons(cache).variety, expression_share=0)
    (recipe, _) = lessons(cache, variety=quiet, expression=SMILE).recipes([Person("train", 0)])
    assert recipe.scene.expression == SMILE


def test_lessons_are_crops_whose_maps_lie_on_them(cache: RenderCache) -> None:
    data = lessons(cache, people=[Person("train", 0)])
    data.prepare_data()
    data.setup()
    crops, maps = next(iter(data.val_dataloader()))
    assert (crops.shape, crops.dtype) == ((2, 3, 112, 112), torch.uint8)
    assert (maps.shape, maps.dtype) == ((2, 3, 64, 64), torch.float32)
    surface = load_basis().surface
    for crop, drawn in zip(crops, maps.double().numpy(), strict=True):
        for x, y in at(drawn, surface.uv[surface.landmarks])[:, :2].round().astype(int):
            assert crop[:, y - 2 : y + 3, x - 2 : x + 3].max() > 90  # the landmark's dot
    assert [len(crops) for crops, _ in data.train_dataloader()] == [2]


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"views": 0}, "data.views=0: wanted at least 1"),
        ({"batch_size": 1}, "data.batch_size=1: wanted at least 2"),
        ({"distance_m": [2, 1]}, "data.distance_m=.*: wanted 0 < nearest <= farthest"),
        ({"rendered_ipd_px": 0.0}, "data.rendered_ipd_px=0.*: wanted a number > 0"),
    ],
    ids=str,
)
def test_impossible_lessons_are_refused(
    wrong: dict[str, Any], message: str, cache: RenderCache
) -> None:
    with pytest.raises(InputError, match=message):
        lessons(cache, **wrong)
