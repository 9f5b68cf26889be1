import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.gate.anthropometry import (
    _LENGTHS,
    _LIMIT_SD,
    PROPORTIONS,
    Sex,
    brow_rise_degrees,
    limits,
    measure_crookedness,
    measure_lengths,
    nose_depth_mm,
    proportions,
    sigma_z,
    z_scores,
)

# North American whites, mm: Farkas et al., J. Craniofac. Surg. 16 (2005) 615-646.
PUBLISHED: dict[Sex, dict[str, float]] = {
    "female": {
        "face height": 111.4,
        "face width": 131.1,
        "lower face height": 64.3,
        "nose height": 50.6,
        "nose width": 31.4,
        "mouth width": 49.8,
        "biocular width": 86.8,
        "intercanthal width": 31.8,
        "interpupillary distance": 61.7,
    },
    "male": {
        "face height": 121.3,
        "face width": 137.1,
        "lower face height": 71.9,
        "nose height": 53.0,
        "nose width": 34.7,
        "mouth width": 53.3,
        "biocular width": 89.4,
        "intercanthal width": 32.9,
        "interpupillary distance": 64.7,
    },
}
WITHOUT_OFFSET = (
    "interpupillary distance",
    "face height",
    "face width",
    "face to pupils' width",
    "facial index",
    "nasal index",
    "nose to face width",
    "mouth to face width",
    "nose to mouth width",
    "biocular to face width",
    "intercanthal index",
)


def skin() -> NDArray[np.float64]:
    return template().skin.copy()


def lengths_of(known: dict[str, float]) -> dict[str, float]:
    return dict.fromkeys(_LENGTHS, 50.0) | known


@pytest.mark.parametrize("sex", ["female", "male"])
@pytest.mark.parametrize("name", WITHOUT_OFFSET)
def test_published_averages_are_average(name: str, sex: Sex) -> None:
    scores = z_scores(proportions(lengths_of(PUBLISHED[sex])), sex)
    assert abs(scores[name]) < 1.2


def test_the_template_is_within_all_limits_of_both_sexes() -> None:
    measured = proportions(measure_lengths(skin(), 63.0))
    for proportion in PROPORTIONS:
        for sex in ("female", "male"):
            low, high = limits(proportion, sex)
            assert low < measured[proportion.name] < high, proportion.name


def test_a_head_twice_as_large_has_twice_the_lengths_and_the_same_shares() -> None:
    once, twice = measure_lengths(skin(), 60.0), measure_lengths(2 * skin(), 120.0)
    assert {name: 2 * length for name, length in once.items()} == pytest.approx(twice)
    for proportion in PROPORTIONS:
        factor = 1.0 if proportion.whole else 2.0
        small, large = (proportions(lengths)[proportion.name] for lengths in (once, twice))
        assert large == pytest.approx(factor * small)


def test_a_narrower_head_is_narrower_and_as_high() -> None:
    usual, narrow = (
        measure_lengths(skin() * scale, 60.0) for scale in ((1.0, 1.0, 1.0), (0.5, 1.0, 1.0))
    )
    assert narrow["face width"] == pytest.approx(usual["face width"] / 2)
    assert narrow["mouth width"] == pytest.approx(usual["mouth width"] / 2)
    assert narrow["face height"] == pytest.approx(usual["face height"])


def test_the_skull_is_measured_upright() -> None:
    flat = skin() * (1.0, 1.0, 0.1)
    assert measure_lengths(flat, 60.0)["skull height"] == pytest.approx(
        measure_lengths(skin(), 60.0)["skull height"]
    )


def test_the_mean_has_a_score_of_nought_and_the_limits_have_the_limits() -> None:
    middles = {p.name: sum(limits(p, "male")) / 2 for p in PROPORTIONS}
    highest = {p.name: limits(p, "male")[1] for p in PROPORTIONS}
    assert list(z_scores(middles, "male").values()) == pytest.approx([0.0] * len(PROPORTIONS))
    assert list(z_scores(highest, "male").values()) == pytest.approx([_LIMIT_SD] * len(PROPORTIONS))


def test_sigma_z_does_not_mind_a_face_that_is_evenly_large() -> None:
    scores = {"a": -1.0, "b": 0.5, "c": 2.0}
    shifted = {name: score + 3.0 for name, score in scores.items()}
    assert sigma_z(scores) == pytest.approx(np.std([-1.0, 0.5, 2.0]))
    assert sigma_z(shifted) == pytest.approx(sigma_z(scores))
    assert sigma_z({name: 2 * score for name, score in scores.items()}) == pytest.approx(
        2 * sigma_z(scores)
    )


def test_a_nose_is_as_deep_as_its_tip_lies_before_its_wings() -> None:
    usual, flat = skin(), skin() * (1.0, 1.0, 0.5)
    assert 15.0 < nose_depth_mm(usual) < 26.0
    assert nose_depth_mm(flat) == pytest.approx(nose_depth_mm(usual) / 2)
    assert nose_depth_mm(np.add(usual, (5.0, 3.0, -8.0))) == pytest.approx(nose_depth_mm(usual))


def test_the_template_is_not_crooked() -> None:
    assert tuple(measure_crookedness(skin()).values()) == pytest.approx((0.0, 0.0), abs=1e-6)


def test_a_head_turned_in_the_picture_plane_has_a_canted_mouth() -> None:
    angle = np.radians(7.0)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    assert measure_crookedness(skin() @ turn.T)[
        "crooked: cant of the mouth, degrees"
    ] == pytest.approx(7.0)


def test_a_brow_rises_by_what_the_head_is_turned_in_the_picture_plane() -> None:
    angle = np.radians(7.0)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    left, right = brow_rise_degrees(skin())
    assert left == pytest.approx(right, abs=1e-3)
    assert brow_rise_degrees(skin() @ turn.T) == pytest.approx((left + 7.0, right - 7.0))


def test_a_sheared_head_has_its_mouth_aside() -> None:
    sheared = skin()
    sheared[:, 0] += 0.1 * sheared[:, 1]
    _, mouth = measure_crookedness(sheared).values()
    assert mouth == pytest.approx(7.5, abs=0.2)  # 75 mm below the nasion


def test_crookedness_is_that_of_the_mirrored_head() -> None:
    one, other = skin(), skin()
    one[:, 0] += 0.05 * one[:, 1]
    other[:, 0] -= 0.05 * other[:, 1]
    assert measure_crookedness(one) == pytest.approx(measure_crookedness(other), abs=1e-3)
