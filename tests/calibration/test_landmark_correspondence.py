import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from unittest.mock import Mock

import cv2
import numpy as np
import pytest
from fakes.configurations import composed
from fakes.networks import write_colour_finder
from numpy.typing import NDArray

from lrsr.calibration import landmark_correspondence
from lrsr.calibration.landmark_correspondence import (
    Calibrating,
    _candidates,
    _describe_noise,
    _measure,
    _mirrored_vertices,
    _nearest_vertices,
    _spread_out,
)
from lrsr.calibration.landmark_views import View, plan_views
from lrsr.errors import InputError
from lrsr.identities.face.expression import NEUTRAL
from lrsr.identities.face.template import template
from lrsr.identities.person import Person
from lrsr.identities.photographs.correspondence import Correspondence
from lrsr.identities.photographs.landmarker import Landmarker, Landmarks
from lrsr.identities.photographs.reconstructor import Reconstructor
from lrsr.pictures.cache import RenderCache
from lrsr.presets import preset
from lrsr.rendering.pose import Pose
from lrsr.rendering.scene import Scene
from lrsr.rendering.standpoint import Standpoint

RNG = np.random.default_rng(0)
SIZE = 128
POSES = [(0, 0, 0), (12, -6, 4), (-15, 5, -3), (25, 8, 2), (-30, -10, 0), (4, 14, -8)]


def test_a_point_is_the_vertex_that_it_follows_whatever_outliers_say() -> None:
    projected = RNG.uniform(0, 100, (40, 30, 2))
    true = RNG.permutation(30)[:12]
    found = projected[:, true] + RNG.normal(0, 1, (40, 12, 2))
    found[:3] += 80
    np.testing.assert_array_equal(_nearest_vertices(found, projected, np.ones(40)), true)


