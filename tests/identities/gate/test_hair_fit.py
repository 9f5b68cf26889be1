from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.face.template import template
from lrsr.identities.gate.hair_fit import HairFit, grow_shell, measure_hair
from lrsr.identities.hair.hair import STYLES, build_hair, colour_parameters, style_parameters
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS

Points = NDArray[np.float32]

COLOUR = {"eumelanin": 2.0, "pheomelanin": 0.2, "grey": 0.1}
SHELL = COLUMNS * ROWS
OFF_MM = 22.0


@lru_cache(maxsize=1)
def skin() -> Points:
    return template().skin.astype(np.float32)


@lru_cache(maxsize=4)
def grown(style: str) -> Points:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    return build_hair(numbers, skin(), seed=3).vertices


def fit_of(hair: Points, *, stands: bool = True) -> HairFit:
    return measure_hair(hair, skin(), template().eyes.pupils, stands=stands)


@pytest.mark.parametrize("style", STYLES)
def test_every_style_is_attached_to_the_template(style: str) -> None:
    fit = fit_of(grown(style), stands=style != "shaved")
    assert fit.off_skin_mm < OFF_MM
    assert fit.ribbons_off_mm < 14.0


def test_a_wig_that_floats_is_off_the_skin_by_as_much() -> None:
    usual, floating = fit_of(grown("crop")), fit_of(grown("crop") + np.float32([0, 40, 0]))
    assert floating.off_skin_mm > OFF_MM > usual.off_skin_mm
    assert floating.edge_mm >= usual.edge_mm


def test_ribbons_that_fly_away_are_told_from_a_shell_that_does() -> None:
    flying = grown("crop").copy()
    flying[SHELL:] += np.float32([0, 60, 0])
    usual, wrong = fit_of(grown("crop")), fit_of(flying)
    assert wrong.ribbons_off_mm > 14.0 > usual.ribbons_off_mm
    assert wrong.off_skin_mm == usual.off_skin_mm


def test_short_hair_leaves_eyes_and_face_free() -> None:
    fit = fit_of(grown("crop"))
    assert (fit.before_eyes, fit.before_face) == (0.0, 0.0)


def test_hair_pulled_over_the_eyes_and_over_the_mouth_is_told_apart() -> None:
    curtain = np.zeros_like(grown("crop"))
    curtain[:] = (31.0, 0.0, 10.0)
    over_an_eye = fit_of(curtain)
    curtain[:] = (0.0, -60.0, 40.0)
    over_the_mouth = fit_of(curtain)
    assert (over_an_eye.before_eyes, over_an_eye.before_face) == (1.0, 0.0)
    assert (over_the_mouth.before_eyes, over_the_mouth.before_face) == (0.0, 1.0)


def test_hair_behind_the_face_is_not_before_it() -> None:
    behind = np.zeros_like(grown("crop"))
    behind[:] = (0.0, -60.0, -90.0)
    fit = fit_of(behind)
    assert (fit.before_eyes, fit.before_face) == (0.0, 0.0)


def test_an_edge_lifted_off_the_forehead_is_a_helmets() -> None:
    lifted = grown("crop").copy()
    shell = lifted[:SHELL].reshape(COLUMNS, ROWS, 3)
    front = (np.abs(shell[:, -1, 0]) < 55.0) & (shell[:, -1, 2] > -60.0) & (shell[:, -1, 1] > 25.0)
    assert front.any()
    shell[front, -2:, 2] += 25.0
    lifted[:SHELL] = shell.reshape(-1, 3)
    assert fit_of(lifted).edge_mm > 14.0 > fit_of(grown("crop")).edge_mm


def test_a_shaved_head_has_no_edge() -> None:
    assert fit_of(grown("shaved"), stands=False).edge_mm == 0.0


@pytest.mark.parametrize("style", STYLES)
def test_a_shell_grown_alone_is_that_of_the_whole_hair(style: str) -> None:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    np.testing.assert_array_equal(grow_shell(numbers, skin(), 3), grown(style)[:SHELL])


def test_a_shell_alone_fits_as_it_does_under_ribbons() -> None:
    whole, shell = fit_of(grown("bob")), fit_of(grown("bob")[:SHELL])
    assert (shell.off_skin_mm, shell.edge_mm) == (whole.off_skin_mm, whole.edge_mm)
    assert shell.ribbons_off_mm == 0.0
