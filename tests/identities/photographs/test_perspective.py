import numpy as np

from lrsr.identities.photographs.correspondence import tip_of
from lrsr.identities.photographs.perspective import Perspective
from lrsr.rendering.geometry import place_camera
from lrsr.rendering.pose import Pose

POSE = Pose("own", yaw_deg=20.0, pitch_deg=-10.0, roll_deg=7.0)
POINTS = np.array([[0.0, 0.0, 0.0], [31.0, 2.0, -1.0], [-5.0, -60.0, 12.0]])


def seen() -> Perspective:
    return Perspective(POSE.rotation(), 1.5, np.array([100.0, -80.0]), 1e-3, np.array([1.0, 2, 3]))


def test_angles_are_those_of_the_pose() -> None:
    np.testing.assert_allclose(seen().angles_deg, (20.0, -10.0, 7.0))


def test_it_projects_as_the_renderer_s_pinhole_does() -> None:
    pupils = np.array([[-31.0, 0.0, 0.0], [31.0, 0.0, 0.0]])
    camera = place_camera(pupils, 50, camera_m=0.8)
    _, _, away = camera.centre_mm
    scale = camera.pixels_per_slope / away
    middle = camera.film_px / 2 - 0.5
    x, y = camera.centre_mm[:2]
    offset = np.array([-x, -y, 0.0])
    ours = Perspective(np.eye(3), scale, np.array([middle, -middle]), 1 / away, offset)
    np.testing.assert_allclose(ours.project(POINTS)[0], camera.project(POINTS), atol=1e-9)


def test_the_ray_of_a_pixel_meets_the_point_that_it_shows() -> None:
    px, _ = seen().project(POINTS)
    for point, place in zip(POINTS, px, strict=True):
        start, direction = seen().ray(place)
        np.testing.assert_allclose(np.cross(point - start, direction), 0, atol=1e-9)


def test_points_face_the_camera_along_its_rays() -> None:
    _, direction = seen().ray(seen().project(POINTS)[0][1])
    np.testing.assert_allclose(seen().towards(POINTS)[1], -direction, atol=1e-12)


def test_moved_axes_and_scaled_pictures_show_the_same() -> None:
    rotation, origin = Pose("other", 5.0, 6.0, 7.0).rotation(), np.array([4.0, 5.0, 6.0])
    moved = seen().moved_axes(rotation, origin)
    there = (POINTS - origin) @ rotation.T
    np.testing.assert_allclose(moved.project(there)[0], seen().project(POINTS)[0])
    half = (seen().project(POINTS)[0] + 0.5) / 2 - 0.5
    np.testing.assert_allclose(seen().scaled(0.5).project(POINTS)[0], half)


def test_a_tipped_head_has_its_crown_to_the_right() -> None:
    crown = tip_of(Pose("tipped", roll_deg=30.0).rotation()) @ [0.0, 1.0]
    np.testing.assert_allclose(crown, [0.5, np.sqrt(0.75)])
