from functools import lru_cache

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from lrsr.identities.face.template import template
from lrsr.identities.gate.hair_fit import EVERY_COLUMN, edge_height_mm
from lrsr.identities.hair.choice import colour_parameters
from lrsr.identities.hair.hair import build_hair
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS, lay_shell, strand_stream
from lrsr.identities.hair.strands import _RIBBONS
from lrsr.identities.hair.styles import STYLES, style_parameters

Points = NDArray[np.float32]

COLOUR = {"eumelanin": 2.0, "pheomelanin": 0.2, "grey": 0.1}
SHELL = COLUMNS * ROWS
EDGE_MM = 14.0


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


def height_mm(hair: Points) -> float:
    return edge_height_mm(hair[:SHELL].reshape(COLUMNS, ROWS, 3)[::EVERY_COLUMN], skin())


@pytest.mark.parametrize("style", STYLES)
def test_every_style_is_attached_to_the_template(style: str) -> None:
    assert ribbons_off_mm(grown(style)) < 14.0


def test_ribbons_that_fly_away_are_told_from_a_shell_that_does() -> None:
    flying = grown("crop").copy()
    flying[SHELL:] += np.float32([0, 60, 0])
    assert ribbons_off_mm(flying) > 14.0 > ribbons_off_mm(grown("crop"))
    assert height_mm(flying) == height_mm(grown("crop"))


def test_an_edge_lifted_off_the_forehead_is_a_helmets() -> None:
    lifted = grown("crop").copy()
    shell = lifted[:SHELL].reshape(COLUMNS, ROWS, 3)
    front = (np.abs(shell[:, -1, 0]) < 55.0) & (shell[:, -1, 2] > -60.0) & (shell[:, -1, 1] > 25.0)
    assert front.any()
    shell[front, -2:, 2] += 25.0
    lifted[:SHELL] = shell.reshape(-1, 3)
    assert height_mm(lifted) > EDGE_MM > height_mm(grown("crop"))


def test_hair_that_leaves_the_forehead_free_has_no_edge_there() -> None:
    assert height_mm(grown("crop") - np.float32([0, 0, 200])) == 0.0


@pytest.mark.parametrize("style", STYLES)
def test_a_shell_grown_alone_is_that_of_the_whole_hair(style: str) -> None:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    shell = lay_shell(numbers, skin(), strand_stream(3)).vertices.astype(np.float32)
    np.testing.assert_array_equal(shell, grown(style)[:SHELL])


@pytest.mark.parametrize("style", ["bob", "curly"])
def test_some_columns_alone_lie_where_they_do_among_all(style: str) -> None:
    numbers = style_parameters(style, np.random.default_rng(5)) | colour_parameters(COLOUR)
    some = lay_shell(numbers, skin(), strand_stream(3), every=EVERY_COLUMN).points
    whole = lay_shell(numbers, skin(), strand_stream(3)).points
    np.testing.assert_array_equal(some, whole[::EVERY_COLUMN])
