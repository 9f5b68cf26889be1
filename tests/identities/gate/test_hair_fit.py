from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.gate.hair_fit import measure_hair
from lrsr.identities.hair.choice import colour_parameters
from lrsr.identities.hair.hair import build_hair
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS, lay_shell, strand_stream
from lrsr.identities.hair.strands import _RIBBONS
from lrsr.identities.hair.styles import STYLES, style_parameters

Points = NDArray[np.float32]

COLOUR = {"eumelanin": 2.0, "pheomelanin": 0.2, "grey": 0.1}
SHELL = COLUMNS * ROWS
OFF_MM = 22.0
OFF, EYES, FACE, EDGE = (
    "hair: off the skin, mm",
    "hair: share before the eyes",
    "hair: share before nose and mouth",
    "hair: height of the edge on the forehead, mm",
)


@lru_cache(maxsize=1)
def skin() -> Points:
    return template().skin.astype(np.float32)


@lru_cache(maxsize=4)
def grown(style: str) -> Points:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    return build_hair(numbers, skin(), seed=3).vertices


def ribbons_off_mm(hair: Points) -> float:
    """How far ribbons stay off skin and shell even where they come nearest, the 99th percentile."""
    bed = cKDTree(np.concatenate([skin(), hair[:SHELL]]))
    some = hair[SHELL:].reshape(_RIBBONS, -1, 3)[::24, ::4]
    away = bed.query(some.reshape(-1, 3))[0].reshape(some.shape[:2])
    return float(np.percentile(away.min(axis=1), 99))


def fit_of(hair: Points, *, stands: bool = True) -> dict[str, float]:
    return measure_hair(hair, skin(), template().eyes.pupils, stands=stands)


@pytest.mark.parametrize("style", STYLES)
def test_every_style_is_attached_to_the_template(style: str) -> None:
    assert fit_of(grown(style), stands=style != "shaved")[OFF] < OFF_MM
    assert ribbons_off_mm(grown(style)) < 14.0


def test_a_wig_that_floats_is_off_the_skin_by_as_much() -> None:
    usual, floating = fit_of(grown("crop")), fit_of(grown("crop") + np.float32([0, 40, 0]))
    assert floating[OFF] > OFF_MM > usual[OFF]
    assert floating[EDGE] >= usual[EDGE]


def test_ribbons_that_fly_away_are_told_from_a_shell_that_does() -> None:
    flying = grown("crop").copy()
    flying[SHELL:] += np.float32([0, 60, 0])
    assert ribbons_off_mm(flying) > 14.0 > ribbons_off_mm(grown("crop"))
    assert fit_of(flying)[OFF] == fit_of(grown("crop"))[OFF]


def test_short_hair_leaves_eyes_and_face_free() -> None:
    fit = fit_of(grown("crop"))
    assert (fit[EYES], fit[FACE]) == (0.0, 0.0)


def test_hair_pulled_over_the_eyes_and_over_the_mouth_is_told_apart() -> None:
    curtain = np.zeros_like(grown("crop"))
    curtain[:] = (31.0, 0.0, 10.0)
    over_an_eye = fit_of(curtain)
    curtain[:] = (0.0, -60.0, 40.0)
    over_the_mouth = fit_of(curtain)
    assert (over_an_eye[EYES], over_an_eye[FACE]) == (1.0, 0.0)
    assert (over_the_mouth[EYES], over_the_mouth[FACE]) == (0.0, 1.0)


def test_hair_behind_the_face_is_not_before_it() -> None:
    behind = np.zeros_like(grown("crop"))
    behind[:] = (0.0, -60.0, -90.0)
    fit = fit_of(behind)
    assert (fit[EYES], fit[FACE]) == (0.0, 0.0)


def test_an_edge_lifted_off_the_forehead_is_a_helmets() -> None:
    lifted = grown("crop").copy()
    shell = lifted[:SHELL].reshape(COLUMNS, ROWS, 3)
    front = (np.abs(shell[:, -1, 0]) < 55.0) & (shell[:, -1, 2] > -60.0) & (shell[:, -1, 1] > 25.0)
    assert front.any()
    shell[front, -2:, 2] += 25.0
    lifted[:SHELL] = shell.reshape(-1, 3)
    assert fit_of(lifted)[EDGE] > 14.0 > fit_of(grown("crop"))[EDGE]


def test_a_shaved_head_has_no_edge() -> None:
    assert fit_of(grown("shaved"), stands=False)[EDGE] == 0.0


@pytest.mark.parametrize("style", STYLES)
def test_a_shell_grown_alone_is_that_of_the_whole_hair(style: str) -> None:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    shell = lay_shell(numbers, skin(), strand_stream(3)).vertices.astype(np.float32)
    np.testing.assert_array_equal(shell, grown(style)[:SHELL])


def test_a_shell_alone_fits_as_it_does_under_ribbons() -> None:
    whole, shell = fit_of(grown("bob")), fit_of(grown("bob")[:SHELL])
    assert (shell[OFF], shell[EDGE]) == (whole[OFF], whole[EDGE])
