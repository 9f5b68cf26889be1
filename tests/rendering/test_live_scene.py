"""The live scene: what is changed in place is what a fresh scene would hold."""

from dataclasses import replace

import numpy as np
import pytest
from fakes.scenes import Studio
from oracles.heads import ball, dots, ellipsoid_part, stand_in

from lrsr.identities.head import Head, Part
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light
from lrsr.rendering.live_scene import _faces_around, _fits, _vertex_normals

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


def with_maps(head: Head, strength: float) -> Head:
    """Give the skin ridges of up to 1 mm and a gloss that changes with height."""
    waves = np.sin(np.arange(32, dtype=np.float32))[:, None].repeat(32, axis=1)
    roughness = np.full((8, 8), 0.6 - 0.3 * strength, np.float32)
    skin = replace(head.parts[0], height=np.float32(strength) * waves, roughness=roughness)
    return replace(head, parts=(skin, *head.parts[1:]))


def wall(height: np.ndarray, slopes: tuple[float, float], mirrored: bool) -> Head:
    """Make a grey wall of 200 mm, z = slope x + slope y, that fills the picture."""
    x, y = np.array([-100.0, 100, 100, -100]), np.array([100.0, 100, -100, -100])
    vertices = np.stack([x, y, slopes[0] * x + slopes[1] * y], axis=1).astype(np.float32)
    u, v = (x + 100) / 200, (100 - y) / 200
    uv = np.stack([1 - u if mirrored else u, v], axis=1).astype(np.float32)
    faces = np.array([[0, 3, 2], [0, 2, 1]], np.int32)
    grey = np.full((4, 4, 3), 0.5, np.float32)
    skin = Part("wall", "lash", vertices, faces, uv, grey, np.asarray(height, np.float32))
    return replace(stand_in(0, ipd_mm=63.0), parts=(skin,))


def test_the_top_row_of_a_texture_is_at_v_0(renderer: Studio) -> None:
    image = renderer.render(two_colours(), lighting=CLOUDY, ipd_px=8, samples_per_pixel=64).image
    upper, lower = image[:, 9, 16], image[:, 23, 16]
    assert upper[0] > 4 * upper[1]
    assert lower[1] > 4 * lower[0]


def test_a_new_texture_replaces_the_old_in_place(renderer: Studio) -> None:
    dark, fair = stand_in(0, ipd_mm=63, grey=0.05), stand_in(0, ipd_mm=63, grey=0.6)
    darker = renderer.render(dark, **SETTINGS).image[:, 8, 8]
    fairer = renderer.render(fair, **SETTINGS).image[:, 8, 8]
    assert (fairer > 3 * darker).all()


def test_an_updated_scene_gives_the_bytes_of_a_fresh_one(renderer: Studio) -> None:
    renderer.render(stand_in(1), pose="up", lighting="side", **SETTINGS)
    updated = renderer.render(stand_in(2), pose="left", lighting="above", **SETTINGS)
    fresh = Studio().render(stand_in(2), pose="left", lighting="above", **SETTINGS)
    assert updated.image.equal(fresh.image)


def test_another_topology_reloads_the_scene(renderer: Studio) -> None:
    first = renderer.render(stand_in(0), **SETTINGS)
    renderer.render(dots(stand_in(0).landmarks), **SETTINGS)
    again = renderer.render(stand_in(0), **SETTINGS)
    assert again.image.equal(first.image)


def test_a_head_of_another_shape_and_colour_fits() -> None:
    assert _fits(stand_in(0), stand_in(1))


def test_other_names_faces_and_texture_sizes_do_not_fit() -> None:
    head = stand_in(0)
    skin = head.parts[0]
    for changed in (
        replace(skin, name="hide"),
        replace(skin, faces=skin.faces[:, [1, 2, 0]]),
        replace(skin, albedo=np.zeros((4, 4, 3), np.float32)),
    ):
        assert not _fits(replace(head, parts=(changed, *head.parts[1:])), head)
    assert not _fits(replace(head, parts=head.parts[1:]), head)


def test_other_maps_fit_but_none_do_not() -> None:
    head = stand_in(0)
    assert not _fits(with_maps(head, 0.0), head)
    assert _fits(with_maps(head, 0.0), with_maps(head, 1.0))


@pytest.mark.parametrize("mirrored", [False, True], ids=["plain uv", "mirrored uv"])
@pytest.mark.parametrize("axis", [0, 1], ids=["along u", "along v"])
def test_a_slope_of_heights_in_mm_is_lit_as_a_slope_of_the_mesh(axis: int, mirrored: bool) -> None:
    """A lit wall whose map rises by 0.3 mm per mm looks like a wall that leans so."""
    light = Lighting("oblique", (Light(azimuth_deg=-40.0, elevation_deg=40.0),), fill_share=0.1)
    rise = 0.3 * np.indices((64, 64))[1 - axis] * (200 / 64)
    level = np.zeros((64, 64))
    painted = wall(rise[:, ::-1] if mirrored else rise, (0.0, 0.0), mirrored)
    leaning = wall(level, (0.3, 0.0) if axis == 0 else (0.0, -0.3), mirrored)
    stage_of_its_own = Studio()
    seen, wanted, flat = (
        float(stage_of_its_own.render(head, lighting=light, **SETTINGS).image.mean())
        for head in (painted, leaning, wall(level, (0.0, 0.0), mirrored))
    )
    assert abs(wanted - flat) > 0.05 * flat
    assert seen == pytest.approx(wanted, rel=0.03)


def test_new_maps_replace_the_old_in_place(renderer: Studio) -> None:
    renderer.render(with_maps(stand_in(1), 0.0), **SETTINGS)
    updated = renderer.render(with_maps(stand_in(2), 1.0), **SETTINGS)
    fresh = Studio().render(with_maps(stand_in(2), 1.0), **SETTINGS)
    assert updated.image.equal(fresh.image)
    assert not updated.image.equal(renderer.render(with_maps(stand_in(2), 0.0), **SETTINGS).image)


def normals_of(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    return _vertex_normals(vertices, faces, _faces_around(faces, len(vertices)))


def test_a_spheres_normals_are_its_vertices() -> None:
    vertices, faces, _ = ball(64, 128)
    normals = normals_of(vertices.astype(np.float32), faces)
    interior = slice(129, -129)  # the seam and the poles are doubled vertices
    assert (normals * vertices).sum(axis=1)[interior].min() > 0.999


def test_a_vertex_without_faces_has_a_normal() -> None:
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [5, 5, 5]], np.float32)
    normals = normals_of(vertices, np.array([[0, 1, 2]], np.int32))
    np.testing.assert_allclose(normals, np.tile([0, 0, 1], (4, 1)))


def test_normals_are_sums_in_the_order_of_the_faces() -> None:
    rng = np.random.default_rng(5)
    vertices = rng.normal(size=(50, 3)).astype(np.float32)
    faces = rng.integers(0, 50, (200, 3)).astype(np.int32)  # some use a vertex twice
    sums = np.zeros((50, 3))
    for face in faces:
        first, second, third = vertices[face].astype(np.float64)
        for vertex in face:
            sums[vertex] += np.cross(second - first, third - first)
    wanted = (sums / np.linalg.norm(sums, axis=1, keepdims=True)).astype(np.float32)
    np.testing.assert_array_equal(normals_of(vertices, faces), wanted)
