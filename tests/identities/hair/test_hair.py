from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from lrsr.identities.hair.anchors import chart_angles, load_anchors
from lrsr.identities.hair.chart import sample_chart
from lrsr.identities.hair.choice import colour_parameters
from lrsr.identities.hair.hair import _hair_faces, _hair_uv, build_hair
from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import ROWS
from lrsr.identities.hair.strands import _RIBBONS
from lrsr.identities.hair.styles import STYLES, style_parameters
from lrsr.identities.hair.texture import TEXTURE_SHAPE
from lrsr.identities.head import Part
from lrsr.identities.morphable import template

SHELL = COLUMNS * ROWS
COLOUR = {"eumelanin": 2.0, "pheomelanin": 0.2, "grey": 0.1}
SHORT = ["buzz", "crop", "side_parting", "receding", "quiff", "slicked_back", "pulled_back"]
HANGING = ["bob", "long_straight", "long_wavy", "fringe"]


def make_hair(style: str, seed: int = 0, **changes: Any) -> dict[str, Any]:
    rng = np.random.default_rng([seed, 77])
    return style_parameters(style, rng) | colour_parameters(COLOUR) | changes


def skin() -> NDArray[np.float32]:
    return template().skin.astype(np.float32)


def shell_heights(part: Part) -> NDArray[np.float64]:
    """Distance of shell vertices off the template's ear-less skin, along the chart's rays, mm."""
    shell = part.vertices[:SHELL].astype(np.float64)
    azimuth, polar = chart_angles(shell)
    base = sample_chart(load_anchors().template, azimuth, polar)
    centre = np.array([0.0, 25.0, -82.0])
    return np.linalg.norm(shell - centre, axis=1) - np.linalg.norm(base - centre, axis=1)


@pytest.mark.parametrize("style", STYLES)
def test_every_style_is_the_same_mesh(style: str) -> None:
    part = build_hair(make_hair(style), skin(), seed=3)
    assert (part.name, part.material) == ("hair", "hair")
    assert part.vertices.shape == (len(_hair_uv()), 3)
    assert part.vertices.dtype == np.float32
    assert np.isfinite(part.vertices).all()
    assert part.faces is _hair_faces()
    assert part.uv is _hair_uv()
    assert part.albedo.shape == (*TEXTURE_SHAPE, 3)


def test_faces_use_every_vertex_and_cannot_be_changed() -> None:
    faces = _hair_faces()
    np.testing.assert_array_equal(np.unique(faces), np.arange(len(_hair_uv())))
    assert len(faces) == 2 * (COLUMNS - 1) * (ROWS - 1) + _RIBBONS * 10
    with pytest.raises(ValueError, match="read-only"):
        faces[0, 0] = 1


def test_uv_lies_in_the_unit_square() -> None:
    assert _hair_uv().min() >= 0.0
    assert _hair_uv().max() <= 1.0


def test_same_seed_grows_the_same_hair() -> None:
    hair = make_hair("crop")
    first, again, other = (build_hair(hair, skin(), seed).vertices for seed in (1, 1, 2))
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 1.0


def test_shaved_head_keeps_its_hair_below_the_skin() -> None:
    part = build_hair(make_hair("shaved"), skin(), 0)
    assert shell_heights(part).max() < -5.0


@pytest.mark.parametrize("style", SHORT[1:])
def test_short_hair_is_as_thick_as_asked(style: str) -> None:
    hair = make_hair(style)
    height = shell_heights(build_hair(hair, skin(), 0))
    most = hair["top_mm"] + hair["front_lift_mm"] + 4.0 * hair["clump_mm"] + hair["side_mm"]
    most += hair["bun_mm"]
    assert height.max() < most + 3.0
    assert np.percentile(height, 75) > 0.4 * hair["side_mm"]


def test_clipped_hair_is_stubble_without_a_shell() -> None:
    part = build_hair(make_hair("buzz", stubble_mm=3.0), skin(), 0)
    assert shell_heights(part).max() < -1.0
    tips = Part(**(vars(part) | {"vertices": part.vertices[SHELL:]}))
    height = shell_heights(tips)
    assert 0.5 < np.median(height) < 2.5


