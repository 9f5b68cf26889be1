"""What is seen when the lips part? Two rows of teeth, a tongue, and a dark cavity behind them.

MakeHuman's mouth ends three rings of quads behind the lips. There the shape space closes it with a
strip (:mod:`lrsr.identities.shape.topology`); here the strip is drawn back into a cavity, before
which the teeth stand. They are built in the template's millimetres and moved to where a person's
lips meet when the face is at rest: teeth do not follow lips. Lower teeth and tongue follow the jaw.
Everybody has the same mesh, and behind closed lips nothing of it is seen.
"""

from collections.abc import Mapping
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.teeth import Jaws, build_jaws, paint_jaws
from lrsr.identities.head import Part
from lrsr.identities.shape.basis import BaseHead, load_basis
from lrsr.identities.shape.position_map import draw_triangles, fill_outside
from lrsr.identities.shape.topology import REGIONS

Points = NDArray[np.float64]

STRIP_QUADS = 18
"""The last quads of the basis close the mouth."""
_CAVITY_MM = 55.0
"""How far behind the lips the mouth ends; the tongue is about as long."""
_LIP_LINE_MM = (-72.3, 7.4)
"""Height of the template's lip line, and the depth of the foremost inside of its lips."""
_CORNER_MM = 24.6
"""Half the width of the template's mouth."""
_FRONT_TEETH_MM = 15.0
"""How far from the middle the front teeth reach."""
_BEHIND_LIPS_MM = 3.0
"""Least depth of front teeth behind the skin before them: lips that recede take them along."""
_NEAR_MM = 3.5
"""How far aside skin counts as before a tooth: about the mesh's width at the lips."""
_MUCOSA = (0.33, 0.105, 0.10)
"""Reflectance of the inside of lips and cheeks: blood under a wet skin without pigment
(estimated from photographs)."""
_THROAT = (0.12, 0.026, 0.026)

_JAW_OPEN = np.array([[0.0, 0.0, 0.0], [0.0, -0.092, 0.368], [0.0, -0.373, -0.088]])
_JAW_OPEN_AT_ORIGIN = np.array([0.0, -33.019, 13.568])
"""What ``jawOpen`` does to MakeHuman's own lower teeth: ``point @ _JAW_OPEN + ..._AT_ORIGIN``, a
turn by 21 degrees about the joints of the jaw; fitted, largest error 0.1 mm."""
_JAW_SHIFTS = {
    "jawForward": (0.0, -1.5, 8.3),
    "jawLeft": (6.6, -0.8, 4.3),
    "jawRight": (-6.6, -0.8, 4.3),
}
"""What the other units do to them, mm."""
JAW_UNITS = ("jawOpen", *_JAW_SHIFTS)


class _Cavity(NamedTuple):
    """The skin's vertices behind the lips.

    Attributes:
        vertices: ``(n,)`` render vertices within the strip.
        depths: ``(n,)`` mm, how far each is drawn back.
        inside: ``(V,)`` 0 on the face and where lips meet, 1 from the second ring inwards.
        outside: ``(V,)`` float32, 1 less that: neither lines nor beards grow inside.
        deep: ``(V,)`` 0 before the cavity, 1 at its end.
    """

    vertices: NDArray[np.int64]
    depths: Points
    inside: Points
    outside: NDArray[np.float32]
    deep: Points

    def hollow(self, points: Points) -> Points:
        """Return a copy of the skin ``(V, 3)``, mm, with the strip drawn back."""
        moved = points.copy()
        moved[self.vertices, 2] -= self.depths
        return moved


@lru_cache(maxsize=1)
def mouth_rings() -> NDArray[np.int64]:
    """Count how many quads behind the meeting of the lips a base vertex lies; 0 on the face."""
    basis = load_basis()
    mouth = basis.quads[basis.region == REGIONS.index("mouth")][:-STRIP_QUADS]
    ring = np.zeros(basis.n_skin, np.int64)
    known = set(np.unique(basis.quads[basis.region == 0]).tolist())
    for depth in (1, 2, 3):
        reached = set(mouth[np.isin(mouth, list(known)).any(axis=1)].ravel().tolist()) - known
        ring[list(reached)] = depth
        known |= reached
    return ring


@lru_cache(maxsize=1)
def cavity() -> _Cavity:
    """Find the inside of the mouth on the skin's mesh; later calls are free."""
    basis = load_basis()
    surface = basis.surface
    n_strip = STRIP_QUADS * len(surface.faces) // len(basis.quads)
    strip, rest = surface.faces[-n_strip:], surface.faces[:-n_strip]
    known = np.zeros(len(surface.twin), bool)
    known[surface.twin[rest]] = True
    step = np.zeros(len(known))
    for share in (0.7, 1.0, 1.0):
        near = surface.twin[strip[known[surface.twin[strip]].any(axis=1)]]
        fresh = np.setdiff1d(near, np.flatnonzero(known))
        step[fresh], known[fresh] = share, True
    step = step[surface.twin]
    inside = np.clip(surface.matrix @ np.clip(mouth_rings() - 1.0, 0.0, 1.0), 0.0, 1.0)
    found = np.flatnonzero(step)
    outside = (1.0 - inside).astype(np.float32)
    return _Cavity(found, _CAVITY_MM * step[found], inside, outside, step)


