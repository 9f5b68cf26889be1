from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from lrsr.identities.hair.anchors import (
    AZIMUTHS,
    POLARS,
    SKULL_CENTRE_MM,
    _chart_directions,
    anchor_arrays,
    build_anchors,
    chart_angles,
    load_anchors,
)
from lrsr.identities.hair.build_anchors import _find_ears, _make_anchors, main
from lrsr.identities.morphable import load_basis, template

CENTRE = np.asarray(SKULL_CENTRE_MM)


def make_sphere(
    radius_mm: float = 90.0, count: int = 8000
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    height = 1.0 - 2.0 * (np.arange(count) + 0.5) / count
    turn = np.arange(count) * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1.0 - height**2)
    direction = np.stack([flat * np.sin(turn), height, flat * np.cos(turn)], axis=1)
    return CENTRE + radius_mm * direction, ConvexHull(direction).simplices.astype(np.int32)


def test_chart_of_a_sphere_lies_on_the_sphere() -> None:
    vertices, faces = make_sphere()
    anchors = build_anchors(vertices, faces, np.array([], dtype=np.int32))
    expected = CENTRE + 90.0 * _chart_directions()
    np.testing.assert_allclose(anchors.template, expected, atol=0.3)


def test_chart_crosses_the_hole_that_an_ear_leaves() -> None:
    vertices, faces = make_sphere()
    azimuth, polar = chart_angles(vertices)
    ear = np.flatnonzero((np.abs(azimuth - 90) < 15) & (np.abs(polar - 90) < 15)).astype(np.int32)
    vertices[ear] = CENTRE + 1.4 * (vertices[ear] - CENTRE)
    anchors = build_anchors(vertices, faces, ear)
    radius = np.linalg.norm(anchors.template - CENTRE, axis=-1)
    assert radius.max() < 90.5
    assert radius.min() > 80.0


def test_rays_take_the_outermost_of_nested_surfaces() -> None:
    inner, faces = make_sphere(60.0)
    outer, _ = make_sphere(90.0)
    both = np.concatenate([faces, faces + len(inner)])
    anchors = build_anchors(np.concatenate([inner, outer]), both, np.array([], dtype=np.int32))
    assert np.linalg.norm(anchors.template - CENTRE, axis=-1).min() > 89.0


def test_rows_of_the_shipped_chart_sum_to_one() -> None:
    sums = np.asarray(load_anchors().matrix.sum(axis=1)).ravel()
    np.testing.assert_allclose(sums, 1.0, atol=1e-5)


def test_shipped_chart_is_the_one_of_the_shipped_template() -> None:
    shipped, made = load_anchors(), _make_anchors()
    assert shipped.matrix.shape == made.matrix.shape
    np.testing.assert_array_equal(shipped.ears, made.ears)
    np.testing.assert_allclose(shipped.template, made.template, atol=1e-2)
    skin = template().skin
    np.testing.assert_allclose(shipped.locate(skin), made.locate(skin), atol=1e-2)


def test_chart_moves_with_the_head() -> None:
    skin = template().skin.astype(np.float32)
    move = np.array([3.0, -2.0, 5.0], dtype=np.float32)
    anchors = load_anchors()
    np.testing.assert_allclose(
        anchors.locate(1.1 * skin + move), 1.1 * anchors.locate(skin) + move, atol=1e-3
    )


def test_ears_are_two_alike_and_at_the_sides() -> None:
    ears = template().skin[_find_ears(load_basis())]
    left, right = ears[ears[:, 0] > 0], ears[ears[:, 0] < 0]
    assert len(left) == len(right)
    assert np.abs(ears[:, 0]).min() > 50.0
    assert left[:, 1].max() - left[:, 1].min() == pytest.approx(100.0, abs=40.0)


def test_angles_are_the_inverse_of_directions() -> None:
    azimuth, polar = chart_angles(CENTRE + 80.0 * _chart_directions()[:, 1:])
    expected = (np.arange(AZIMUTHS) * 3.0 + 180.0) % 360.0 - 180.0
    wrapped = (azimuth - expected[:, None] + 180.0) % 360.0 - 180.0
    np.testing.assert_allclose(wrapped, 0.0, atol=1e-9)
    np.testing.assert_allclose(polar, np.broadcast_to(np.arange(1, POLARS) * 3.0, polar.shape))


def test_asset_is_written_as_it_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("lrsr.identities.hair.build_anchors.PACKAGE", tmp_path)
    assert main() == 0
    with np.load(tmp_path / "assets" / "hair_anchors.npz", allow_pickle=False) as written:
        arrays = anchor_arrays(load_anchors())
        assert set(written.files) == set(arrays)
        np.testing.assert_array_equal(written["indices"], arrays["indices"])