def test_many_points_are_held_against_the_vertices_part_by_part(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found, projected = RNG.uniform(0, 9, (5, 23, 2)), RNG.uniform(0, 9, (5, 7, 2))
    whole = _nearest_vertices(found, projected, np.ones(5))
    monkeypatch.setattr(landmark_correspondence, "_PART", 10)
    np.testing.assert_array_equal(_nearest_vertices(found, projected, np.ones(5)), whole)


def test_noise_is_told_as_bias_common_parts_and_a_rest() -> None:
    together = np.zeros((5, 2))
    together[:, 0] = 2.0
    common = RNG.standard_normal((4000, 1, 1)) * together
    errors = 0.5 + common + RNG.normal(0, 0.3, (4000, 5, 2))
    bias, components, rest = _describe_noise(errors, 1)
    np.testing.assert_allclose(bias, 0.5, atol=0.12)
    np.testing.assert_allclose(np.abs(components[0]), together, atol=0.1)
    np.testing.assert_allclose(rest, 0.3, rtol=0.08)  # one of ten directions is gone


def test_an_asset_holds_hundredths_of_a_millimetre() -> None:
    few = np.array([3]), np.array([7])
    noise = Correspondence(*few, np.array([[0.126, -1]]), np.ones((1, 1, 2)), 0.5, "ab")
    arrays = noise.arrays("a test")
    assert arrays["bias"].tolist() == [[13, -100]]
    assert '"network": "ab"' in str(arrays["provenance"])


def test_places_are_chosen_far_from_each_other_and_never_twice() -> None:
    line = np.zeros((101, 3))
    line[:, 0] = np.arange(101)
    assert _spread_out(line, 3).tolist() == [0, 50, 100]
    assert _spread_out(np.repeat(line[:4], 5, axis=0), 10).tolist() == [0, 5, 10, 15]


def test_views_are_planned_alike_twice_and_begin_frontal() -> None:
    people = [Person("train", 1), Person("train", 2)]
    plan = plan_views(people, 3)
    assert plan == plan_views(people, 3)
    assert [recipe.person.index for recipe in plan] == [1, 1, 1, 2, 2, 2]
    for first in plan[::3]:
        assert abs(first.scene.pose.yaw_deg) <= 3
        assert not first.scene.expression.units
    assert all(recipe.scene.expression.units for recipe in plan[2::3])


@pytest.fixture(scope="module")
def vertices() -> NDArray[np.int64]:
    """24 vertices all over the face, none so far out that some crop lacks it."""
    chosen = _candidates()
    _, y, z = template().skin[chosen].T
    chosen = chosen[(z > -10) & (y > -80) & (y < 55)]
    return np.asarray(chosen[_spread_out(template().skin[chosen], 24)])


@pytest.fixture(scope="module")
def colours() -> NDArray[np.float64]:
    """24 of one length, far from each other: none is the blurred edge of another one's disc."""
    bright = np.abs(np.random.default_rng(0).standard_normal((4000, 3)))
    bright /= np.linalg.norm(bright, axis=1, keepdims=True)
    return np.asarray(bright[_spread_out(bright, 24)])


@pytest.fixture(scope="module")
def painted(vertices: NDArray[np.int64], colours: NDArray[np.float64]) -> list[View]:
    """Two people in six poses, of whom nothing is seen but a disc of its own colour a vertex."""
    views = []
    for index in (0, 1):
        head = Person("train", index).head(NEUTRAL, 64)
        for yaw, pitch, roll in POSES:
            pose = Pose("own", float(yaw), float(pitch), float(roll))
            scene = Scene(preset("lighting", "frontal"), pose, standpoint=Standpoint("own", 1.5))
            view = View(np.zeros((3, 200, 200), np.float32), np.zeros((5, 2)), head, scene)
            drawn = np.zeros((200, 200, 3), np.float32)
            places = view.project(head.parts[0].vertices[vertices].astype(np.float64))
            for place, colour in zip(places, colours.tolist(), strict=True):
                x, y = (round(16 * float(one)) for one in place)
                cv2.circle(drawn, (x, y), 40, colour, -1, cv2.LINE_AA, shift=4)
            image = np.ascontiguousarray(drawn.transpose(2, 0, 1))
            views.append(replace(view, image=image, landmarks_px=view.project(head.landmarks)))
    return views


@pytest.mark.parametrize("as_map", [False, True], ids=["landmarks", "position map"])
def test_calibration_finds_the_vertices_that_were_painted(
    tmp_path: Path,
    painted: list[View],
    vertices: NDArray[np.int64],
    colours: NDArray[np.float64],
    as_map: bool,
) -> None:
    model = write_colour_finder(tmp_path / "n.onnx", colours, size_px=SIZE, as_map=as_map)
    found, figures = _measure(painted, Landmarker(model), 8.0, 2000)
    assert found.points.tolist() == list(range(24))  # of 28: the corners follow no vertex
    points = template().skin  # some vertices all but touch
    assert np.linalg.norm(points[found.vertices] - points[vertices], axis=1).max() < 1
    assert np.abs(found.bias_mm).max() < 1
    assert (figures["points"], figures["points_kept"], figures["pictures"]) == (28, 24, 12)
    assert figures["error_mm"] < 1


def test_both_sides_are_calibrated_alike_where_a_mirror_is_known(
    painted: list[View], vertices: NDArray[np.int64]
) -> None:
    chosen = _candidates()
    twin = dict(zip(chosen, chosen[_mirrored_vertices(template().skin[chosen])], strict=True))
    left = np.array([one for one in vertices if twin[one] != one])
    both = np.concatenate([left, [twin[one] for one in left]])
    sides = np.arange(len(both)).reshape(2, -1)
    contract = SimpleNamespace(mirrored=lambda: sides[::-1].ravel(), sha256="0" * 64)
    views = iter(painted)

    def find(*_: object) -> Landmarks:
        view = next(views)
        points = view.project(view.head.parts[0].vertices[both].astype(np.float64))
        points[sides[0], 1] += 2.0 * view.px_per_mm  # of one side alone, which is chance
        return Landmarks(points, None)

    network: Any = Mock(side_effect=find, contract=contract)
    found, _ = _measure(painted, network, 8.0, 2000)
    assert found.points.tolist() == sides.ravel().tolist()
    places = template().skin[found.vertices]
    np.testing.assert_allclose(places[sides[0]] * [-1, 1, 1], places[sides[1]], atol=1e-6)
    one, other = found.bias_mm[sides]
    np.testing.assert_allclose(one * [-1, 1], other, atol=1e-9)


def test_fewer_points_are_kept_where_fewer_are_wanted(
    tmp_path: Path, painted: list[View], colours: NDArray[np.float64]
) -> None:
    model = write_colour_finder(tmp_path / "n.onnx", colours, size_px=SIZE)
    found, _ = _measure(painted, Landmarker(model), 8.0, 21)
    assert len(found.points) == len(np.unique(found.vertices)) == 21


@pytest.fixture
def on_painted(monkeypatch: pytest.MonkeyPatch, painted: list[View]) -> None:
    def take(recipes: Sequence[Any], cache: RenderCache) -> list[View]:
        assert len(recipes) == 8
        return painted

    monkeypatch.setattr(landmark_correspondence, "take_views", take)


@pytest.mark.usefixtures("on_painted")
def test_what_was_calibrated_fits_faces(
    tmp_path: Path, painted: list[View], colours: NDArray[np.float64]
) -> None:
    model = write_colour_finder(tmp_path / "n.onnx", colours, size_px=SIZE, as_map=True)
    config = composed("calibrate-reconstructor", f"model={model}", "count=2")
    Calibrating.from_config(config).run(tmp_path, RenderCache(tmp_path / "cache"))
    told = json.loads((tmp_path / "calibration.json").read_text())
    assert told["file"] == str(tmp_path / "n.npz")
    find = Reconstructor(model)
    for view in painted[1:4]:
        image = np.ascontiguousarray(view.image.transpose(1, 2, 0))
        found = find(image, view.landmarks_px)
        pose = (view.scene.pose.yaw_deg, view.scene.pose.pitch_deg, view.scene.pose.roll_deg)
        np.testing.assert_allclose(found.fit.perspective.angles_deg, pose, atol=5)
        eyes = [found.points_px[list(pair)].mean(axis=0) for pair in ((33, 133), (362, 263))]
        np.testing.assert_allclose(eyes, view.landmarks_px[:2], atol=5)
        assert found.score is None


@pytest.mark.usefixtures("on_painted")
def test_a_network_that_follows_no_face_is_refused(
    tmp_path: Path, colours: NDArray[np.float64]
) -> None:
    model = write_colour_finder(tmp_path / "n.onnx", colours[::-1] * 0.5, size_px=SIZE)
    asked = Calibrating(model, 2, 0, 0.1, 2000)
    with pytest.raises(InputError, match="of 28 points are within"):
        asked.run(tmp_path, RenderCache(tmp_path / "cache"))
    assert not (tmp_path / "n.npz").exists()


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ("count=1", "count=1: wanted at least 2"),
        ("start=-1", "start=-1: wanted at least 0"),
        ("most_points=19", "most_points=19: wanted at least 20"),
        ("most_error_mm=0", "most_error_mm=0.0: wanted above 0"),
    ],
)
def test_a_wrong_setting_is_named(setting: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Calibrating.from_config(composed("calibrate-reconstructor", "model=n.onnx", setting))
