"""What do glasses look like on this face? A frame that rests on nose and ears, and two lenses.

Sizes are those of shops: lenses 46 to 54 mm wide, a bridge that leaves their middles a little
outside the pupils, rims of metal or acetate. The front is curved, tilted, and as near to the face
as brows, cheeks and lashes let it be; the temples run along the head over the ears and down behind.
"""

from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray

from lrsr.identities.day.fit import Fit
from lrsr.identities.day.mesh import Mesh, Points, join, sheet, tube
from lrsr.identities.head import Part

_SHAPES = {"round": (2.1, 0.92), "oval": (2.4, 0.74), "square": (3.6, 0.78), "narrow": (3.2, 0.6)}
"""Exponent of the superellipse, and height over width."""

_COLOURS = {
    "metal": ((0.45, 0.44, 0.42), (0.09, 0.09, 0.095), (0.45, 0.33, 0.16)),
    "acetate": (
        (0.012, 0.012, 0.013),
        (0.05, 0.022, 0.01),
        (0.16, 0.075, 0.03),
        (0.03, 0.04, 0.07),
    ),
}
_HALF_MM = {"metal": (0.8, 0.8), "acetate": (2.1, 1.5)}
"""Half the thickness of a rim, in the plane of the lens and across it."""
_BEFORE_CORNEA_MM = 15.0
"""Least distance of a lens from the plane of the pupils: 12 mm from the corneas."""
_CLEAR_MM = 1.2
_STAND_OFF_MM = 5.0
_SIZES = 7
_CURVE_MM = 135.0
"""Radius of the front: lenses of four dioptres."""
_TILT = np.tan(np.deg2rad(7.0))
_TIP_MM = (13.0, 30.0)
"""How far a temple goes on behind the ear, and down."""
_RIM, _TEMPLE, _LENS_RINGS = 64, 48, 8


def sample_glasses(rng: Generator, ipd_mm: float) -> dict[str, Any]:
    """Draw a pair of glasses.

    Args:
        rng: Source of randomness.
        ipd_mm: Interpupillary distance: larger for large heads.

    Returns:
        Plain numbers and names.
    """
    shape = str(rng.choice(list(_SHAPES)))
    made_of = str(rng.choice(list(_COLOURS)))
    width = (46.0 + 8.0 * rng.random()) * (ipd_mm / 63.0) ** 0.5
    return {
        "shape": shape,
        "made_of": made_of,
        "colour": list(_COLOURS[made_of][int(rng.integers(len(_COLOURS[made_of])))]),
        "width_mm": float(width),
        "height_mm": float(width * _SHAPES[shape][1] * rng.uniform(0.95, 1.05)),
        "half_mm": [half * float(rng.uniform(0.85, 1.2)) for half in _HALF_MM[made_of]],
    }


def build_glasses(glasses: dict[str, Any], fit: Fit) -> tuple[Part, Part]:
    """Put glasses on a head.

    Args:
        glasses: As :func:`sample_glasses` draws them.
        fit: Of the head.

    Returns:
        The parts "glasses" and "lenses", of the same faces for everybody.
    """
    front = _Front(glasses, fit)
    pieces = [front.bridge()]
    for sign in (-1, 1):
        pieces += [front.rim(sign), front.pad(sign), _temple(glasses, fit, front, sign)]
    frame, lenses = join(pieces), join([front.lens(sign) for sign in (-1, 1)])
    colour = np.asarray(glasses["colour"])
    material: Any = "metal" if glasses["made_of"] == "metal" else "plastic"
    return _part("glasses", material, frame, colour), _part("lenses", "glass", lenses, np.ones(3))


