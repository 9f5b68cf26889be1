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
_SKULL_MM = 10.0
_LEAST_TEXELS = 200 / 1024**2
_FADES = 200 / 1024
_BROWN = (0.05, 0.04, 0.03)
"""Hair that nobody sees."""


def paint_hair(skin: PhotographedSkin, shot: Shot, seen: Texels, person: NDArray[np.bool_]) -> Map:
    """Return the skin's albedo with hair painted on the skull: ``(S, S, 3)``.

    Args:
        skin: Bald.
        shot: The photograph.
        seen: What the skin's texels see of it.
        person: ``(H, W)`` of the photograph, where the person is.
    """
    size = len(seen.facing)
    _, y, z = np.moveaxis(zones(size).points, -1, 0)
    deep = cv2.distanceTransform(person.astype(np.uint8), cv2.DIST_L2, 5) / shot.ipd_px
    inside = smoothstep(*_INSIDE_IPDS, seen.sample(np.asarray(deep, np.float32)))
    bald = 1 - skin.known
    grows = np.maximum(smoothstep(*_ABOVE_MM, y), skin.hidden * smoothstep(*_BESIDE_MM, y))
    front = inside * seen.visible * smoothstep(*_FACING, seen.facing) * grows
    front = (front * bald).astype(np.float32)
    colour = np.clip(skin.lit * skin.gain, 0.003, 0.95)
    above = y - 62 - np.minimum(0, z + 30) * np.float32(0.9)
    skull = (smoothstep(-_SKULL_MM, _SKULL_MM, above) * bald)[..., None]
    sure = front * (y > 60) * (front > 0.7)
    if (sure > 0).mean() < _LEAST_TEXELS:
        behind = np.broadcast_to(np.log(np.array(_BROWN, np.float32)), colour.shape)
    else:
        tones = np.log(colour)
        median = np.median(tones[sure > 0], axis=0)
        near = extended(tones, sure.astype(np.float32), blur=4 * size / 1024)
        away = cv2.distanceTransform((sure <= 0).astype(np.uint8), cv2.DIST_L2, 5)
        far = smoothstep(0.0, _FADES * size, np.asarray(away, np.float32))[..., None]
        behind = near * (1 - far) + median * far
    painted = skin.albedo * (1 - skull) + np.exp(behind) * skull
    painted = painted * (1 - front[..., None]) + colour * front[..., None]
    return np.asarray(painted, np.float32)
