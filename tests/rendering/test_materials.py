"""The numbers of the materials are legal, and maps replace them."""

from typing import get_args

import pytest

from lrsr.identities.head import Material
from lrsr.rendering.materials import MATERIALS, bsdf


def test_every_material_of_a_head_has_legal_numbers() -> None:
    assert set(MATERIALS) == set(get_args(Material))
    assert all(0 <= value <= 1 for numbers in MATERIALS.values() for value in numbers.values())


def test_skin_reflects_as_much_as_an_index_between_its_own_and_sebums() -> None:
    dry, oily = (((index - 1) / (index + 1)) ** 2 for index in (1.4, 1.47))
    facing = 0.08 * MATERIALS["skin"]["specular"]
    assert facing == pytest.approx((dry + oily) / 2, abs=5e-4)


def test_both_sides_of_a_sheet_are_lit() -> None:
    description, keys = bsdf({"roughness": 0.5}, {"albedo": {"type": "rgb", "value": 0.5}})
    assert description["type"] == "twosided"
    assert keys == {"albedo": "brdf_0.base_color.data"}


def test_what_has_no_colour_is_a_thin_pane_of_plastics_index() -> None:
    description, keys = bsdf(MATERIALS["glass"], {})
    assert description == {"type": "thindielectric", "int_ior": pytest.approx(1.5)}
    assert not keys


def test_a_map_of_roughness_replaces_the_number_and_heights_wrap_the_material() -> None:
    maps = {name: {"type": "bitmap", "id": name} for name in ("albedo", "height", "roughness")}
    description, keys = bsdf({"roughness": 0.5, "specular": 0.4}, maps)
    bump = description["material"]
    assert (bump["type"], bump["texture"]["id"]) == ("bumpmap", "height")
    assert bump["bsdf"]["roughness"]["id"] == "roughness"
    assert bump["bsdf"]["specular"] == 0.4
    assert set(keys) == set(maps)
