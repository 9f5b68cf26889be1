from dataclasses import dataclass

import pytest
from omegaconf import DictConfig, OmegaConf

from lrsr.configuration import number, numbers, require, section, whole_number, whole_numbers, words
from lrsr.errors import InputError


@dataclass(frozen=True)
class Meal:
    name: str = "soup"
    plates: int = 1

    def __post_init__(self) -> None:
        require(self.plates > 0, "meal.plates", self.plates, "at least 1")


def config(**values: object) -> DictConfig:
    return OmegaConf.create(values)


def test_section_becomes_its_dataclass() -> None:
    assert section(Meal, config(meal={"plates": 3}), "meal") == Meal("soup", 3)


def test_section_follows_interpolations() -> None:
    found = section(Meal, config(guests=4, meal={"plates": "${guests}"}), "meal")
    assert found.plates == 4


@pytest.mark.parametrize(
    ("meal", "says"),
    [
        ({"plates": "many"}, r"meal\.plates: Value 'many'"),
        ({"plates": 0}, r"meal\.plates=0: wanted at least 1"),
        ({"dishes": 1}, r"meal"),
    ],
)
def test_section_names_the_wrong_setting(meal: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        section(Meal, config(meal=meal), "meal")


def test_one_value_is_a_list_of_one() -> None:
    assert numbers(config(ipd_px=8), "ipd_px") == [8.0]
    assert whole_numbers(config(options=[1, 6]), "options") == [1, 6]
    assert words(config(methods="base"), "methods") == ["base"]


def test_numbers_are_numbers() -> None:
    settings = config(level=0.95, seed=7)
    assert number(settings, "level") == 0.95
    assert whole_number(settings, "seed") == 7


@pytest.mark.parametrize("value", ["high", True, None, [1]])
def test_number_refuses_what_is_none(value: object) -> None:
    with pytest.raises(InputError, match=r"level=.*: wanted a number"):
        number(config(level=value), "level")


@pytest.mark.parametrize("value", ["7", 0.5, True])
def test_whole_number_refuses_what_is_none(value: object) -> None:
    with pytest.raises(InputError, match=r"seed=.*: wanted a whole number"):
        whole_number(config(seed=value), "seed")


def test_a_list_is_refused_for_one_wrong_number() -> None:
    with pytest.raises(InputError, match="options=x: wanted a whole number"):
        whole_numbers(config(options=[1, "x"]), "options")
    with pytest.raises(InputError, match="ipd_px=x: wanted a number"):
        numbers(config(ipd_px=[8, "x"]), "ipd_px")


def test_require_lets_the_good_pass() -> None:
    require(True, "seed", 0, "at least 0")
