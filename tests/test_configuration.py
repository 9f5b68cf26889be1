from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import torch
from hydra.types import RunMode
from omegaconf import DictConfig, OmegaConf

from lrsr.configuration import (
    LARGEST_SEED,
    as_number,
    as_whole,
    flag,
    number,
    numbered,
    numbers,
    require,
    run_folder,
    section,
    seed_of,
    whole_number,
    whole_numbers,
    words,
)
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


@pytest.mark.parametrize(
    "seven",
    [np.int8(7), np.array(7), torch.tensor(7), np.uint64(7)],
    ids=lambda v: type(v).__name__,
)
def test_a_number_may_be_of_any_width(seven: object) -> None:
    assert as_whole(seven, "seed") == 7
    assert type(as_whole(seven, "seed")) is int
    assert type(as_number(seven, "level")) is float


@pytest.mark.parametrize(
    "half",
    [
        Decimal("0.5"),
        Fraction(1, 2),
        np.float16(0.5),
        torch.tensor(0.5, requires_grad=True),
        torch.tensor(0.5).bfloat16(),
    ],
    ids=repr,
)
def test_a_fraction_may_be_of_any_width_and_is_no_whole_number(half: object) -> None:
    assert as_number(half, "level") == 0.5
    with pytest.raises(InputError, match="wanted a whole number"):
        as_whole(half, "seed")


@pytest.mark.parametrize(
    "value", [np.ma.masked, torch.empty((), device="meta"), np.array([7]), np.bool_(True)], ids=repr
)
def test_what_holds_no_number_is_none(value: object) -> None:
    with pytest.raises(InputError, match="wanted a number"):
        as_number(value, "level")
    with pytest.raises(InputError, match="wanted a whole number"):
        as_whole(value, "seed")


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


@pytest.mark.parametrize("seed", [0, 7, LARGEST_SEED])
def test_a_seed_is_any_32_bits(seed: int) -> None:
    assert seed_of(config(seed=seed)) == seed


@pytest.mark.parametrize("seed", [-1, LARGEST_SEED + 1, 10**400, "7", 0.5, True, None, []])
def test_every_other_seed_is_refused(seed: object) -> None:
    with pytest.raises(InputError, match=r"seed=.*: wanted (0 to 4294967295|a whole number)"):
        seed_of(config(seed=seed))


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf"), 10**400])
def test_numbers_are_finite(value: float) -> None:
    with pytest.raises(InputError, match=r"ipd_px=.*: wanted a number"):
        numbers(config(ipd_px=value), "ipd_px")


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