@pytest.mark.parametrize("style", SHORT)
def test_short_hair_ends_in_the_skin(style: str) -> None:
    shell = build_hair(make_hair(style, fringe_mm=0.0, fringe_tilt_mm=0.0), skin(), 0)
    edge = shell_heights(shell).reshape(COLUMNS, ROWS)[:, -1]
    assert np.percentile(edge, 90) < 0.0


@pytest.mark.parametrize("style", STYLES)
def test_no_hair_before_the_eyes(style: str) -> None:
    for seed in range(4):
        points = build_hair(make_hair(style, seed), skin(), seed).vertices
        before = (np.abs(points[:, 0]) < 44.0) & (points[:, 1] < 12.0) & (points[:, 1] > -90.0)
        assert not (before & (points[:, 2] > -12.0)).any()


@pytest.mark.parametrize("style", HANGING)
def test_hanging_hair_covers_the_ears(style: str) -> None:
    part = build_hair(make_hair(style), skin(), 0)
    ears = skin()[load_anchors().ears]
    shell = part.vertices[:SHELL]
    for side in (-1.0, 1.0):
        level = np.abs(shell[:, 1]) < 30.0
        beside = level & (side * shell[:, 0] > 0) & (np.abs(shell[:, 2] + 90.0) < 25.0)
        assert (side * shell[beside, 0]).min() > 0.9 * (side * ears[:, 0]).max()


def test_bob_ends_where_asked() -> None:
    part = build_hair(
        make_hair("bob", lower_mm=[-80.0] * 6, layer_mm=0.0, ragged_mm=0.0), skin(), 0
    )
    tips = part.vertices[:SHELL].reshape(COLUMNS, ROWS, 3)[:, -1, 1]
    np.testing.assert_allclose(tips, -76.0, atol=1.0)
    ends = part.vertices[SHELL:].reshape(_RIBBONS, -1, 3)[:, -1, 1]
    assert np.percentile(ends, 2) == pytest.approx(-82.0, abs=4.0)


def test_bigger_head_has_bigger_hair() -> None:
    hair = make_hair("buzz")
    small, large = (
        build_hair(hair, (scale * skin()).astype(np.float32), 0) for scale in (1.0, 1.2)
    )
    width = [np.ptp(part.vertices[:SHELL, 0]) for part in (small, large)]
    assert width[1] / width[0] == pytest.approx(1.2, abs=0.02)


def test_hair_goes_with_the_head() -> None:
    hair = make_hair("long_wavy")
    move = np.array([4.0, 0.0, -6.0], dtype=np.float32)
    here, there = build_hair(hair, skin(), 0), build_hair(hair, skin() + move, 0)
    np.testing.assert_allclose(there.vertices, here.vertices + move, atol=0.05)


def test_shell_faces_look_outwards() -> None:
    part = build_hair(make_hair("buzz", clump_mm=0.0, ragged_mm=0.0), skin(), 0)
    shell = part.faces[(part.faces < SHELL).all(axis=1)]
    a, b, c = (part.vertices[shell[:, k]].astype(np.float64) for k in range(3))
    normal = np.cross(b - a, c - a)
    outward = np.einsum("fc,fc->f", normal, (a + b + c) / 3 - [0.0, 25.0, -82.0])
    area = np.linalg.norm(normal, axis=1)
    assert (outward[area > 0.5] > 0).mean() > 0.99


def test_strands_are_thin() -> None:
    part = build_hair(make_hair("long_straight"), skin(), 0)
    strands = part.vertices[SHELL:].reshape(-1, 2, 3)
    assert np.linalg.norm(strands[:, 1] - strands[:, 0], axis=1).max() < 3.1


def test_styles_differ_in_outline() -> None:
    shapes = [build_hair(make_hair(style), skin(), 0).vertices[:SHELL] for style in STYLES]
    for i, one in enumerate(shapes):
        for other in shapes[:i]:
            assert np.linalg.norm(one - other, axis=1).mean() > 2.0
