"""A roster comes back as it was, or says in one line why it cannot be used."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.morphable import RECIPE_VERSION
from lrsr.identities.person import Person
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.roster import Cast, IdentityRange, Roster, _read_roster, write_roster
from lrsr.identities.splits import LARGEST_INDEX, SPLITS, identity_seed

WOMEN = Population("female", ("asian",), (30, 50))
ROSTER = Roster(
    split="test",
    start=10,
    count=5,
    population=WOMEN,
    recipe=RECIPE_VERSION,
    encoder="dlib",
    angle_deg=11.2,
    draws={12: 1, 14: 3},
    unresolved=(14,),
)


def changed(path: Path, change: Callable[[dict[str, Any]], object]) -> Path:
    content = json.loads(path.read_text())
    change(content)
    path.write_text(json.dumps(content))
    return path


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return write_roster(tmp_path / "roster.json", ROSTER)


def test_a_roster_comes_back_as_it_was(path: Path) -> None:
    assert _read_roster(path) == ROSTER


def test_a_roster_is_the_same_bytes_each_time(path: Path, tmp_path: Path) -> None:
    shuffled = replace(ROSTER, draws={14: 3, 12: 1})
    assert write_roster(tmp_path / "b.json", shuffled).read_bytes() == path.read_bytes()


def test_who_was_redrawn_is_drawn_again_by_whoever_uses_the_roster() -> None:
    cast = Cast(WOMEN, ROSTER)
    assert [cast.draw("test", index) for index in range(10, 15)] == [0, 0, 1, 0, 3]


def test_people_of_other_splits_were_not_checked() -> None:
    assert Cast(WOMEN, ROSTER).draw("validation", 12) == 0
    assert Cast().draw("test", 10**6) == 0


def test_rosters_of_different_splits_never_share_a_person() -> None:
    # The seed alone tells the split, whatever was redrawn and however often.
    for split in ("train", "validation", "test"):
        roster = replace(ROSTER, split=split)  # type: ignore[arg-type]  # one of the splits
        cast = Cast(WOMEN, roster)
        seeds = [identity_seed(split, i, cast.draw(split, i)) for i in range(10, 15)]
        assert {SPLITS[seed % 3] for seed in seeds} == {split}


@pytest.mark.parametrize("index", [9, 15])
def test_nobody_outside_the_roster_takes_part(index: int) -> None:
    with pytest.raises(InputError, match=f"covers test 10 to 14, not {index}"):
        Cast(WOMEN, ROSTER).draw("test", index)


def test_a_roster_of_others_is_refused_with_the_words_to_add() -> None:
    with pytest.raises(InputError, match=r"sex=female .*=\[asian\] identities.age_years=\[30,50\]"):
        Cast(EVERYBODY, ROSTER)


def test_another_recipe_of_heads_needs_another_roster(tmp_path: Path) -> None:
    path = write_roster(tmp_path / "old.json", replace(ROSTER, recipe="0"))
    with pytest.raises(InputError, match=r"old\.json is of heads of recipe 0"):
        _read_roster(path)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda content: content["draws"].update({"12": 2}), "checksum"),
        (lambda content: content.update({"recipe": "x"}), "checksum"),
        (lambda content: content.pop("sha256"), "no roster"),
    ],
    ids=["draw", "recipe", "no checksum"],
)
def test_a_change_by_hand_is_noticed(path: Path, change: Any, says: str) -> None:
    with pytest.raises(InputError, match=says):
        _read_roster(changed(path, change))


@pytest.mark.parametrize(
    ("text", "says"), [("", "no JSON"), ("[1]", "no roster"), ("{}", "no roster")]
)
def test_what_is_no_roster_is_refused(tmp_path: Path, text: str, says: str) -> None:
    (tmp_path / "x.json").write_text(text)
    with pytest.raises(InputError, match=says):
        _read_roster(tmp_path / "x.json")


def test_a_roster_with_fields_of_another_version_is_refused(path: Path) -> None:
    from lrsr.identities.roster import _digest

    def rename(content: dict[str, Any]) -> None:
        del content["sha256"]
        del content["angle_deg"]
        content["sha256"] = _digest(content)

    with pytest.raises(InputError, match="no roster of this version"):
        _read_roster(changed(path, rename))


def test_a_file_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"cannot read .*none\.json: No such file"):
        _read_roster(tmp_path / "none.json")


def test_a_folder_that_cannot_be_written_is_one_line(path: Path) -> None:
    with pytest.raises(InputError, match="cannot write"):
        write_roster(path / "x.json", ROSTER)


@pytest.mark.parametrize(
    "wrong", [{"draws": {9: 1}}, {"draws": {12: -1}}, {"split": "dev"}, {"count": 0}, {"start": -1}]
)
def test_an_impossible_roster_is_refused(wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="a roster of"):
        replace(ROSTER, **wrong)


def test_settings_say_who_takes_part(path: Path) -> None:
    people = IdentityRange(
        start=11,
        count=4,
        sex="female",
        ancestry=("asian",),
        age_years=(30, 50),
        roster=str(path),
    )
    assert people.cast == Cast(WOMEN, ROSTER)
    assert people.people() == [
        Person("test", index, draw, WOMEN) for index, draw in ((11, 0), (12, 1), (13, 0), (14, 3))
    ]
    assert people.person(12).id == "test-00012-female-asian-30to50-draw1"


def test_without_settings_everybody_takes_part() -> None:
    people = IdentityRange(count=3)
    assert people.cast == Cast()
    assert people.people() == [Person("test", index) for index in range(3)]


def test_a_configurations_lists_are_values() -> None:
    listed = IdentityRange(ancestry=["asian"], age_years=[30, 50])  # type: ignore[arg-type]  # lists
    assert listed == IdentityRange(ancestry=("asian",), age_years=(30, 50))
    assert hash(listed) == hash(IdentityRange(ancestry=("asian",), age_years=(30, 50)))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"sex": "woman"}, r"identities\.sex=woman"),
        ({"ancestry": ("asian", "martian")}, r"identities\.ancestry=\[asian,martian\]"),
        ({"ancestry": ()}, r"identities\.ancestry=\[\]"),
        ({"age_years": (30,)}, r"identities\.age_years=\[30\]"),
        ({"split": "all"}, r"identities\.split=all: wanted one of train, validation, test"),
        ({"count": 0}, r"identities\.count=0: wanted at least 1"),
        ({"start": -1}, r"identities\.start=-1: wanted 0 to"),
        ({"start": LARGEST_INDEX, "count": 2}, r"identities\.start=\d+: wanted 0 to \d+"),
        ({"roster": "none.json"}, r"cannot read none\.json"),
    ],
    ids=str,
)
def test_settings_that_name_nobody_are_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        IdentityRange(**wrong)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"split": "train"}, r"identities\.split=train: wanted test, as the roster's"),
        ({"start": 9}, "identities.roster covers test 10 to 14, not 9"),
        ({"start": 11}, "identities.roster covers test 10 to 14, not 15"),
        ({"sex": "any"}, "identities.roster is of another population: add identities.sex=female"),
    ],
    ids=str,
)
def test_a_roster_of_others_is_refused_at_once(
    path: Path, changes: dict[str, Any], message: str
) -> None:
    given = {"start": 10, "count": 5, "sex": "female", "ancestry": ("asian",)}
    given |= {"age_years": (30, 50), "roster": str(path)}
    assert len(IdentityRange(**given).people()) == 5
    with pytest.raises(InputError, match=message):
        IdentityRange(**{**given, **changes})


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"count": "8"}, "identities.count=8: wanted a whole number"),
        ({"count": None}, "identities.count=null: wanted a whole number"),
        ({"start": 1.5}, "identities.start=1.5: wanted a whole number"),
        ({"ancestry": 8}, "identities.ancestry=8: wanted a list"),
        ({"ancestry": "asian"}, "identities.ancestry=asian: wanted a list"),
    ],
)
def test_people_of_another_kind_of_value_are_refused(given: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        IdentityRange(**given)


def test_numpys_numbers_are_numbers_of_people() -> None:
    assert IdentityRange(count=np.int64(3), start=np.int8(1)) == IdentityRange(count=3, start=1)