class _Lining(NamedTuple):
    """The mouth's part of the skin's texture.

    Attributes:
        box: Rows and columns.
        inside: ``(h, w, 1)`` float32, share of mucosa.
        deep: ``(h, w, 1)`` float32, share of throat.
    """

    box: tuple[slice, slice]
    inside: NDArray[np.float32]
    deep: NDArray[np.float32]

    def paint(self, albedo: NDArray[np.float32]) -> None:
        """Cover the inside of the mouth in a skin's albedo ``(H, W, 3)``, in place."""
        part = albedo[self.box]
        for share, colour in ((self.inside, _MUCOSA), (self.deep, _THROAT)):
            part += share * (np.asarray(colour, np.float32) - part)


@lru_cache(maxsize=4)
def lining(texture_size: int) -> _Lining:
    """Find the mouth in a texture of that many rows; later calls are free.

    Args:
        texture_size: Rows and columns of the skin's texture, >= 64.
    """
    surface = load_basis().surface
    faces = surface.faces[surface.region == REGIONS.index("mouth")]
    shares = np.stack([cavity().inside, cavity().deep], axis=1)
    drawn, mask = draw_triangles(surface.uv, faces, shares, texture_size)
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    box = slice(rows[0] - 1, rows[-1] + 2), slice(columns[0] - 1, columns[-1] + 2)
    filled = fill_outside(drawn[box], mask[box]).astype(np.float32)
    return _Lining(box, filled[..., :1], filled[..., 1:])


@lru_cache(maxsize=1)
def _inner_lips() -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Base vertices where the lips meet, and those behind, near the middle of the mouth."""
    basis = load_basis()
    ring, mouth = mouth_rings(), basis.quads[basis.region == REGIONS.index("mouth")]
    template = basis.shape(basis.neutral).skin
    middle = np.intersect1d(np.unique(mouth), np.flatnonzero(np.abs(template[:, 0]) < 6.0))
    return middle[ring[middle] == 0], middle[ring[middle] > 0]


def _jaw_offset(points: Points, units: Mapping[str, float]) -> Points:
    """Tell how far the jaw carries points of the template."""
    offset = units.get("jawOpen", 0.0) * (points @ _JAW_OPEN + _JAW_OPEN_AT_ORIGIN)
    for unit, shift in _JAW_SHIFTS.items():
        offset += units.get(unit, 0.0) * np.array(shift)
    return np.asarray(offset)


def _place_jaws(jaws: Jaws, rest: BaseHead, units: Mapping[str, float]) -> NDArray[np.float32]:
    """Put teeth and tongue behind a person's lips: ``(V, 3)`` float32, mm."""
    points = jaws.vertices.copy()
    points[jaws.lower] += _jaw_offset(points[jaws.lower], units)
    meeting, behind = _inner_lips()
    left, right = rest.skin[load_basis().landmark_vertices[1:]]
    width = np.linalg.norm(right - left) / (2 * _CORNER_MM)
    points[:, 0] *= np.clip(np.sqrt(width), 0.85, 1.1)
    line = rest.skin[meeting].mean(axis=0)
    depth = rest.skin[behind, 2].min()
    place = np.array([line[0], line[1] - _LIP_LINE_MM[0], depth - _LIP_LINE_MM[1]])
    place[2] -= _excess_mm(jaws.vertices + place, rest)
    return np.asarray(points + place, dtype=np.float32)


def _excess_mm(points: Points, rest: BaseHead) -> float:
    """Tell how far front teeth must go back to stand :data:`_BEHIND_LIPS_MM` behind all lips."""
    points = points[np.abs(points[:, 0]) < _FRONT_TEETH_MM]
    skin = rest.skin[np.linalg.norm(rest.skin - points.mean(axis=0), axis=1) < 2 * _CORNER_MM]
    low, high = points.min(axis=0) - _NEAR_MM, points.max(axis=0) + _NEAR_MM
    x, y, z = skin[((skin > low) & (skin < high))[:, :2].all(axis=1)].T
    squares = (points[:, :1] - x) ** 2 + (points[:, 1:2] - y) ** 2
    before = np.where(squares < _NEAR_MM**2, z, -np.inf).max(axis=1, initial=-np.inf)
    before -= points[:, 2]
    return max(0.0, _BEHIND_LIPS_MM - float(before[np.isfinite(before)].min(initial=np.inf)))


def build_mouth(
    rest: BaseHead, units: Mapping[str, float], *, age: float, shade: float = 0.0
) -> Part:
    """Make teeth, gums and tongue of one person.

    Args:
        rest: The person's coarse head in the head frame, without any expression.
        units: Strengths of the face units that are worn, of the resting face too.
        age: 0 (25 years) to 1 (old); teeth darken and yellow.
        shade: A person's own: standard normal, > 0 is darker.

    Returns:
        The part "mouth"; its faces, uv and texture size are everybody's.
    """
    jaws = build_jaws()
    vertices = _place_jaws(jaws, rest, units)
    return Part("mouth", "eye", vertices, jaws.faces, jaws.uv, paint_jaws(age, shade))
