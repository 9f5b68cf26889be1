"""What changes the pixels is in the key, and nothing else."""

import json
from dataclasses import replace
from typing import Any

import pytest

from lrsr.data.cache import RenderCache
from lrsr.data.recipe import ProbeRecipe, derived_seed
from lrsr.errors import InputError
from lrsr.identities.face.expression import EXPRESSIONS, Expression
from lrsr.identities.population import Population
from lrsr.rendering.lens import Lens, find_lens
from lrsr.rendering.scene import LIGHTINGS, POSES, Light, Lighting, Pose
from lrsr.rendering.standpoint import Standpoint, find_standpoint

RECIPE = ProbeRecipe("test", 3)
VERSIONS = {"renderer": "1"}
OTHERS: dict[str, Any] = {
    "split": "train",
    "index": 4,
    "pose": "left",
    "lighting": "side",
    "ipd_px": 9.0,
    "scale": 2,
    "samples_per_pixel": 16,
    "seed": 1,
    "texture_size": 64,
    "skin": "subsurface",
    "max_depth": 8,
    "population": Population("female"),
    "draw": 1,
    "expression": "smile",
    "lens": "thin",
    "standpoint": "scface_far",
    "bands": 35,
}


def key(recipe: ProbeRecipe, **versions: str) -> str:
    return RenderCache.key(recipe.plain({**VERSIONS, **versions}))


@pytest.mark.parametrize("name", OTHERS)
def test_whatever_changes_the_pixels_changes_the_key(name: str) -> None:
    assert key(replace(RECIPE, **{name: OTHERS[name]})) != key(RECIPE)


def test_every_field_but_the_kind_is_such_a_thing() -> None:
    assert set(OTHERS) | {"kind"} == set(RECIPE.__dataclass_fields__)
    assert key(replace(RECIPE, kind="gallery")) == key(RECIPE)


@pytest.mark.parametrize("name", ["renderer", "identities", "variant"])
def test_new_code_makes_new_pictures(name: str) -> None:
    assert key(RECIPE, **{name: "2"}) != key(RECIPE)


def test_a_whole_distance_is_the_same_as_a_number_with_a_point() -> None:
    assert key(replace(RECIPE, ipd_px=8)) == key(replace(RECIPE, ipd_px=8.0))


def test_a_named_pose_is_its_angles_and_a_named_lighting_its_lights() -> None:
    spelt_out = replace(RECIPE, pose=POSES["left"], lighting=LIGHTINGS["above"])
    assert key(spelt_out) == key(replace(RECIPE, pose="left", lighting="above"))


def test_a_named_expression_is_its_face_units() -> None:
    mine = Expression("mine", EXPRESSIONS["smile"])
    assert key(replace(RECIPE, expression=mine)) == key(replace(RECIPE, expression="smile"))
    assert key(replace(RECIPE, expression=Expression("none"))) == key(RECIPE)


def test_an_expression_has_noise_of_its_own_and_neutral_that_of_before() -> None:
    seeds = [replace(RECIPE, expression=e).seeded(7).seed for e in ("neutral", "smile", "blink")]
    assert len(set(seeds)) == 3
    assert seeds[0] == derived_seed(
        7, "test", 3, "probe", "frontal", "frontal", RECIPE.ipd_px, RECIPE.scale
    )


def test_a_lens_is_its_surfaces_and_a_standpoint_its_place() -> None:
    mine = replace(find_lens("single"), name="mine")
    assert key(replace(RECIPE, lens=mine)) == key(replace(RECIPE, lens="single"))
    assert key(replace(RECIPE, lens=Lens("none"))) == key(RECIPE)
    slower = find_lens("single", f_number=8.0)
    assert key(replace(RECIPE, lens=slower)) != key(replace(RECIPE, lens="single"))
    place = replace(find_standpoint("scface_far"), name="mine")
    assert key(replace(RECIPE, standpoint=place)) == key(replace(RECIPE, standpoint="scface_far"))
    assert key(replace(RECIPE, standpoint=Standpoint("eyes", height_m=1.6))) == key(RECIPE)


