"""Which quads of a whole human make the head, and where does each lie in the texture?"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from lrsr.identities.shape.makehuman import LEFT_EYE, RIGHT_EYE, BaseMesh
from lrsr.identities.shape.subdivision import sides


def _islands(uv_quads: NDArray[np.int64], n_uv: int) -> NDArray[np.int64]:
    """Label the connected pieces of a texture layout: ``(F,)``."""
    start, end = sides(uv_quads).T
    graph = sparse.coo_matrix((np.ones(len(start)), (start, end)), (n_uv, n_uv))
    labels: NDArray[np.int64] = connected_components(graph, directed=False)[1][uv_quads[:, 0]]
    return labels


def _rings(quads: NDArray[np.int64], start: NDArray[np.int64], count: int) -> NDArray[np.bool_]:
    """Mark the quads of the first ``count`` rings inwards from the vertices ``start``."""
    known, taken = set(start.tolist()), np.zeros(len(quads), bool)
    for _ in range(count):
        now = np.isin(quads, list(known)).any(axis=1) & ~taken
        taken |= now
        known |= set(quads[now].ravel().tolist())
    return taken


def _loop(quads: NDArray[np.int64], members: NDArray[np.int64]) -> list[int]:
    """Walk the open border all of whose vertices are among ``members``, once around."""
    pairs = {(int(a), int(b)) for a, b in sides(quads)}
    inside = set(members.tolist())
    after = {a: b for a, b in pairs if (b, a) not in pairs and a in inside and b in inside}
    walk = [min(after)]
    while len(walk) < len(after):
        walk.append(after[walk[-1]])
    return walk


class Topology(NamedTuple):
    """Which quads of the base mesh make the head.

    Attributes:
        quads: ``(F, 4)`` vertex indices of base.obj.
        uv_quads: ``(F, 4)`` uv indices of base.obj.
        region: ``(F,)``: index into :data:`REGIONS`.
    """

    quads: NDArray[np.int64]
    uv_quads: NDArray[np.int64]
    region: NDArray[np.int64]


REGIONS = ("head", "shoulders", "left_socket", "right_socket", "mouth")


def choose_faces(base: BaseMesh, template: NDArray[np.float64]) -> Topology:
    """Cut the head out of the body and close it.

    Args:
        base: The whole human.
        template: ``(N, 3)``, mm: an average adult, in head frame; decides how far the cut goes.

    Returns:
        Head, shoulders, three rings of each eye socket, and of the mouth three rings and a
        strip that closes it.
    """
    corners = base.groups["body"]
    quads, uv_quads = corners[..., 0], corners[..., 1]
    island = _islands(uv_quads, len(base.uv))
    centre = template[quads].mean(axis=1)
    left, right = template[slice(*LEFT_EYE)].mean(axis=0), template[slice(*RIGHT_EYE)].mean(axis=0)

    def nearest(point: NDArray[np.float64]) -> int:
        labels = np.unique(island)
        middles = [centre[island == label].mean(axis=0) for label in labels]
        return int(labels[np.argmin(np.linalg.norm(np.array(middles) - point, axis=1))])

    head = int(island[np.argmax(centre[:, 1])])
    body = int(island[np.argmin(np.abs(centre[:, 0]) + np.abs(centre[:, 1] + 240.0))])
    teeth = np.unique(base.groups["helper-tongue"][..., 0])
    mouth = nearest(template[teeth].mean(axis=0))
    near = (template[quads][..., 1] > -262.0) & (np.abs(template[quads][..., 0]) < 215.0)
    rim = np.unique(quads[island == head])
    chosen = [(island == head), (island == body) & near.all(axis=1)]
    for label in (nearest(left), nearest(right), mouth):
        part = island == label
        chosen.append(np.zeros(len(quads), bool))
        chosen[-1][part] = _rings(quads[part], rim, 3)
    pieces = [(quads[part], uv_quads[part]) for part in chosen]
    lips, lip_uv = pieces[-1]
    _, inner = np.unique(lips, return_index=True)
    uv_of = dict(zip(lips.ravel()[inner].tolist(), lip_uv.ravel()[inner].tolist(), strict=True))
    strip = _strip(lips, np.setdiff1d(lips, rim), template)
    pieces[-1] = (
        np.concatenate([lips, strip]),
        np.concatenate([lip_uv, np.vectorize(uv_of.__getitem__)(strip)]),
    )
    return Topology(
        np.concatenate([piece[0] for piece in pieces]),
        np.concatenate([piece[1] for piece in pieces]),
        np.repeat(np.arange(len(pieces)), [len(piece[0]) for piece in pieces]),
    )


def _strip(
    quads: NDArray[np.int64], inner: NDArray[np.int64], points: NDArray[np.float64]
) -> NDArray[np.int64]:
    """Close an open border, wider than high, with quads from corner to corner."""
    walk = np.array(_loop(quads, inner))
    n = len(walk)
    x = points[walk, 0]
    corner = int(np.argmax(x + np.roll(x, -1)))  # the side that ends the strip
    walk = np.roll(walk, -corner - 1)
    i = np.arange(n // 2 - 1)
    return np.stack([walk[n - 1 - i], walk[n - 2 - i], walk[i + 1], walk[i]], axis=1)


_TILES = {
    "head": (0.0, 0.0, 1.0, 0.83),
    "shoulders": (0.0, 0.84, 0.8, 0.995),
    "left_socket": (0.81, 0.84, 0.9, 0.91),
    "right_socket": (0.905, 0.84, 0.995, 0.91),
    "mouth": (0.81, 0.92, 0.995, 0.995),
}
"""Where each region lies in the texture: left, top, right, bottom in [0, 1], v downwards."""
_FACE_GAIN = 2.2
"""How many times denser than the rest of the head the texels of the face lie, along each axis."""


def _equalise(
    along: NDArray[np.float64], edges: NDArray[np.int64], points: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Stretch one axis of a layout so that texels lie as dense as the skin asks for.

    Args:
        along: ``(N,)`` the coordinate of every uv vertex.
        edges: ``(E, 2)`` uv indices.
        points: ``(N, 3)``, head frame, mm.

    Returns:
        ``(N,)`` an increasing function of ``along``, from 0 to 1 over the used range.
    """
    low, high = along[edges].min(), along[edges].max()
    bins = np.linspace(low, high, 129)
    step = np.abs(along[edges[:, 1]] - along[edges[:, 0]])
    length = np.linalg.norm(points[edges[:, 1]] - points[edges[:, 0]], axis=1)
    middle = points[edges].mean(axis=1)
    face = (np.abs(middle[:, 0]) < 66) & (middle[:, 2] > -55) & (np.abs(middle[:, 1] + 25) < 85)
    weight = np.where(face, 6.0, 1.0) * step * (step > 0.1 * length / 250.0)
    where = np.digitize(along[edges].mean(axis=1), bins[1:-1])
    stretch = np.minimum(length / np.maximum(step, 1e-9), 1500.0)
    total = np.bincount(where, weight, 128) + 1e-9
    density = np.bincount(where, weight * stretch, 128) / total
    share = np.bincount(where, weight * face, 128) / total
    density *= 1.0 + (_FACE_GAIN - 1.0) * share
    smooth = np.convolve(np.pad(density, 6, mode="edge"), np.full(13, 1 / 13), mode="valid")
    smooth = np.maximum(smooth, 0.15 * smooth.mean())
    total_length = np.concatenate([[0.0], np.cumsum(smooth)])
    return np.asarray(np.interp(along, bins, total_length / total_length[-1]))


def lay_out(
    base: BaseMesh, topology: Topology, template: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Give the head a texture layout of its own: ``(N, 2)`` for every uv index, v downwards.

    The islands of MakeHuman's layout are kept (they do not overlap), each in its tile. The head is
    turned upright and stretched along both axes, because the original gives an eye 30 texels in
    a thousand and the back of the head 300.
    """
    uv = np.zeros_like(base.uv)
    points = np.zeros((len(uv), 3))
    points[topology.uv_quads.ravel()] = template[topology.quads.ravel()]
    for index, name in enumerate(REGIONS):
        quads = topology.uv_quads[topology.region == index]
        used = np.unique(quads)
        flat = base.uv * [1.0, -1.0]
        if name == "head":
            edges = np.unique(np.sort(sides(quads), axis=1), axis=0)
            flat = np.stack([_equalise(base.uv[:, k], edges, points) for k in (1, 0)], axis=1)
        low, high = flat[used].min(axis=0), flat[used].max(axis=0)
        left, top, right, bottom = _TILES[name]
        margin = 0.004
        corner = np.array([left, top]) + margin
        size = np.array([right - left, bottom - top]) - 2 * margin
        uv[used] = corner + (flat[used] - low) / (high - low) * size
    return uv
