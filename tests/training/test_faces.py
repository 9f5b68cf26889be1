from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
import torch
from lrsr.data.cache import RenderCache
from lrsr.recognition.faces import (
    FaceSettings,
    load_training_faces,
    load_validation_faces,
    render_faces,
    training_recipes,
    validation_recipes,
)

from lrsr.errors import InputError
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.population import Population
from lrsr.identities.roster import Roster, write_roster

if TYPE_CHECKING:
    from lrsr.data.maker import Maker

FEW = FaceSettings(identities=3, validation_identities=2, sharp_views=2, small_views=1)


def test_nobody_learned_is_used_to_validate() -> None:
    learned = {recipe.identity_id for recipe in training_recipes(FEW)}
    validated = {
        recipe.identity_id for views in validation_recipes(FEW).values() for recipe in views
    }
    assert learned == {"train-00000", "train-00001", "train-00002"}
    assert validated == {"validation-00000", "validation-00001"}


def test_a_roster_redraws_who_is_learned_and_nobody_who_validates(tmp_path: Path) -> None:
    men = Population("male")
    redrawn = Roster("train", 0, 3, men, RECIPE_VERSION, "dlib", 11.2, {1: 2})
    path = write_roster(tmp_path / "roster.json", redrawn)
    settings = replace(FEW, sex="male", roster=str(path))
    assert [view.draw for view in training_recipes(settings)] == [0, 0, 0, 2, 2, 2, 0, 0, 0]
    validated = [view for views in validation_recipes(settings).values() for view in views]
    assert {(view.population, view.draw) for view in validated} == {(men, 0)}
    with pytest.raises(InputError, match="covers train 0 to 2"):
        replace(settings, identities=4)


def test_every_person_is_seen_frontally_once_and_small_as_asked() -> None:
    views = [recipe for recipe in training_recipes(FEW) if recipe.index == 1]
    assert [view.pose for view in views].count("frontal") == 1
    assert [32 <= view.ipd_px <= 36 for view in views] == [True, True, False]
    assert 7 <= views[2].ipd_px <= 16


def test_recipes_follow_from_the_seed_and_not_from_how_many_there_are() -> None:
    more = FaceSettings(identities=5, validation_identities=2, sharp_views=2, small_views=1)
    other = FaceSettings(identities=3, sharp_views=2, small_views=1, seed=1)
    assert training_recipes(more)[:9] == training_recipes(FEW)
    assert training_recipes(other) != training_recipes(FEW)


def test_all_samplers_differ() -> None:
    seeds = [recipe.seed for recipe in training_recipes(FEW)]
    assert len(set(seeds)) == len(seeds)


def test_rendering_can_be_done_beforehand(cache: RenderCache, maker: "Maker") -> None:
    assert render_faces(FEW, cache, progress=False, maker=maker) == 3 * 3 + 2 * 5
    assert render_faces(FEW, cache, progress=False, maker=maker) == 0


def test_sharp_faces_come_once_and_small_ones_in_six_guises(
    cache: RenderCache, maker: "Maker"
) -> None:
    faces = load_training_faces(FEW, cache, progress=False, maker=maker)
    assert (faces.crops.shape, faces.crops.dtype) == ((3 * (2 + 6), 3, 112, 112), torch.uint8)
    for person in range(3):
        rows = faces.people == person
        assert int((rows & faces.sharp).sum()) == 2
        assert int((rows & ~faces.sharp).sum()) == 6


def test_faces_of_one_person_are_alike(cache: RenderCache, maker: "Maker") -> None:
    faces = load_training_faces(FEW, cache, progress=False, maker=maker)
    crops = faces.crops.float().flatten(1)
    likeness = torch.corrcoef(crops - crops.mean(0))
    same = faces.people[:, None] == faces.people[None]
    assert float(likeness[same].min()) > float(likeness[~same].max())


def test_validation_meets_the_gallery_at_four_sizes(cache: RenderCache, maker: "Maker") -> None:
    sets = load_validation_faces(FEW, cache, progress=False, maker=maker)
    assert list(sets) == ["gallery", "ipd64", "ipd14", "ipd11", "ipd8"]
    assert all(crops.shape == (2, 3, 112, 112) for crops in sets.values())


def test_expressions_change_nothing_but_the_faces() -> None:
    plain, acting = (
        training_recipes(FaceSettings(identities=6, expression_share=share)) for share in (0.0, 0.5)
    )
    assert {recipe.expression for recipe in plain} == {"neutral"}
    assert [replace(recipe, expression="neutral") for recipe in acting] == plain
    shown = [recipe.expression != "neutral" for recipe in acting]
    assert not any(shown[::6])  # the first view of each person
    assert 5 < sum(shown) < 25


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"identities": 1}, "faces.identities=1: wanted at least 2"),
        ({"sharp_views": 0}, "faces.sharp_views=0: wanted at least 1"),
        ({"expression_share": 1.5}, "faces.expression_share=1.5: wanted 0 to 1"),
        ({"small_ipd_px": (9, 7)}, r"faces.small_ipd_px=\[9.0, 7.0\]: wanted 0 < lowest"),
    ],
)
def test_impossible_settings_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        FaceSettings(**wrong)
