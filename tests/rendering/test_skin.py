"""Skins by name, by fields, and what is refused."""

import pytest

from lrsr.errors import InputError
from lrsr.rendering.skin import SKINS, Skin, find_skin, named


def test_the_default_is_skin1_of_jensen_et_al() -> None:
    skin = find_skin("subsurface")
    assert skin.absorption_per_mm == (0.032, 0.17, 0.48)
    assert skin.scattering_per_mm == (0.74, 0.88, 1.01)
    assert skin.refractive_index == 1.4


@pytest.mark.parametrize("name", SKINS)
def test_a_skin_with_a_name_is_found_by_it_by_its_fields_and_as_it_is(name: str) -> None:
    skin = SKINS[name]
    assert named(name) == named(skin) == named({"model": skin.model, "fixed": skin.fixed}) == name
    assert find_skin(skin) is not None
    assert skin.name == name


def test_any_other_skin_stays_itself() -> None:
    thick = find_skin("subsurface", scattering_per_mm=[1, 1, 1])
    assert named(thick) is thick or named(thick) == thick
    assert thick.name == "own-subsurface"
    assert thick.scattering_per_mm == (1.0, 1.0, 1.0)


def test_only_what_scatters_has_numbers_in_its_key() -> None:
    assert SKINS["reflective"].plain() == "reflective"
    assert SKINS["subsurface"].plain() != SKINS["subsurface_tone"].plain()


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"model": "wax"}, "skin.model=wax: wanted one of reflective"),
        ({"fixed": "nothing"}, "skin.fixed=nothing: wanted one of"),
        ({"absorption_per_mm": (-1, 0, 0)}, "three numbers >= 0"),
        ({"scattering_per_mm": (1, 1)}, "three numbers > 0"),
        ({"refractive_index": 1}, "a number > 1"),
        ({"reach_mm": 0}, "millimetres > 0"),
        ({"colour": 1}, "skin.colour does not exist"),
    ],
)
def test_wrong_fields_are_refused(wrong: dict, message: str) -> None:
    with pytest.raises(InputError, match=message):
        find_skin(wrong)


def test_an_unknown_name_says_what_exists() -> None:
    with pytest.raises(InputError, match="skin 'wax' does not exist; choose one of reflective"):
        find_skin("wax")


def test_a_skin_is_made_only_of_legal_numbers() -> None:
    with pytest.raises(InputError, match=r"skin\.refractive_index=3: wanted"):
        Skin(refractive_index=3)
