import numpy as np

from lrsr.identities.hair.paths import COLUMNS
from lrsr.identities.hair.shell import BEYOND_MM, ROWS, Shell, shell_rows
from lrsr.identities.hair.strands import (
    _POINTS,
    _RIBBONS,
    _layout,
    lay_strands,
    strand_faces,
    strand_uv,
)

FLAT = {"curl_mm": 0.0, "flyaway_mm": 0.0, "sunk_mm": 0.0, "stubble_mm": 0.0, "hang": 0.0}


def make_wall(height_mm: float = 5.0) -> Shell:
    """A flat sheet of hair in the x-y plane: columns 2 mm apart, rows 3 mm, downwards."""
    rows = ROWS + len(BEYOND_MM)
    x, y = np.meshgrid(2.0 * np.arange(COLUMNS), -3.0 * np.arange(rows), indexing="ij")
    outward = np.broadcast_to([0.0, 0.0, 1.0], (COLUMNS, rows, 3))
    return Shell(
        np.stack([x, y, np.zeros_like(x)], axis=-1), outward, np.full((COLUMNS, rows), height_mm)
    )


def test_rows_go_from_root_to_tip() -> None:
    rows = shell_rows()
    assert rows[0] == 0.0
    assert rows[-1] == 1.0
    assert (np.diff(rows) > 0).all()


def test_ribbons_lie_where_the_layout_says() -> None:
    strands = lay_strands(FLAT, make_wall(), np.random.default_rng(0))
    middle = strands.mean(axis=2)
    np.testing.assert_allclose(middle[..., 0], 2.0 * _layout().column, atol=1e-2)
    np.testing.assert_allclose(middle[..., 1], -3.0 * _layout().row, atol=1e-2)
    np.testing.assert_allclose(middle[..., 2], 0.35, atol=1e-2)


def test_ribbons_are_as_wide_as_the_layout_says() -> None:
    strands = lay_strands(FLAT, make_wall(), np.random.default_rng(0))
    width = np.linalg.norm(strands[:, :, 1] - strands[:, :, 0], axis=-1)
    np.testing.assert_allclose(width, 2.0 * _layout().half_width_mm, rtol=1e-3)


def test_ribbons_look_outwards() -> None:
    strands = lay_strands(FLAT, make_wall(), np.random.default_rng(0)).reshape(-1, 3)
    a, b, c = (strands[strand_faces()[:, k]] for k in range(3))
    assert (np.cross(b - a, c - a)[:, 2] > 0).mean() > 0.99


def test_flyaway_strands_stand_off() -> None:
    rng = np.random.default_rng(0)
    strands = lay_strands(FLAT | {"flyaway_mm": 6.0}, make_wall(), rng)
    assert 3.0 < strands[..., 2].max() < 14.0


def test_curls_turn_out_of_the_plane_and_are_short() -> None:
    rng = np.random.default_rng(0)
    curly = lay_strands(FLAT | {"curl_mm": 4.0}, make_wall(10.0), rng).mean(axis=2)
    straight = lay_strands(FLAT, make_wall(10.0), rng).mean(axis=2)
    assert np.ptp(curly[..., 2], axis=1).mean() > 2.0
    reach = [np.ptp(points[..., 1], axis=1).mean() for points in (curly, straight)]
    assert reach[0] < 0.5 * reach[1]


def test_thin_hair_has_no_high_curls() -> None:
    rng = np.random.default_rng(0)
    thin = lay_strands(FLAT | {"curl_mm": 4.0}, make_wall(1.0), rng)
    assert thin[..., 2].max() < 3.0


def test_faces_and_uv_fit_the_ribbons() -> None:
    assert strand_faces().shape == (_RIBBONS * (_POINTS - 1) * 2, 3)
    assert strand_faces().max() == _RIBBONS * _POINTS * 2 - 1
    assert strand_uv().shape == (_RIBBONS * _POINTS * 2, 2)


def test_texture_runs_down_the_ribbon() -> None:
    v = strand_uv().reshape(_RIBBONS, _POINTS, 2, 2)[:, :, 0, 1]
    assert (np.diff(v, axis=1) >= 0).all()


def test_stubble_is_short_evenly_spread_and_stands_on_the_skin() -> None:
    rng = np.random.default_rng(0)
    stubble = lay_strands(FLAT | {"stubble_mm": 3.0}, make_wall(-2.0), rng).mean(axis=2)
    assert np.percentile(np.ptp(stubble[..., 1], axis=1), 95) < 6.0
    assert 3.5 < stubble[:, -1, 2].max() < 6.0
    assert stubble[:, 0, 2].min() > 2.0


def test_fine_hairs_fray_the_open_edge_of_parted_hair() -> None:
    rng = np.random.default_rng(0)
    middle = lay_strands(FLAT | {"flyaway_mm": 3.0}, make_wall(), rng).mean(axis=2)
    assert -6.0 < middle[..., 0].min() < -1.0
    assert 1.0 < middle[..., 0].max() - 2.0 * (COLUMNS - 1) < 6.0
