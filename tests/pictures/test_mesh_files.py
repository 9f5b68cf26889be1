"""Another program's reader (trimesh's) finds what was written."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh
from oracles.heads import ellipsoid_part, stand_in

from lrsr.errors import InputError
from lrsr.identities.head import Head
from lrsr.pictures.mesh_files import _make_scene, _srgb_texture, write_meshes


@pytest.fixture
def head() -> Head:
    plain = stand_in(seed=3)
    albedo = np.linspace(0, 1, 8 * 8 * 3).reshape(8, 8, 3)
    lens = ellipsoid_part("lenses", "glass", (9, 9, 1), (0, 0, 20), np.ones((4, 4, 3)), 6, 8)
    skin = replace(plain.parts[0], albedo=albedo.astype(np.float32))
    return replace(plain, parts=(skin, *plain.parts[1:], lens))


def test_gltf_read_back_has_the_same_parts_vertices_faces_and_uv(
    head: Head, tmp_path: Path
) -> None:
    write_meshes(tmp_path, head)
    scene = trimesh.load_scene(tmp_path / "head.glb", process=False)
    assert {*scene.geometry} == {part.name for part in head.parts}
    for part in head.parts:
        mesh = scene.geometry[part.name]
        np.testing.assert_allclose(mesh.vertices, part.vertices / 1000, atol=1e-7)
        np.testing.assert_array_equal(mesh.faces, part.faces)
        np.testing.assert_allclose(mesh.visual.uv[:, 1], 1 - part.uv[:, 1], atol=1e-6)


def test_a_texture_shows_each_vertex_its_own_albedo(head: Head, tmp_path: Path) -> None:
    write_meshes(tmp_path, head)
    scene = trimesh.load_scene(tmp_path / "head.glb", process=False)
    part, mesh = head.parts[0], scene.geometry["skin"]
    pixels = np.asarray(mesh.visual.material.baseColorTexture)
    np.testing.assert_array_equal(pixels, _srgb_texture(part.albedo))
    u, v = mesh.visual.uv[100]
    row, column = int((1 - v) * 8), int(u * 8)
    assert (column, row) == (int(part.uv[100, 0] * 8), int(part.uv[100, 1] * 8))


def test_obj_read_back_has_the_same_triangles(head: Head, tmp_path: Path) -> None:
    files = write_meshes(tmp_path, head)
    assert {"head.glb", "head.mtl", "head.obj", "skin.png", "left_eye_ball.png"} <= {*files}
    assert {path.name for path in tmp_path.iterdir()} == {*files}
    lines = (tmp_path / "head.obj").read_text().splitlines()
    points = np.array([line.split()[1:4] for line in lines if line.startswith("v ")], float)
    expected = np.concatenate([part.vertices for part in head.parts]) / 1000
    np.testing.assert_allclose(points, expected, atol=1e-6)
    assert "mtllib head.mtl" in lines
    assert [line.split()[1] for line in lines if line.startswith("o ")] == [
        part.name for part in head.parts
    ]
    assert "map_Kd skin.png" in (tmp_path / "head.mtl").read_text()


def test_glass_lets_light_through(head: Head) -> None:
    materials = {name: mesh.visual.material for name, mesh in _make_scene(head).geometry.items()}
    assert materials["lenses"].alphaMode == "BLEND"
    assert materials["skin"].alphaMode == "OPAQUE"


def test_what_is_folded_up_is_left_out(head: Head) -> None:
    hidden = replace(head.parts[-1], vertices=0 * head.parts[-1].vertices)
    scene = _make_scene(replace(head, parts=(*head.parts[:-1], hidden)))
    assert "lenses" not in scene.geometry


def test_srgb_is_the_curve_of_iec_61966() -> None:
    grey = np.full((1, 1, 3), 0.2140, np.float32)
    assert _srgb_texture(grey)[0, 0].tolist() == [127, 127, 127]  # half of 255 by the standard
    assert _srgb_texture(grey * 0).max() == 0


def test_a_folder_that_is_a_file_is_refused(head: Head, tmp_path: Path) -> None:
    (tmp_path / "x").touch()
    with pytest.raises(InputError, match="cannot write"):
        write_meshes(tmp_path / "x", head)
