from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lrsr.identities.photographs.build_space import _draw_people
from lrsr.identities.photographs.fit import _NOISE_SHARE, FaceFitter, Fit, _solve_bounded
from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.photographs.reconstructor import shared_reconstructor
from lrsr.identities.photographs.space import load_space
from lrsr.identities.shape.basis import load_basis
from lrsr.rendering.pose import Pose

POSE = Pose("own", yaw_deg=8.0, pitch_deg=-4.0, roll_deg=11.0)


@pytest.fixture(scope="module")
def fitter() -> FaceFitter:
    return shared_reconstructor().fitter


def points_of(fitter: FaceFitter, shapes: Any, **units: float) -> tuple[Any, Any]:
    """Places of the network's points for a face of the space, and its vertices there."""
    basis, space, noise = load_basis(), load_space(), shared_reconstructor().correspondence
    rest = space.mean + space.components @ shapes
    acting = rest.copy()
    for unit, strength in units.items():
        acting[basis.column[f"unit/{unit}"]] += strength
    rotation = POSE.rotation()
    seen = Perspective(rotation, 2.0, np.array([250.0, -250]), 1e-3, -rotation @ fitter.origin)
    rows = basis.surface.matrix[noise.vertices]
    px, _ = seen.project(rows @ basis.shape(acting).skin)
    angle = np.radians(POSE.roll_deg)
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return px + 2.0 * (noise.bias_mm @ turn.T) * [1, -1], rows @ basis.shape(acting).skin


def flat_error_mm(fit: Fit, truth: Any) -> float:
    rows = load_basis().surface.matrix[shared_reconstructor().correspondence.vertices]
    found = rows @ load_basis().shape(fit.acting).skin
    found, truth = found - found.mean(axis=0), truth - truth.mean(axis=0)
    found = Rotation.align_vectors(truth, found)[0].apply(found)
    return float(np.sqrt(((found - truth)[:, :2] ** 2).sum(axis=1).mean()))


def test_a_face_of_the_space_is_found_again(fitter: FaceFitter) -> None:
    shapes = np.random.default_rng(3).standard_normal(100)
    points, truth = points_of(fitter, shapes, jawOpen=0.5)
    mean_face = flat_error_mm(fitter(points_of(fitter, np.zeros(100))[0]), truth)
    fit = fitter(points)
    assert (
        flat_error_mm(fit, truth) < 0.6 * mean_face
    )  # the prior of noise and people holds it back
    np.testing.assert_allclose(fit.perspective.angles_deg, (8, -4, 11), atol=4.0)
    assert fit.units["jawOpen"] > 0.2


def test_of_points_a_millimetre_off_the_shape_is_found_but_for_its_size() -> None:
    basis, noise = load_basis(), shared_reconstructor().correspondence
    apart = replace(
        noise,
        bias_mm=np.zeros_like(noise.bias_mm),
        components_mm=np.zeros((1, *noise.bias_mm.shape)),
        rest_mm=1.0 / _NOISE_SHARE,
    )
    fitter, rows = FaceFitter(apart), basis.surface.matrix[noise.vertices]
    rng, off_mm = np.random.default_rng(0), []
    for person in _draw_people(6, first=900_000):  # none of those of the space
        truth = rows @ basis.shape(person).skin
        seen = Perspective(np.eye(3), 2.0, np.array([250.0, -250]), 1e-3, -fitter.origin)
        points_px = seen.project(truth)[0] + rng.normal(0, 2.0, (len(truth), 2))
        found = rows @ basis.shape(fitter(points_px).acting).skin
        truth, found = truth - truth.mean(axis=0), found - found.mean(axis=0)
        turn, _ = Rotation.align_vectors(truth, found)
        found = turn.apply(found)
        squares = (found * (found * truth).sum() / (found**2).sum() - truth) ** 2
        off_mm.append([np.sqrt(squares[:, :2].sum(axis=1).mean()), np.sqrt(squares.sum(1).mean())])
    in_plane, in_space = np.median(off_mm, axis=0)
    assert in_plane < 0.9  # asked by the research note, as the next line
    assert in_space < 1.9


def test_the_mean_face_is_the_mean_face(fitter: FaceFitter) -> None:
    fit = fitter(points_of(fitter, np.zeros(100))[0])
    assert fit.strangeness < 0.05
    assert max(fit.units.values()) < 0.1
    np.testing.assert_allclose(fit.perspective.px_per_mm, 2.0, rtol=0.01)


def test_units_stay_between_nothing_and_all(fitter: FaceFitter) -> None:
    far = np.random.default_rng(0).uniform(0, 500, (468, 2))
    units = fitter(far).units
    assert 0 <= min(units.values()) <= max(units.values()) <= 1


def test_bounds_are_met_as_the_conditions_of_optimality_want_it() -> None:
    rng = np.random.default_rng(1)
    mixed = rng.standard_normal((6, 6))
    hessian, gradient = mixed @ mixed.T + np.eye(6), 5 * rng.standard_normal(6)
    x = _solve_bounded(hessian, gradient, np.full(6, -0.5), np.full(6, 0.5))
    slope = hessian @ x - gradient
    for value, rise in zip(x, slope, strict=True):
        if abs(value) < 0.5:
            assert abs(rise) < 1e-9
        else:
            assert rise * value < 0


def test_the_shipped_calibration_is_of_all_points() -> None:
    count = len(shared_reconstructor().landmarker.contract.mirror)
    assert shared_reconstructor().correspondence.points.tolist() == list(range(count))


def test_mirrored_points_are_mirrored_vertices() -> None:
    mirror = list(shared_reconstructor().landmarker.contract.mirror)
    basis = load_basis()
    points = (basis.surface.matrix @ basis.shape(basis.neutral).skin)[
        shared_reconstructor().correspondence.vertices
    ]
    apart = np.linalg.norm(points[mirror] * [-1, 1, 1] - points, axis=1)
    assert np.median(apart) < 4.0


def test_components_are_standard_deviations_of_people() -> None:
    components = load_space().components
    basis = load_basis()
    moved = (basis.fields @ components).reshape(-1, 3, 100)[: basis.n_skin]
    size = np.sqrt((moved**2).sum(axis=1).mean(axis=0))
    assert size[:5].mean() > 3 * size[-5:].mean()