def test_pictures_of_before_keep_their_keys_and_their_noise() -> None:
    """Written by lrsr 0.1.0, which knew one lens, one standpoint and no panels."""
    lamps = (Light(10.0, 20.0), Light(-30.0, 40.0, 15.0, 2.0, (1.1, 1.0, 0.9)))
    recipe = replace(RECIPE, pose="left", lighting=Lighting("mine", lamps, 0.4)).seeded(7)
    assert recipe.seed == 1150136395
    assert key(recipe) == "d54e75e157f30f4f19e0798fb90957d861603871bef1fed0f199c1b847b593e2"


def test_a_lens_has_noise_of_its_own() -> None:
    seen = [replace(RECIPE, lens=lens).seeded(7).seed for lens in ("pinhole", "thin", "single")]
    seen += [replace(RECIPE, standpoint="scface_near").seeded(7).seed]
    assert len(set(seen)) == 4


def test_any_pose_and_any_lighting_become_plain_values() -> None:
    recipe = replace(
        RECIPE,
        pose=Pose("mine", yaw_deg=12.5),
        lighting=Lighting("mine", (Light(10.0, 20.0), Light(-30.0, 40.0))),
    )
    plain = recipe.plain(VERSIONS)
    assert json.loads(json.dumps(plain))["pose"]["yaw_deg"] == 12.5
    turned = replace(recipe, pose=Pose("mine", yaw_deg=12.6))
    relit = replace(recipe, lighting=Lighting("mine", (Light(10.0, 20.0), Light(-30.0, 41.0))))
    assert len({key(recipe), key(turned), key(relit)}) == 3


def test_a_key_is_the_sha_256_of_the_canonical_json() -> None:
    # printf '{"a":1,"b":[2.5,"c"],"format":2}' | sha256sum
    wanted = "76b8e7128d26c8572e517dbacee3418638e3479c3c97e09fb6be87283484d7fd"
    assert RenderCache.key({"b": [2.5, "c"], "a": 1}) == wanted


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"split": "testing"}, "split=testing: wanted one of train, validation, test"),
        ({"kind": "mugshot"}, "kind=mugshot: wanted one of probe, gallery"),
        ({"index": -1}, "index=-1: wanted a number >= 0"),
        ({"scale": 3}, "scale=3: wanted one of"),
        ({"ipd_px": 0}, "ipd_px=0.0: wanted a number of pixels > 0"),
        ({"ipd_px": float("nan")}, "ipd_px=nan"),
        ({"samples_per_pixel": 0}, "samples_per_pixel=0"),
        ({"seed": 2**32}, "seed=4294967296: wanted 0 to 4294967295"),
        ({"texture_size": 1}, "texture_size=1"),
        ({"max_depth": 0}, "max_depth=0"),
        ({"draw": -1}, "draw=-1"),
        ({"pose": "sideways"}, "pose 'sideways' does not exist; choose one of frontal"),
        ({"expression": "laugh"}, "expression 'laugh' does not exist; choose one of neutral"),
        ({"lighting": "noon"}, "lighting 'noon' does not exist; choose one of frontal"),
        ({"lens": "zoom"}, "lens 'zoom' does not exist; choose one of pinhole"),
        ({"standpoint": "roof"}, "standpoint 'roof' does not exist; choose one of level"),
    ],
    ids=lambda value: "-".join(value) if isinstance(value, dict) else "",
)
def test_a_value_out_of_range_is_refused(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(RECIPE, **changes)


def test_seeds_differ_between_pictures_and_not_between_runs() -> None:
    pictures = [("test", i, pose) for i in range(50) for pose in ("frontal", "left")]
    seeds = [derived_seed(0, *picture) for picture in pictures]
    assert len(set(seeds)) == len(pictures)
    assert all(0 <= seed < 2**32 for seed in seeds)
    assert seeds == [derived_seed(0, *picture) for picture in pictures]
    assert derived_seed(1, *pictures[0]) != seeds[0]


def test_a_seed_depends_on_the_angles_of_a_pose() -> None:
    assert derived_seed(0, Pose("a", 1.0)) != derived_seed(0, Pose("a", 2.0))


@pytest.mark.parametrize("change", [{"population": Population("male")}, {"draw": 2}], ids=str)
def test_somebody_else_has_another_name_and_other_noise(change: dict[str, Any]) -> None:
    other = replace(RECIPE, **change)
    assert other.identity_id != RECIPE.identity_id
    assert other.seeded(0).seed != RECIPE.seeded(0).seed
