"""The live scene: what is changed in place is what a fresh scene would hold."""

from dataclasses import replace

import numpy as np
import pytest
from oracles.heads import ball, dots, ellipsoid_part, stand_in

from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.rendering.renderer import Renderer
from lrsr.rendering.scene import Lighting, Pose
from lrsr.rendering.stage import Stage, topology, vertex_normals, world_to_head

CLOUDY = Lighting("cloudy", (), fill_share=1.0)
SETTINGS = {"ipd_px": 4.0, "samples_per_pixel": 16}


def two_colours() -> Head:
    """Make an egg whose texture is red in the upper rows and green in the lower ones."""
    albedo = np.zeros((64, 64, 3))
    albedo[:32, :, 0] = 0.8
    albedo[32:, :, 1] = 0.8
    skin = ellipsoid_part("skin", "skin", (60, 100, 90), (0, -12, -80), albedo)
    plain = stand_in(0, ipd_mm=63.0)
    return replace(plain, parts=(skin, *plain.parts[1:]))


def test_the_top_row_of_a_texture_is_at_v_0(renderer: Renderer) -> None:
    image = renderer.render(two_colours(), lighting=CLOUDY, ipd_px=8, samples_per_pixel=64).image
    upper, lower = image[:, 9, 16], image[:, 23, 16]
    assert upper[0] > 4 * upper[1]
    assert lower[1] > 4 * lower[0]


def test_a_new_texture_replaces_the_old_in_place(renderer: Renderer) -> None:
    dark, fair = stand_in(0, ipd_mm=63, grey=0.05), stand_in(0, ipd_mm=63, grey=0.6)
    darker = renderer.render(dark, **SETTINGS).image[:, 8, 8]
    fairer = renderer.render(fair, **SETTINGS).image[:, 8, 8]
    assert (fairer > 3 * darker).all()


def test_an_updated_scene_gives_the_bytes_of_a_fresh_one(renderer: Renderer) -> None:
    renderer.render(stand_in(1), pose="up", lighting="side", **SETTINGS)
    updated = renderer.render(stand_in(2), pose="left", lighting="above", **SETTINGS)
    fresh = Renderer().render(stand_in(2), pose="left", lighting="above", **SETTINGS)
    assert updated.image.equal(fresh.image)


def test_another_topology_reloads_the_scene(renderer: Renderer) -> None:
    first = renderer.render(stand_in(0), **SETTINGS)
    renderer.render(dots(stand_in(0).landmarks), **SETTINGS)
    again = renderer.render(stand_in(0), **SETTINGS)
    assert again.image.equal(first.image)


def test_topology_ignores_shape_and_colour() -> None:
    assert topology(stand_in(0)) == topology(stand_in(1))


def test_topology_sees_names_faces_and_texture_sizes() -> None:
    head = stand_in(0)
    skin = head.parts[0]
    for changed in (
        replace(skin, name="hide"),
        replace(skin, faces=skin.faces[:, [1, 2, 0]]),
        replace(skin, albedo=np.zeros((4, 4, 3), np.float32)),
    ):
        assert topology(replace(head, parts=(changed, *head.parts[1:]))) != topology(head)


def test_a_spheres_normals_are_its_vertices() -> None:
    vertices, faces, _ = ball(64, 128)
    normals = vertex_normals(vertices.astype(np.float32), faces)
    interior = slice(129, -129)  # the seam and the poles are doubled vertices
    assert (normals * vertices).sum(axis=1)[interior].min() > 0.999


def test_a_vertex_without_faces_has_a_normal() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], np.float32)
    normals = vertex_normals(vertices, np.array([[0, 1, 2]], np.int32))
    np.testing.assert_allclose(normals, np.tile([0, 0, 1], (4, 1)))


def test_the_camera_goes_back_where_the_head_came_from() -> None:
    pose = Pose("any", 33, -21, 8)
    points = np.random.default_rng(0).uniform(-100, 100, (10, 3))
    homogeneous = np.concatenate([pose.turn(points), np.ones((10, 1))], axis=1)
    np.testing.assert_allclose((homogeneous @ world_to_head(pose).T)[:, :3], points, atol=1e-9)


def test_a_stage_refuses_an_unknown_skin() -> None:
    with pytest.raises(InputError, match="skin 'wax'"):
        Stage("wax")
