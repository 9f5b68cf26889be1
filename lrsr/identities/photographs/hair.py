"""What colour is the skull? That of the photograph's hair, painted where hair grows."""

import cv2
import numpy as np
from numpy.typing import NDArray

from lrsr.identities.photographs.shot import Shot, Texels
from lrsr.identities.photographs.skin import PhotographedSkin, extended
from lrsr.identities.photographs.zones import zones
from lrsr.identities.ramp import smoothstep

Map = NDArray[np.float32]

_INSIDE_IPDS = (0.02, 0.07)
"""How deep inside the person hair is taken: its edge is half background."""
_FACING = (0.1, 0.3)
_ABOVE_MM = (22.0, 34.0)
"""From the brows on upwards the photograph is painted as it is."""
_BESIDE_MM = (-30.0, -10.0)
"""Down to the ears it is where skin is hidden."""
_HAIRLINE_MM = 62.0
_SKULL_MM = 10.0
_RIM_IPDS = (0.05, 0.2)
"""How deep inside the person, above the hairline, the rim lies that tells the crown's colour."""
_FADES = 200 / 1024


def paint_hair(skin: PhotographedSkin, shot: Shot, seen: Texels, person: NDArray[np.bool_]) -> Map:
    """Return the skin's albedo with hair painted on the skull: ``(S, S, 3)``.

    What the photograph shows of the head above the brows is painted as it is. What it does not show
    of the skull takes the colour of the rim of the crown, be it hair or the skin of a bald head.

    Args:
        skin: Bald.
        shot: The photograph.
        seen: What the skin's texels see of it.
        person: ``(H, W)`` of the photograph, where the person is.
    """
    size = len(seen.facing)
    _, y, z = np.moveaxis(zones(size).points, -1, 0)
    deep = _depth_ipds(shot, person)
    rim = (deep > _RIM_IPDS[0]) & (deep < _RIM_IPDS[1]) & _above_hairline(shot)
    if not rim.any():
        return skin.albedo
    bald = 1 - skin.known
    grows = np.maximum(smoothstep(*_ABOVE_MM, y), skin.hidden * smoothstep(*_BESIDE_MM, y))
    front = smoothstep(*_INSIDE_IPDS, seen.sample(deep)) * smoothstep(*_FACING, seen.facing)
    front = np.asarray(front * seen.visible * grows * bald, np.float32)
    above = y - _HAIRLINE_MM - np.minimum(0, z + 30) * np.float32(0.9)
    skull = (smoothstep(-_SKULL_MM, _SKULL_MM, above) * bald)[..., None]
    colour = np.clip(skin.lit * skin.gain, 0.003, 0.95)
    crown = np.clip(np.median(shot.linear[rim], axis=0) * skin.gain, 0.003, 0.95)
    cheeks = np.median(colour[zones(size).core], axis=0)
    behind = _continued(np.log(colour), front, np.log(crown), np.log(cheeks))
    painted = skin.albedo * (1 - skull) + np.exp(behind) * skull
    return np.asarray(painted * (1 - front[..., None]) + colour * front[..., None], np.float32)


def _continued(tones: Map, front: Map, crown: Map, cheeks: Map) -> Map:
    """Continue the hair that is seen into the crown's colour, logarithms: ``(S, S, 3)``.

    What is seen is hair where its colour is nearer to the crown's than to that of the cheeks.
    """
    hair = np.linalg.norm(tones - crown, axis=-1) < np.linalg.norm(tones - cheeks, axis=-1)
    sure = ((front > 0.7) & hair).astype(np.float32)
    if not sure.any():
        return np.broadcast_to(crown, tones.shape)
    near = extended(tones, sure, blur=4 * len(tones) / 1024)
    away = cv2.distanceTransform((sure <= 0).astype(np.uint8), cv2.DIST_L2, 5)
    far = smoothstep(0.0, _FADES * len(tones), np.asarray(away, np.float32))[..., None]
    return np.asarray(near * (1 - far) + crown * far, np.float32)


def _depth_ipds(shot: Shot, person: NDArray[np.bool_]) -> Map:
    """Return how deep inside the person, who ends with the picture, each place is: ``(H, W)``."""
    framed = np.pad(person.astype(np.uint8), 1)
    deep = cv2.distanceTransform(framed, cv2.DIST_L2, 5)[1:-1, 1:-1]
    return np.asarray(deep / shot.ipd_px, np.float32)


def _above_hairline(shot: Shot) -> NDArray[np.bool_]:
    """Return which places of the photograph ``(H, W)`` are higher on the head than hairlines."""
    (foot, top), _ = shot.perspective.project(np.array([[0, _HAIRLINE_MM, 0], [0, 99.0, 0]]))
    upwards = (top - foot) / np.linalg.norm(top - foot)
    rows, columns = np.indices(shot.linear.shape[:2])
    return np.asarray((columns - foot[0]) * upwards[0] + (rows - foot[1]) * upwards[1] > 0)
