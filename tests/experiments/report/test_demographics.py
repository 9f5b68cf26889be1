import io
import json
from dataclasses import replace

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.image import imread

from lrsr.experiments.report.demographics import DECADES, draw_spread, spread
from lrsr.identities.person import TONES, Traits, _tone_of
from lrsr.identities.population import ANCESTRIES, OLDEST_YEARS, YOUNGEST_YEARS

ASIAN = {"african": 0.1, "asian": 0.8, "caucasian": 0.1}
MIXED = {"african": 0.4, "asian": 0.2, "caucasian": 0.4}
JANE = Traits("female", 29.99, ASIAN, 45.0, "light")
JOHN = Traits("male", 30.0, MIXED, -35.0, "dark")


def crowd(count: int, seed: int = 0) -> list[Traits]:
    rng = np.random.default_rng(seed)
    people = []
    for _ in range(count):
        shares = dict(zip(ANCESTRIES, rng.dirichlet([0.5] * 3).tolist(), strict=True))
        ita_deg = float(rng.uniform(-60, 70))
        age = float(rng.uniform(YOUNGEST_YEARS, OLDEST_YEARS))
        sex = str(rng.choice(["female", "male"]))
        people.append(Traits(sex, age, shares, ita_deg, _tone_of(ita_deg)))
    return people


def test_two_people_are_counted_by_hand() -> None:
    found = spread([JANE, JOHN])
    assert found["people"] == 2
    assert found["sex"] == {"female": 1, "male": 1}
    assert found["age_years"] == {
        "spans": {
            "18 to 29": 1, "30 to 39": 1, "40 to 49": 0, "50 to 59": 0, "60 to 69": 0,
            "70 to 80": 0,
        },
        "mean": pytest.approx(29.995),
        "youngest": 29.99,
        "oldest": 30.0,
    }  # fmt: skip
    assert found["ancestry"]["mainly"] == {"african": 0, "asian": 1, "caucasian": 0, "mixed": 1}
    assert found["ancestry"]["mean_share"] == {
        "african": pytest.approx(0.25),
        "asian": pytest.approx(0.5),
        "caucasian": pytest.approx(0.25),
    }
    assert found["skin_tone"]["classes"] == dict.fromkeys(TONES, 0) | {"light": 1, "dark": 1}
    assert found["skin_tone"]["ita_deg"]["p50"] == pytest.approx(5.0)


def test_everybody_is_in_one_class_of_each_kind() -> None:
    found = spread(crowd(300))
    for counts in (
        found["sex"],
        found["age_years"]["spans"],
        found["ancestry"]["mainly"],
        found["skin_tone"]["classes"],
    ):
        assert sum(counts.values()) == 300
    assert sum(found["ancestry"]["mean_share"].values()) == pytest.approx(1)


def test_two_sets_add_up() -> None:
    one, other = crowd(40, 1), crowd(60, 2)
    parts, whole = [spread(one), spread(other)], spread(one + other)
    for tone in TONES:
        counted = sum(part["skin_tone"]["classes"][tone] for part in parts)
        assert whole["skin_tone"]["classes"][tone] == counted


def test_the_order_of_people_does_not_count() -> None:
    people = crowd(50)
    backwards = spread(people[::-1])
    assert backwards["age_years"]["spans"] == spread(people)["age_years"]["spans"]
    assert backwards["skin_tone"] == spread(people)["skin_tone"]


def test_every_age_that_can_be_drawn_is_in_a_span() -> None:
    assert DECADES[0] <= YOUNGEST_YEARS
    assert DECADES[-1] > OLDEST_YEARS
    oldest = replace(JANE, age_years=OLDEST_YEARS)
    assert sum(spread([oldest])["age_years"]["spans"].values()) == 1


@pytest.mark.parametrize(
    ("share", "mainly"), [(0.5, "african"), (0.4999, "mixed")], ids=["half", "less"]
)
def test_half_is_enough_to_be_mainly_of_one_ancestry(share: float, mainly: str) -> None:
    rest = (1 - share) / 2
    person = replace(JANE, ancestry={"african": share, "asian": rest, "caucasian": rest})
    assert spread([person])["ancestry"]["mainly"][mainly] == 1


def test_nobody_is_counted_without_a_word() -> None:
    found = spread([])
    assert found["people"] == 0
    assert set(found["sex"].values()) == {0}
    assert "mean" not in found["age_years"]
    assert found["skin_tone"]["ita_deg"] == {}


@pytest.mark.parametrize("count", [0, 1, 30])
def test_a_spread_survives_json(count: int) -> None:
    found = spread(crowd(count))
    assert json.loads(json.dumps(found, allow_nan=False)) == found


def test_a_spread_is_drawn_at_200_dots_an_inch() -> None:
    height, width, _ = imread(io.BytesIO(draw_spread(crowd(30)))).shape
    assert (height, width) == pytest.approx((4.6 * 200, 7.2 * 200), abs=1)


def test_the_same_person_alone_is_the_same_bytes() -> None:
    assert draw_spread([JANE]) == draw_spread([JANE])


def test_an_angle_beyond_the_usual_is_drawn_too() -> None:
    assert draw_spread([replace(JANE, ita_deg=85.0), replace(JOHN, ita_deg=-85.0)])


def test_drawing_leaves_the_plot_settings_alone() -> None:
    before = dict(mpl.rcParams)
    draw_spread([JANE])
    assert dict(mpl.rcParams) == before