class _Front:
    """The surface that rims and lenses lie on, as near to the face as it lets them."""

    def __init__(self, glasses: dict[str, Any], fit: Fit) -> None:
        self._fit, self._half = fit, glasses["half_mm"]
        self._exponent = _SHAPES[glasses["shape"]][0]
        self._size = np.array([glasses["width_mm"], glasses["height_mm"]]) / 2
        pupil = float(np.abs(fit.pupils[:, 0]).mean())
        least = _BEFORE_CORNEA_MM + pupil**2 / (2 * _CURVE_MM)
        for _ in range(_SIZES):  # a smaller pair, where nose or cheeks push this one off
            narrowest = self._size[0] + self._half[0] + 7.0  # half a bridge
            self._x = max(pupil + 1.5, narrowest)
            self._y, self._z = -0.16 * self._size[1], 0.0
            self._z = max(least, self._nearest())
            if self._z < least + _STAND_OFF_MM:
                break
            self._size *= 0.94

    def outline(self, sign: int, share: float = 1.0) -> Points:
        """Return the edge of a lens, ``(N, 2)``, from its outermost point on; smaller by a share.

        Counter-clockwise seen from in front for both.
        """
        angle = np.linspace(0, 2 * np.pi, _RIM, endpoint=False)
        x, y = (
            np.sign(w) * np.abs(w) ** (2 / self._exponent) for w in (np.cos(angle), np.sin(angle))
        )
        y = y * (1.0 + 0.06 * x)  # higher outside
        flat = share * self._size * np.stack([x, y], axis=1) + [self._x, self._y]
        mirrored = (flat * [-1, 1])[np.r_[0, _RIM - 1 : 0 : -1]]
        return np.asarray(flat if sign > 0 else mirrored)

    def place(self, flat: Points) -> Points:
        """Lift places ``(..., 2)`` to the surface, ``(..., 3)``."""
        x, y = flat[..., 0], flat[..., 1]
        bow = (x**2 + (y - self._y) ** 2) / (2 * _CURVE_MM)
        return np.stack([x, y, self._z - bow + _TILT * y], axis=-1)

    def _nearest(self) -> float:
        """Return the least z at which rims and lenses clear the face."""
        flat = np.concatenate(
            [self.outline(sign, share) for sign in (-1, 1) for share in (1.06, 1.0, 0.8, 0.5, 0.2)]
        )
        behind = self.place(flat)[:, 2] - self._half[1] - _CLEAR_MM
        return float((self._fit.front.at(flat[:, 0], flat[:, 1]) - behind).max())

    def rim(self, sign: int) -> Mesh:
        path = self.place(self.outline(sign))
        return tube(path, (0, 0, 1.0), tuple(self._half), closed=True, squareness=self._boxy)

    @property
    def _boxy(self) -> float:
        return 4.0 if self._half[0] > 1.3 else 2.0

    def lens(self, sign: int) -> Mesh:
        shares = np.linspace(0.0, 0.985, _LENS_RINGS)
        return sheet(np.stack([self.place(self.outline(sign, s)) for s in shares]), closed=True)

    def bridge(self) -> Mesh:
        """An arch from rim to rim over the nose."""
        inner = self._x - self._size[0]
        x = np.linspace(-1, 1, 24) * inner
        y = self._y + 0.38 * self._size[1] + 2.5 * (1 - (x / inner) ** 2)
        path = self.place(np.stack([x, y], axis=1))
        clear = self._fit.front.at(x, y) + self._half[1] + 0.6
        lift = np.maximum(clear - path[:, 2], 0.0) * (np.abs(x) < inner - 1)
        path[:, 2] += np.convolve(np.pad(lift, 3, mode="edge"), np.full(7, 1 / 7), mode="valid")
        return tube(path, (0, 0, 1.0), tuple(self._half), squareness=self._boxy)

    def pad(self, sign: int) -> Mesh:
        """A stub from the inner rim down to the side of the nose."""
        inner = self._x - self._size[0]
        y = self._y + 0.1 * self._size[1]
        start = self.place(np.array([sign * (inner + 0.3), y]))
        reach = np.linspace(0.0, 1.0, 6)[:, None]
        x = max(5.0, 0.62 * inner)
        foot = np.array([sign * x, y - 1.5, float(self._fit.front.at(sign * x, y - 1.5)[0]) + 0.8])
        foot[2] = min(foot[2], start[2])
        return tube(start + reach * (foot - start), (0, 1.0, 0), (1.0, 2.2))

    def hinge(self, sign: int) -> Points:
        """Return the outermost point of a rim, where its temple begins, ``(3,)``."""
        flat = np.array([sign * (self._x + self._size[0]), self._y + 0.3 * self._size[1]])
        return np.asarray(self.place(flat))


def _temple(glasses: dict[str, Any], fit: Fit, front: _Front, sign: int) -> Mesh:
    """From the rim out, along the head to the ear and down behind it."""
    start, (top, fore, _) = front.hinge(sign), fit.ear(sign)
    thin, thick = 0.9, max(1.6, 1.1 * glasses["half_mm"][0] + 0.4)
    bend = np.array([top[2] - 3.0, top[1] - 0.5])  # z, y
    ahead = np.linspace(start[2] - 4.0, bend[0], _TEMPLE - 14)
    level = np.interp(ahead, [bend[0], fore[2], start[2]], [bend[1], bend[1] + 0.5, start[1]])
    turn = np.linspace(0.0, 0.5 * np.pi, 13)[1:]
    z = np.concatenate([ahead, bend[0] - _TIP_MM[0] * np.sin(turn)])
    y = np.concatenate([level, bend[1] - _TIP_MM[1] * (1 - np.cos(turn))])
    beside = fit.side(sign).at(z, y) + thin + 0.5
    at_ear = beside[len(ahead) - 1]
    straight = np.interp(z, [bend[0], start[2] - 4.0], [at_ear, abs(start[0]) + 3.5])
    x = np.where(z >= bend[0], np.maximum(beside, straight), beside)
    x = np.maximum(np.convolve(np.pad(x, 3, mode="edge"), np.full(7, 1 / 7), mode="valid"), beside)
    corner = np.array([sign * (abs(start[0]) + 2.0), start[1], start[2] - 1.0])
    path = np.vstack([start, corner, np.stack([sign * x, y, z], axis=1)])
    up = np.tile([0.0, 1.0, 0.0], (len(path), 1))
    up[-len(turn) :] = np.stack([0 * turn, np.cos(turn), -np.sin(turn)], axis=1)
    return tube(path, up, (thin, thick), squareness=4.0)


def _part(name: str, material: Any, mesh: Mesh, colour: NDArray[np.floating]) -> Part:
    albedo = np.broadcast_to(np.asarray(colour, dtype=np.float32), (4, 4, 3)).copy()
    return Part(
        name,
        material,
        mesh.vertices.astype(np.float32),
        mesh.faces.astype(np.int32),
        mesh.uv.astype(np.float32),
        albedo,
    )
