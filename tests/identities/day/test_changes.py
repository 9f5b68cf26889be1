from collections.abc import Callable

import numpy as np
import pytest

from lrsr.identities.head import Head

Make = Callable[..., Head]

KINDS = ("hair", "greyer", "stubble", "make_up", "tan", "weight", "years")
OWN = ("seed", "sex", "masculinity", "ancestry")
SKIN_DEEP = ("marks", "iris", "lips", "lashes")


@pytest.mark.parametrize("kind", [*KINDS, "everything"])
def test_the_person_stays(person: Make, kind: str) -> None:
    then, now = person(1), person(1, kind)
    for name in OWN:
        assert now.parameters[name] == then.parameters[name]
    before, after = (head.parameters["appearance"] for head in (then, now))
    assert {name: after[name] for name in SKIN_DEEP} == {name: before[name] for name in SKIN_DEEP}  # type: ignore[index]
    old, new = (head.parameters["anatomy"]["sliders"] for head in (then, now))  # type: ignore[index]
    moved = {name for name in {*old, *new} if old.get(name, 0.0) != new.get(name, 0.0)}
    assert all("fat" in name or "volume" in name or "double" in name for name in moved)
    for which in (1, 2):
        np.testing.assert_array_equal(now.parts[which].uv, then.parts[which].uv)


@pytest.mark.parametrize("kind", ["hair", "greyer", "make_up", "tan", "stubble"])
def test_what_changes_no_shape_leaves_eyes_and_landmarks_where_they_were(
    person: Make, kind: str
) -> None:
    for index in (0, 1):
        then, now = person(index), person(index, kind)
        np.testing.assert_array_equal(now.landmarks, then.landmarks)
        np.testing.assert_array_equal(now.part("left_eye").albedo, then.part("left_eye").albedo)


@pytest.mark.parametrize("kind", KINDS)
def test_somebody_changes_and_it_is_recorded(person: Make, kind: str) -> None:
    came = [person(index, kind).parameters["another_day"] for index in (0, 1)]
    assert any(kind in one for one in came)  # type: ignore[operator]
    assert all({*one} <= {kind} for one in came)  # type: ignore[misc]


def test_an_enrolled_person_has_no_other_day(person: Make) -> None:
    assert "another_day" not in person(0).parameters


def test_a_tan_is_more_melanin_and_darker_skin(person: Make) -> None:
    then, now = person(0), person(0, "tan")
    melanin = [head.parameters["appearance"]["complexion"]["melanin"] for head in (then, now)]  # type: ignore[index]
    tan = now.parameters["another_day"]["tan"]  # type: ignore[index]
    assert np.log(melanin[1] / melanin[0]) == pytest.approx(tan, abs=1e-3)
    assert now.part("skin").albedo.mean() < then.part("skin").albedo.mean()


def test_hair_that_greys_is_lighter(person: Make) -> None:
    then, now = person(1), person(1, "greyer")
    assert now.part("hair").albedo.mean() > 1.2 * then.part("hair").albedo.mean()


def test_years_are_added_to_the_age_and_lines_deepen(person: Make) -> None:
    then, now = person(1), person(1, "years")
    gone = now.parameters["age_years"] - then.parameters["age_years"]  # type: ignore[operator]
    assert gone == pytest.approx(now.parameters["another_day"]["years"], abs=0.01)  # type: ignore[index]
    assert not np.array_equal(now.part("skin").vertices, then.part("skin").vertices)


def test_weight_gained_widens_the_face_and_lost_narrows_it(person: Make) -> None:
    for index in (0, 1):
        then, now = person(index), person(index, "weight")
        gained = now.parameters["another_day"]["weight"]  # type: ignore[index]
        cheeks = [
            np.ptp(v[(np.abs(v[:, 1] + 60) < 8) & (v[:, 2] > -40), 0])
            for v in (head.part("skin").vertices for head in (then, now))
        ]
        assert (cheeks[1] - cheeks[0]) * gained > 0


def test_women_have_no_stubble_and_men_no_make_up(person: Make) -> None:
    assert person(0).parameters["sex"] == "female"
    assert not person(0, "stubble").parameters["another_day"]
    assert not person(1, "make_up").parameters["another_day"]
