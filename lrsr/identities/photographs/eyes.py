"""What do the eyes look like? As photographed, between the lids."""

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.eyes import Eyes, eye_chart, eyeball_vertices, unit_ball
from lrsr.identities.face.iris import paint_eye, sample_iris
from lrsr.identities.head import Part
from lrsr.identities.photographs.shot import Depths, Mesh, Shot
from lrsr.identities.ramp import smoothstep

Map = NDArray[np.float32]
Points = NDArray[np.float64]

_SOFT_RAD = (-0.06, 0.02)
"""Across the lids' margins, as an angle on the eyeball."""
_EYE_PX = 256
_LIGHTEST = 0.8


def photographed_eye(
    shot: Shot, eyes: Eyes, which: int, margins: Points, gain: Map, depths: Depths
) -> Part:
    """Make an eyeball: the photograph inside the lids, a drawn one behind them.

    Args:
        shot: The photograph.
        eyes: Both eyes, head frame.
        which: 0 is the left one in the image, 1 the right one.
        margins: ``(2, 2, n, 3)`` of :func:`lrsr.identities.face.lids.lid_margins`.
        gain: ``(3,)`` from light to reflectance.
        depths: Of the head.
    """
    ball, vertices = unit_ball(), eyeball_vertices(eyes, which)
    chart = eye_chart(eyes, which, margins[which])
    rng = np.random.default_rng(which)
    iris = sample_iris(np.random.default_rng(1), european=0.5, eumelanin=1.5, age=0.3)
    drawn = paint_eye(iris, rng, chart, _EYE_PX)
    mesh = Mesh(vertices.astype(np.float64), ball.faces, ball.uv)
    seen = shot.texels(mesh, _EYE_PX, depths)
    colour = np.clip(seen.sample(shot.linear) * gain, 0, _LIGHTEST)
    angle = ((np.arange(_EYE_PX) + 0.5) / _EYE_PX * 2 - 1) * np.pi / 2
    upper, lower = (np.interp(angle, *lid[np.argsort(lid[:, 0])].T) for lid in chart)
    left, right = chart[..., 0].min(), chart[..., 0].max()
    height = -angle[:, None]
    gap = np.minimum(np.minimum(upper - height, height - lower), angle - left)
    share = smoothstep(*_SOFT_RAD, np.minimum(gap, right - angle))[..., None]
    albedo = np.clip(drawn * (1 - share) + colour * share, 0, 1).astype(np.float32)
    return Part(("left_eye", "right_eye")[which], "eye", vertices, ball.faces, ball.uv, albedo)
