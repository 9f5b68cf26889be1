import json
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.iris import _EDGE_ANGLE_RAD, _IRIS_COLOURS, paint_eye, sample_iris

BROWN = {
    "colour": "brown",
    "half_angle_rad": 0.4,
    "pupil_share": 0.4,
    "brightness": 1.0,
    "limbus": 0.8,
    "ring": 0.0,
    "redness": 0.3,
    "yellowness": 0.2,
    "warmth": 0.0,
    "fibre": 0.42,
    "lid_shadow": 1.0,
}


WIDE_OPEN = np.array([[(-50.0, 50.0), (50.0, 50.0)], [(-50.0, -50.0), (50.0, -50.0)]])
"""Lids so far away that they shade nothing."""


def _angle(size: int) -> NDArray[np.float64]:
    centred = (np.arange(size) + 0.5) / size * 2 - 1
    return np.hypot(*np.meshgrid(centred, centred)) * _EDGE_ANGLE_RAD


def _paint(iris: dict[str, Any], seed: int = 0, size: int = 256) -> NDArray[np.float32]:
    return paint_eye(iris, np.random.default_rng(seed), WIDE_OPEN, size)


@pytest.mark.parametrize("size", [64, 256])
def test_pupil_iris_and_sclera_meet_at_their_angles(size: int) -> None:
    eye, angle = _paint(BROWN, size=size).mean(axis=-1), _angle(size)
    assert eye[angle < 0.13].max() < 0.02
    iris = eye[(angle > 0.20) & (angle < 0.34)]
    assert 0.02 < iris.mean() < 0.1
    sclera = eye[(angle > 0.48) & (angle < 0.8)]
    assert sclera.min() > 0.25
    assert sclera.mean() < 0.33  # darker than a cheek, as in photographs
    assert sclera.mean() > 5 * iris.mean()


def test_a_wider_iris_covers_more() -> None:
    wide = _paint(BROWN | {"half_angle_rad": 0.43}).mean(axis=-1) < 0.2
    narrow = _paint(BROWN | {"half_angle_rad": 0.37}).mean(axis=-1) < 0.2
    assert wide.sum() / narrow.sum() == pytest.approx((0.43 / 0.37) ** 2, rel=0.05)


def test_the_limbus_is_darker_than_the_middle() -> None:
    eye, angle = _paint(BROWN).mean(axis=-1), _angle(256)
    assert (
        eye[(angle > 0.35) & (angle < 0.38)].mean() < 0.75 * eye[np.abs(angle - 0.26) < 0.04].mean()
    )


def test_fibres_run_along_the_radius() -> None:
    eye = _paint(BROWN).mean(axis=-1)
    radius, azimuth = np.meshgrid(np.linspace(0.2, 0.27, 12), np.linspace(0, 6.28, 300))
    pixel = 128 / _EDGE_ANGLE_RAD
    rows = np.round(127.5 - pixel * radius * np.sin(azimuth)).astype(int)
    columns = np.round(127.5 + pixel * radius * np.cos(azimuth)).astype(int)
    ring = eye[rows, columns]
    assert ring.std(axis=0).mean() > 1.5 * ring.std(axis=1).mean()


@pytest.mark.parametrize("colour", _IRIS_COLOURS)
def test_every_colour_is_a_reflectance(colour: str) -> None:
    eye = _paint(BROWN | {"colour": colour, "brightness": 1.6, "ring": 0.8})
    assert eye.shape == (256, 256, 3)
    assert eye.dtype == np.float32
    assert eye.min() >= 0
    assert eye.max() <= 1


def test_blue_eyes_are_bluer_than_brown_ones() -> None:
    middle = np.abs(_angle(256) - 0.27) < 0.05
    brown, blue = (_paint(BROWN | {"colour": c})[middle].mean(axis=0) for c in ("brown", "blue"))
    assert blue[2] > blue[0]
    assert brown[0] > 2 * brown[2]


def test_redness_reddens_the_sclera() -> None:
    corner = np.abs(_angle(256) - 1.1) < 0.1
    pale, red = (_paint(BROWN | {"redness": r})[corner].mean(axis=0) for r in (0.05, 1.0))
    assert red[0] / red[1] > 1.05 * pale[0] / pale[1]


def test_light_eyes_need_european_ancestry() -> None:
    rng = np.random.default_rng(0)

    def light(european: float, eumelanin: float) -> float:
        drawn = [
            sample_iris(rng, european=european, eumelanin=eumelanin, age=0.3)["colour"]
            for _ in range(200)
        ]
        return np.mean([colour in ("hazel", "green", "grey", "blue") for colour in drawn])

    assert light(0.0, 6.0) == 0
    assert light(1.0, 0.2) > 0.75
    assert 0.2 < light(1.0, 6.0) < 0.55


def test_samples_keep_to_the_recipe_and_are_plain() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        iris = sample_iris(rng, european=0.7, eumelanin=1.0, age=0.5)
        assert 0.33 <= iris["half_angle_rad"] <= 0.385
        assert json.loads(json.dumps(iris)) == iris


def test_the_same_seed_paints_the_same_eye() -> None:
    np.testing.assert_array_equal(_paint(BROWN, 3), _paint(BROWN, 3))
    assert (_paint(BROWN, 3) != _paint(BROWN, 4)).any()


def test_lids_shade_what_lies_below_them_most_at_the_upper_one() -> None:
    x = np.linspace(-0.8, 0.8, 20)
    margins = np.stack([np.stack([x, np.full(20, y)], axis=-1) for y in (0.3, -0.3)])
    white = BROWN | {"half_angle_rad": 0.05, "redness": 0.05}
    plain, shaded = (
        paint_eye(white, np.random.default_rng(0), given).mean(axis=-1)
        for given in (WIDE_OPEN, margins)
    )
    ratio = (shaded / plain)[:, 118:138].mean(axis=1)
    row = {y: round(127.5 - y / _EDGE_ANGLE_RAD * 128) for y in (0.28, 0.1, -0.15, -0.2)}
    assert ratio[row[0.28]] < 0.5
    assert ratio[row[0.1]] < ratio[row[-0.15]]
    assert 0.7 < ratio[row[-0.15]] <= 1.0
    assert ratio.max() <= 1.0


def test_the_inner_corner_is_flesh() -> None:
    x = np.linspace(0.8, -0.8, 20)
    margins = np.stack([np.stack([x, np.full(20, y)], axis=-1) for y in (0.2, -0.2)])
    eye = paint_eye(BROWN, np.random.default_rng(0), margins)
    inner, outer = (eye[127, round(127.5 + side * 60)] for side in (1, -1))
    assert inner[0] / inner[1] > 1.4 * outer[0] / outer[1]
