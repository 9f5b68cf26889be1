"""Skins: the paper's numbers, what is in a key, and what is refused."""

from dataclasses import replace
from typing import Any

import pytest
from fakes.scenes import SKINS

from lrsr.errors import InputError
from lrsr.presets import preset
from lrsr.rendering.skin import REFLECTIVE, Skin


@pytest.mark.parametrize("name", ["subsurface", "subsurface_tone", "volumetric"])
def test_all_that_scatters_is_skin1_of_jensen_et_al(name: str) -> None:
    skin = SKINS[name]
    assert skin.absorption_per_mm == (0.032, 0.17, 0.48)
    assert skin.scattering_per_mm == (0.74, 0.88, 1.01)
    assert skin.refractive_index == 1.4


def test_skin_reflects_unless_told_otherwise() -> None:
    assert Skin() == REFLECTIVE == SKINS["reflective"]


def test_lists_and_whole_numbers_make_the_same_skin() -> None:
    thick = replace(SKINS["subsurface"], scattering_per_mm=[1, 1, 1], reach_mm=6)
    same = replace(SKINS["subsurface"], scattering_per_mm=(1.0, 1.0, 1.0), reach_mm=6.0)
    assert thick == same
    assert hash(thick) == hash(same)


def test_only_what_scatters_has_numbers_in_its_key() -> None:
    assert Skin("matt").plain() == REFLECTIVE.plain() == {"model": "reflective"}
    assert SKINS["subsurface"].plain() != SKINS["subsurface_tone"].plain()


def test_the_name_is_not_in_the_key() -> None:
    skin = SKINS["subsurface"]
    assert replace(skin, name="mine").plain() == skin.plain()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"model": "wax"}, r"skin\.model=wax: wanted one of reflective"),
        ({"fixed": "nothing"}, r"skin\.fixed=nothing: wanted one of"),
        ({"absorption_per_mm": (-1, 0, 0)}, "three numbers >= 0"),
        ({"scattering_per_mm": (1, 1)}, "three numbers, e.g."),
        ({"scattering_per_mm": (1, 1, float("inf"))}, r"skin\.scattering_per_mm=inf: wanted"),
        ({"refractive_index": 1}, "a number > 1"),
        ({"refractive_index": 3}, r"skin\.refractive_index=3.0: wanted"),
        ({"reach_mm": 0}, "millimetres > 0"),
        ({"colour": 1}, "rendering/skin: .*'colour'"),
    ],
    ids=str,
)
def test_wrong_fields_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        preset("rendering/skin", "jensen_skin1", **wrong)


def test_skin_that_scatters_needs_its_numbers() -> None:
    with pytest.raises(InputError, match=r"skin\.scattering_per_mm=.*: wanted three numbers > 0"):
        Skin("thin", "subsurface")
