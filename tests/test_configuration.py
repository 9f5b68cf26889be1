from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace

import pytest
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from lrsr.configuration import (
    LIMITS,
    check_limits,
    flag,
    number,
    numbered,
    numbers,
    require,
    run_folder,
    section,
    whole_number,
    whole_numbers,
    words,
)
from lrsr.errors import InputError
from lrsr.identities.splits import LARGEST_INDEX


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


@pytest.mark.parametrize("key", LIMITS)
def test_what_every_command_is_given_has_one_range(key: str) -> None:
    _, low, high = LIMITS[key]
    outer, _, inner = key.rpartition(".")
    for value in (low, high, [low, high]):
        check_limits(config(**({outer: {inner: value}} if outer else {inner: value})))
    for value in (low - 1, high + 1, [low, high + 1], -(10**400), 10**400, "x", True, [], "1"):
        with pytest.raises(InputError, match=rf"{key}=.*: wanted a"):
            check_limits(config(**({outer: {inner: value}} if outer else {inner: value})))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_numbers_are_finite(value: float) -> None:
    with pytest.raises(InputError, match=r"ipd_px=.*: wanted a finite number"):
        check_limits(config(ipd_px=value))


def test_limits_are_for_what_is_there() -> None:
    check_limits(config(ipd_px=None, seed="???", identities=None))


def test_the_last_of_the_most_people_has_a_seed() -> None:
    assert LIMITS["identities.start"][2] + LIMITS["identities.count"][2] <= LARGEST_INDEX


def test_a_flag_is_true_or_false() -> None:
    assert flag(config(resume=False), "resume") is False
    with pytest.raises(InputError, match="resume=no: wanted true or false"):
        flag(config(resume="no"), "resume")


def test_a_value_is_told_as_it_is_typed() -> None:
    with pytest.raises(InputError, match="seed=null: wanted a whole number"):
        whole_number(config(seed=None), "seed")


def test_the_lines_words_change_the_files_numbers() -> None:
    given = config(conditions={1: {"pose": "up", "light": "a"}, "1": {"pose": "left"}, "7": {}})
    assert numbered(given, "conditions") == {1: {"pose": "left", "light": "a"}, 7: {}}


@pytest.mark.parametrize("table", [{"one": {}}, {"1": "left"}])
def test_numbered_parts_have_numbers(table: dict[str, object]) -> None:
    with pytest.raises(InputError, match=r"conditions\.\w+=.*: wanted"):
        numbered(config(conditions=table), "conditions")


@pytest.fixture
def in_hydra(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> SimpleNamespace:
    job = SimpleNamespace(mode=RunMode.RUN, job=SimpleNamespace(config_name="eval", num=3))
    monkeypatch.setattr("hydra.core.hydra_config.HydraConfig.get", lambda: job)
    monkeypatch.chdir(tmp_path)
    return job


def test_runs_of_one_second_have_a_folder_each(in_hydra: SimpleNamespace, tmp_path: Path) -> None:
    given = config(paths={"run": None, "runs": "my runs"})
    with run_folder(given) as first, run_folder(given) as second:
        assert first != second
        assert first.parent == second.parent == tmp_path / "my runs" / "eval"


def test_a_given_folder_is_for_one_at_a_time_and_can_be_gone_on_with(
    in_hydra: SimpleNamespace, tmp_path: Path
) -> None:
    given = config(paths={"run": "x", "runs": "runs"})
    with run_folder(given) as folder, pytest.raises(InputError, match="in use"), run_folder(given):
        pass
    with run_folder(given) as again:
        assert again == folder == tmp_path / "x"


def test_the_jobs_of_a_multirun_lie_below_a_given_folder(
    in_hydra: SimpleNamespace, tmp_path: Path
) -> None:
    in_hydra.mode = RunMode.MULTIRUN
    with run_folder(config(paths={"run": "x", "runs": "runs"})) as folder:
        assert folder == tmp_path / "x" / "3"
