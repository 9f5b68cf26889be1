"""Skin is classed by its colour in CIELAB, as a dermatologist would measure it on the cheeks."""

import json
from dataclasses import asdict, replace
from typing import Any

import numpy as np
import pytest
from skimage.color import rgb2lab

from lrsr.errors import InputError
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head, Part
from lrsr.identities.morphable import sample_head
from lrsr.identities.person import (
    TONES,
    Person,
    _cheek_reflectance,
    _tone_of,
    _typology_angle_deg,
    describe,
)
from lrsr.identities.population import EVERYBODY, Population
from lrsr.identities.splits import LARGEST_INDEX, SPLITS, identity_seed

LANDMARKS = np.array(
    [[-32.0, 0, 0], [32.0, 0, 0], [0, -40.0, 20], [-25.0, -65.0, 5], [25.0, -65.0, 5]]
)


def face(left: tuple[float, ...], right: tuple[float, ...], elsewhere: float = 0.9) -> Head:
    """A flat face, 200 mm wide: two tones where the cheeks are, another everywhere else."""
    x, y = np.meshgrid(np.linspace(-100, 100, 81), np.linspace(60, -140, 81))
    vertices = np.stack([x, y, np.zeros_like(x)], axis=-1).reshape(-1, 3).astype(np.float32)
    uv = np.stack([(x + 100) / 200, (60 - y) / 200], axis=-1).reshape(-1, 2).astype(np.float32)
    albedo = np.full((128, 128, 3), elsewhere, np.float32)
    height = slice(int(128 * 80 / 200), int(128 * 118 / 200))  # y from -20 to -58 mm
    albedo[height, int(128 * 50 / 200) : int(128 * 72 / 200)] = left  # x from -50 to -28 mm
    albedo[height, int(128 * 128 / 200) : int(128 * 150 / 200) + 1] = right
    skin = Part("skin", "skin", vertices, np.zeros((0, 3), np.int32), uv, albedo)
    drawn = {"sex": "female", "age_years": 41.234, "ancestry": {"asian": 0.8, "african": 0.2}}
    return Head("x", (skin,), LANDMARKS[:2], LANDMARKS, drawn)


@pytest.mark.parametrize(
    "linear", [(0.55, 0.36, 0.27), (0.35, 0.19, 0.12), (0.12, 0.05, 0.03)], ids=str
)
def test_the_angle_is_that_of_another_tool(linear: tuple[float, ...]) -> None:
    srgb = 1.055 * np.array(linear) ** (1 / 2.4) - 0.055  # above the linear toe
    lightness, _, yellowness = rgb2lab(srgb[None, None])[0, 0]
    angle = np.degrees(np.arctan((lightness - 50) / yellowness))
    assert _typology_angle_deg(linear) == pytest.approx(angle, abs=0.05)


def test_lighter_skin_has_the_larger_angle() -> None:
    skin = np.array([0.4, 0.22, 0.15])
    angles = [_typology_angle_deg(skin * light) for light in (0.3, 0.6, 1.0, 1.5)]
    assert angles == sorted(angles)


def test_a_grey_has_an_angle_too() -> None:
    assert _typology_angle_deg([0.5, 0.5, 0.5]) == pytest.approx(90, abs=0.1)
    assert _typology_angle_deg([0.0, 0.0, 0.0]) == pytest.approx(-90, abs=0.1)


def test_the_classes_are_those_of_the_paper() -> None:
    # Del Bino and Bernerd 2013: > 55 > 41 > 28 > 10 > -30 >
    angles = (55.1, 55, 41, 28, 10, -30)
    assert [_tone_of(angle) for angle in angles] == list(TONES)


def test_both_cheeks_are_measured_and_nothing_else() -> None:
    tone = np.array([0.4, 0.2, 0.1])
    np.testing.assert_allclose(_cheek_reflectance(face(tone, tone)), tone, rtol=1e-6)


def test_a_mole_on_the_cheek_does_not_count() -> None:
    head = face((0.4, 0.2, 0.1), (0.4, 0.2, 0.1))
    head.parts[0].albedo[60:64, 36:40] = 0.01
    np.testing.assert_allclose(_cheek_reflectance(head), [0.4, 0.2, 0.1], rtol=1e-6)


def test_a_head_is_described_by_what_was_drawn_and_what_is_measured() -> None:
    traits = describe(face((0.55, 0.36, 0.27), (0.55, 0.36, 0.27)))
    assert (traits.sex, traits.age_years, traits.skin_tone) == ("female", 41.23, "light")
    assert traits.ancestry == {"asian": 0.8, "african": 0.2}
    assert traits.ita_deg == pytest.approx(_typology_angle_deg([0.55, 0.36, 0.27]), abs=0.01)


def test_what_the_gate_did_is_recorded_where_it_is_known() -> None:
    head = face((0.4,) * 3, (0.4,) * 3)
    assert describe(head).gate is None
    did = {"redraws": 1, "failures": [["size"]]}
    assert describe(replace(head, parameters={**head.parameters, "gate": did})).gate == did


def test_a_head_of_unknown_origin_cannot_be_described() -> None:
    with pytest.raises(KeyError, match="sex"):
        describe(replace(face((0.4,) * 3, (0.4,) * 3), parameters={"age_years": 30.0}))


def test_somebody_is_a_value() -> None:
    women = Population("female", ("asian", "african"), (30, 50))
    same = Person("test", np.int64(7), np.int8(1), Population("female", ("african", "asian")))
    assert Person("test", 7) == Person("test", np.int64(7), 0, EVERYBODY)
    assert len({Person("test", 7), Person("test", 7, 0, Population())}) == 1
    assert same == replace(Person("test", 7, 1, women), population=same.population)
    assert json.loads(json.dumps(asdict(same)))["index"] == 7


def test_everybody_has_another_name() -> None:
    people = [
        Person(split, index, draw, population)
        for split in SPLITS
        for index in (0, 1, 100000)
        for draw in (0, 1)
        for population in (EVERYBODY, Population("male"), Population(age_years=(25, 40)))
    ]
    assert len({person.id for person in people}) == len(people)
    assert Person("train", 3).id == "train-00003"
    assert Person("test", 100000, 2).id == "test-100000-draw2"


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"split": "testing"}, "identities.split=testing: wanted one of train, validation, test"),
        ({"index": -1}, "index=-1: wanted 0 to"),
        ({"index": LARGEST_INDEX + 1}, f"index={LARGEST_INDEX + 1}: wanted 0 to {LARGEST_INDEX}"),
        ({"index": 0.5}, "index=0.5: wanted a whole number"),
        ({"draw": -1}, "draw=-1: wanted 0 to"),
        ({"draw": True}, "draw=[Tt]rue: wanted a whole number"),
    ],
    ids=str,
)
def test_nobody_is_out_of_range(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Person(**{"split": "test", "index": 0, **wrong})


def test_a_head_is_that_of_the_seed_under_the_name_of_the_person() -> None:
    women = Population("female")
    person, smile = Person("validation", 2, 1, women), Expression("smile", {"mouthSmile": 0.5})
    head = person.head(smile, 64)
    wanted = sample_head(
        identity_seed("validation", 2, 1), texture_size=64, population=women, expression=smile
    )
    assert head.identity_id == "validation-00002-female-draw1"
    for mine, theirs in zip(head.parts, wanted.parts, strict=True):
        np.testing.assert_array_equal(mine.vertices, theirs.vertices)
        np.testing.assert_array_equal(mine.albedo, theirs.albedo)
    assert describe(head).sex == "female"
