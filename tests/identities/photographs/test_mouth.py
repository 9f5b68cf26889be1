import numpy as np
import pytest

from lrsr.identities.face.mouth import mouth_rings
from lrsr.identities.face.resting import RestingFace, acting_skin, rest_face
from lrsr.identities.photographs.mouth import (
    _columns,
    lips_are_parted,
    painted_faces,
    skin_with_sheet,
)
from lrsr.identities.photographs.outlines import LIP_GAP
from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.photographs.shot import Mesh, take_shot
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import cover
from lrsr.identities.shape.topology import REGIONS


@pytest.fixture(scope="module")
def face() -> RestingFace:
    return rest_face(load_basis().neutral)


@pytest.fixture(scope="module")
def shouting() -> np.ndarray:
    weights = load_basis().neutral.copy()
    weights[load_basis().column["unit/jawOpen"]] += 0.8
    return weights


def mouth_faces() -> np.ndarray:
    faces = painted_faces()
    inside = load_basis().surface.region[: len(faces)] == REGIONS.index("mouth")
    return np.asarray(faces[inside])


def test_columns_lead_from_the_rim_of_each_lip_straight_across() -> None:
    columns, across = _columns()
    np.testing.assert_array_equal(mouth_rings()[columns], np.tile([0, 1, 2, 3], (38, 1)))
    np.testing.assert_allclose(across.sum(axis=1), 1)
    rim = load_basis().shape(load_basis().neutral).skin[columns[:, 0]]
    np.testing.assert_allclose((across @ rim)[:, 0], rim[:, 0], atol=1e-9)


def test_the_sheet_meets_half_way_and_leaves_the_face_alone(
    face: RestingFace, shouting: np.ndarray
) -> None:
    usual, drawn = acting_skin(face, shouting), skin_with_sheet(face, shouting)
    surface, inside = load_basis().surface, np.unique(mouth_faces())
    mouth = np.unique(surface.faces[surface.region == REGIONS.index("mouth")])
    moved = np.linalg.norm(drawn - usual, axis=1)
    assert np.delete(moved, mouth).max() < 2.5  # lips' edges are smooth
    middle = inside[np.abs(usual[inside, 0]) < 10]
    lips, sheet = (np.sort(points[middle, 1]) for points in (usual, drawn))
    assert np.ptp(lips) > 20
    assert np.diff(lips).max() > 5  # wide open
    assert np.diff(sheet).max() < 3  # and closed


def test_the_sheet_faces_forwards_where_its_halves_meet(face: RestingFace) -> None:
    smiling = load_basis().neutral.copy()
    smiling[load_basis().column["unit/jawOpen"]] += 0.2
    sheet = Mesh(skin_with_sheet(face, smiling), painted_faces(), load_basis().surface.uv)
    inside = np.unique(mouth_faces())
    middle = inside[np.abs(sheet.vertices[inside, 0]) < 15]
    assert np.quantile(sheet.normals()[middle, 2], 0.2) > 0.3


def test_no_two_painted_triangles_of_the_mouth_share_a_texel() -> None:
    raster = cover(load_basis().surface.uv, mouth_faces(), 512)
    places = raster.row * 512 + raster.column
    assert len(np.unique(places)) > 0.99 * len(places)


@pytest.mark.parametrize(("gap_ipds", "parted"), [(0.0, False), (0.02, False), (0.05, True)])
def test_lips_are_parted_from_a_gap_on(gap_ipds: float, parted: bool) -> None:
    points = np.zeros((468, 2))
    points[LIP_GAP[1], 1] = gap_ipds * 60
    seen = Perspective(np.eye(3), 1.0, np.zeros(2), 1e-3, np.zeros(3))
    pupils = np.array([[-30.0, 0, 0], [30.0, 0, 0]])
    shot = take_shot(np.zeros((8, 8, 3), np.float32), seen, points, pupils)
    assert lips_are_parted(shot) == parted
