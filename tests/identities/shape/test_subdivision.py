import numpy as np
import pytest

from lrsr.identities.shape.subdivision import _split_smoothly, subdivide, triangulate

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
CUBE_QUADS = np.array(
    [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
)
STRIP = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]])
ONE_QUAD = np.array([[0, 1, 2, 3]])


def slow_catmull_clark(points: np.ndarray, quads: np.ndarray) -> dict[str, list[np.ndarray]]:
    """The rules of the paper with loops, for a closed mesh: vertex, edge and face points."""
    face_points = [points[quad].mean(axis=0) for quad in quads]
    faces_of: dict[int, list[int]] = {}
    edges: dict[tuple[int, int], list[int]] = {}
    for f, quad in enumerate(quads.tolist()):
        for a, b in zip(quad, quad[1:] + quad[:1], strict=True):
            faces_of.setdefault(a, []).append(f)
            edges.setdefault((min(a, b), max(a, b)), []).append(f)
    edge_points = [
        (points[a] + points[b] + face_points[f] + face_points[g]) / 4
        for (a, b), (f, g) in sorted(edges.items())
    ]
    vertex_points = []
    for v in range(len(points)):
        n = len(faces_of[v])
        q = np.mean([face_points[f] for f in faces_of[v]], axis=0)
        r = np.mean([(points[a] + points[b]) / 2 for a, b in edges if v in (a, b)], axis=0)
        vertex_points.append((q + 2 * r + (n - 3) * points[v]) / n)
    return {"vertices": vertex_points, "edges": edge_points, "faces": face_points}


def test_one_round_of_a_cube_agrees_with_the_rules_written_as_loops() -> None:
    slow = slow_catmull_clark(CUBE, CUBE_QUADS)
    expected = np.array([*slow["vertices"], *slow["edges"], *slow["faces"]])
    np.testing.assert_allclose(_split_smoothly(CUBE_QUADS, 8).matrix @ CUBE, expected, atol=1e-12)


def test_two_rounds_agree_with_the_loops_applied_twice() -> None:
    once = _split_smoothly(CUBE_QUADS, 8)
    slow = slow_catmull_clark(once.matrix @ CUBE, once.quads)
    expected = np.array([*slow["vertices"], *slow["edges"], *slow["faces"]])
    both = subdivide(CUBE_QUADS, 8, 2, smooth=True)
    np.testing.assert_allclose(both.matrix @ CUBE, expected, atol=1e-12)


def test_a_cubes_corner_moves_to_two_ninths() -> None:
    np.testing.assert_allclose((_split_smoothly(CUBE_QUADS, 8).matrix @ CUBE)[0], [2 / 9] * 3)


def test_an_open_borders_vertex_follows_the_cubic_spline() -> None:
    moved = _split_smoothly(ONE_QUAD, 4).matrix @ STRIP
    expected = (6 * STRIP[0] + STRIP[1] + STRIP[3]) / 8
    np.testing.assert_allclose(moved[0], expected)


@pytest.mark.parametrize("smooth", [True, False], ids=["smooth", "linear"])
@pytest.mark.parametrize("rounds", [0, 1, 2])
def test_every_row_sums_to_one_so_that_a_moved_mesh_moves_along(smooth: bool, rounds: int) -> None:
    matrix = subdivide(CUBE_QUADS, 8, rounds, smooth=smooth).matrix
    np.testing.assert_allclose(np.asarray(matrix.sum(axis=1)).ravel(), 1.0)


def test_linear_halving_leaves_a_plane_where_it_is() -> None:
    halved = subdivide(ONE_QUAD, 4, 2, smooth=False)
    points = halved.matrix @ STRIP
    assert np.unique(points[:, :2]).tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    np.testing.assert_allclose(points[:4], STRIP)


@pytest.mark.parametrize("rounds", [0, 1, 2])
def test_each_round_makes_four_quads_of_one_in_their_order(rounds: int) -> None:
    divided = subdivide(CUBE_QUADS, 8, rounds, smooth=False)
    centres = (divided.matrix @ CUBE)[divided.quads].mean(axis=1)
    assert len(divided.quads) == 6 * 4**rounds
    owner = np.linalg.norm(centres[:, None] - CUBE[CUBE_QUADS].mean(axis=1)[None], axis=2).argmin(
        axis=1
    )
    assert owner.tolist() == np.repeat(np.arange(6), 4**rounds).tolist()


def test_the_winding_is_kept() -> None:
    divided = subdivide(ONE_QUAD, 4, 2, smooth=True)
    triangles = (divided.matrix @ STRIP)[triangulate(divided.quads)]
    normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
    assert (normals[:, 2] > 0).all()


def test_a_vertex_without_a_quad_stays() -> None:
    matrix = _split_smoothly(ONE_QUAD, 5).matrix
    assert matrix[4].toarray().tolist() == [[0, 0, 0, 0, 1]]


def test_where_more_than_two_borders_meet_the_vertex_stays() -> None:
    bow_tie = np.array([[0, 1, 2, 3], [2, 4, 5, 6]])
    assert _split_smoothly(bow_tie, 7).matrix[2].toarray()[0].tolist() == [0, 0, 1, 0, 0, 0, 0]
