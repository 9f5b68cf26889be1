"""What colour is the skin of somebody on a photograph? Their texture, without the light.

What is seen well is the photograph, divided by the light; what is hidden follows the other half of
the face, and beyond that a plain skin of the same colour: everything is blended as the logarithm of
a ratio to that skin, so no seam shows.
"""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from lrsr.errors import InputError
from lrsr.identities.appearance import SkinMaps
from lrsr.identities.morphable import paint_plain_skin
from lrsr.identities.photographs.light import estimate_cast, estimate_shading
from lrsr.identities.photographs.shot import Shot, Texels
from lrsr.identities.photographs.white import light_colour
from lrsr.identities.photographs.zones import Zones, zones
from lrsr.identities.ramp import smoothstep

Map = NDArray[np.float32]

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
_KEY = 0.9
"""Light of a well exposed face: the renderer's, whose white card is that bright."""
_LEVELS = (0.05, 0.55)
"""Darkest and lightest skin, luminance: beyond them a photograph is wrongly exposed."""
_FACING = (0.2, 0.5)
_INSIDE_IPDS = (0.03, 0.15)
_MIRRORED = 0.8
_MIDDLE_MM = (4.0, 14.0)
"""How far from the middle a texel must be to learn from its mirror image."""
_DARK, _BRIGHT, _OTHER_HUE = -0.75, 0.8, 5.0
"""Logarithms of luminance, and robust deviations of hue, beyond which skin is hidden."""
_TONE_BLUR = 6 / 1024
"""Of the texture: spots that are smaller are no light."""
_COARSER = 4
"""Texels that one of such a smooth map spans."""
_LEAST_CORE = 0.005
"""Share of the texture that cheeks and nose must have to be measured; about 0.05 if all is seen."""
_GROWN = 10 / 1024
"""By how much of the texture such patches are grown."""
_FADES = 60 / 1024
"""Over how much of it the colour beyond what is seen becomes that of the whole face."""


@dataclass(frozen=True, eq=False)
class PhotographedSkin:
    """A skin's texture and how it came about.

    Attributes:
        albedo: ``(S, S, 3)`` float32, linear, [0, 1].
        lit: ``(S, S, 3)`` light on the photograph, that of skin as if all had the core's hue.
        gain: ``(3,)`` from linear light on the photograph to reflectance, shading aside.
        known: ``(S, S)`` float32, how much of each texel is the photograph's, mirrored or not.
        hidden: ``(S, S)`` float32, where hair or something else lies over the skin.
        seen: Share of plain skin on the front of the face that is seen.
        unevenness: Of what is left of the light; see
            :func:`lrsr.identities.photographs.light.estimate_shading`.
        tint: ``(2,)`` logarithms of the light's red and blue over its green, as far as corrected.
    """

    albedo: Map
    lit: Map
    gain: Map
    known: Map
    hidden: Map
    seen: float
    unevenness: float
    tint: tuple[float, float]


def paint_photographed(shot: Shot, seen: Texels, oval: NDArray[np.bool_]) -> PhotographedSkin:
    """Make the texture of a skin.

    Args:
        shot: The photograph.
        seen: What the skin's texels see of it.
        oval: ``(H, W)`` of the photograph, where the landmarks have the face.

    Raises:
        InputError: No cheeks or nose are seen.
    """
    size = len(seen.facing)
    parts = zones(size)
    deep = cv2.distanceTransform(oval.astype(np.uint8), cv2.DIST_L2, 5) / np.float32(shot.ipd_px)
    inside = smoothstep(*_INSIDE_IPDS, seen.sample(np.asarray(deep, np.float32)))
    weight = smoothstep(*_FACING, seen.facing) * inside * seen.visible
    colour: Map = np.maximum(seen.sample(shot.linear), np.float32(1e-4))
    luminance = colour @ _LUMINANCE
    if (parts.core & (weight > 0.5)).mean() < _LEAST_CORE:
        raise InputError("neither cheeks nor nose are seen: give a frontal photograph")
    shading, unevenness = estimate_shading(
        luminance, seen.normals, weight * parts.plain, parts.core
    )
    core = parts.core & (weight > 0.5)
    white = _uncast(colour, luminance, seen.normals, weight * parts.plain, parts.core)
    hidden = _hidden(np.log(white), np.log(luminance / shading), core, parts)
    weight = weight * (1 - hidden)
    even: Map = np.asarray(white / shading[..., None], np.float32)
    gain, tint = _gain(even, core)
    albedo = even * gain
    known, full = _completed(np.log(np.clip(albedo, 0.002, 1.2)), weight, core, parts)
    front = parts.plain & (parts.points[..., 2] > -40)
    return PhotographedSkin(
        np.clip(full, 0.003, 0.95).astype(np.float32),
        white + hidden[..., None] * (colour - white),
        gain,
        known,
        hidden,
        float(weight[front].mean()),
        unevenness,
        tint,
    )


def _uncast(colour: Map, luminance: Map, normals: Map, weight: Map, core: NDArray[np.bool_]) -> Map:
    """Return colours as if all light had the hue that it has on the core; luminance stays."""
    hue = np.log(colour[..., [0, 2]] / colour[..., [1]])
    small = (len(colour) // _COARSER, len(colour) // _COARSER)
    known = np.asarray(cv2.resize(weight, small, interpolation=cv2.INTER_AREA))
    logs = cv2.resize(np.log(colour) * weight[..., None], small, interpolation=cv2.INTER_AREA)
    logs = np.asarray(logs / np.maximum(known, np.float32(1e-3))[..., None], np.float32)
    smooth = extended(logs, known, _TONE_BLUR * len(logs)) @ _LUMINANCE
    tone = np.asarray(cv2.resize(smooth, weight.shape, interpolation=cv2.INTER_LINEAR))
    red, blue = np.moveaxis(estimate_cast(hue, tone, normals, weight, core), -1, 0)
    even = colour * np.exp(-np.stack([red, np.zeros_like(red), blue], axis=-1))
    return np.asarray(even * (luminance / (even @ _LUMINANCE))[..., None], np.float32)


def _gain(even: Map, core: NDArray[np.bool_]) -> tuple[Map, tuple[float, float]]:
    """Turn light into reflectance: the exposure is taken as right within skin's own limits."""
    typical = np.median(even[core], axis=0) / _KEY
    red, blue = light_colour(typical)
    white = np.exp(-np.array([red, 0.0, blue], np.float32))
    white /= (typical * white) @ _LUMINANCE / (typical @ _LUMINANCE)
    level = float(typical @ _LUMINANCE)
    exposed = np.clip(level, *_LEVELS) / level / _KEY
    return (white * exposed).astype(np.float32), (red, blue)


def _hidden(
    log_colour: Map, log_even: Map, core: NDArray[np.bool_], parts: Zones
) -> NDArray[np.float32]:
    """Find hair, shades and frames over the skin: ``(S, S)``, [0, 1]."""
    hue = log_colour - log_colour.mean(axis=-1, keepdims=True)
    usual = np.median(hue[core], axis=0)
    spread = np.maximum(1.4826 * np.median(np.abs(hue[core] - usual), axis=0), 0.05)
    rest = log_even - np.median(log_even[core])
    odd = (np.abs((hue - usual) / spread) > _OTHER_HUE).any(axis=-1)
    odd |= (rest < _DARK) | (rest > _BRIGHT)
    odd &= ~parts.features & parts.hair
    odd = ndimage.binary_opening(odd, iterations=max(1, round(2 * len(odd) / 1024)))
    grown = ndimage.binary_dilation(odd, iterations=max(1, round(_GROWN * len(odd))))
    soft = cv2.GaussianBlur(grown.astype(np.float32), (0, 0), max(0.5, _GROWN * len(odd) / 2))
    return np.asarray(soft, np.float32)


def _completed(
    log_albedo: Map, weight: Map, core: NDArray[np.bool_], parts: Zones
) -> tuple[Map, Map]:
    """Fill what is hidden; return how much is known, and the whole albedo."""
    size = len(weight)
    plain_skin = np.clip(plain_maps(size).albedo, 0.002, 1.0)
    ratio = log_albedo - np.log(plain_skin)
    mirrored = np.ascontiguousarray(ratio[:, ::-1])
    other = np.ascontiguousarray(weight[:, ::-1])
    both = (weight > 0.5) & (other > 0.5) & parts.plain
    if both.any():
        mirrored = mirrored + np.median((ratio - mirrored)[both], axis=0)
    aside = smoothstep(*_MIDDLE_MM, np.abs(parts.points[..., 0]))
    lent = _MIRRORED * other * (1 - weight) * aside
    total = np.maximum(weight + lent, 1e-3)[..., None]
    ratio = (ratio * weight[..., None] + mirrored * lent[..., None]) / total
    known = np.minimum(weight + lent, 1.0).astype(np.float32)
    sure = (known * (parts.plain & (known > 0.3))).astype(np.float32)
    beyond = extended(ratio, sure, blur=6 * size / 1024)
    typical = np.median(ratio[core & (known > 0.5)], axis=0)
    outside = ndimage.distance_transform_edt(known < 0.5).astype(np.float32)
    far = smoothstep(0.0, _FADES * size, outside)[..., None]
    beyond = beyond * (1 - far) + typical * far
    full = ratio * known[..., None] + beyond * (1 - known[..., None])
    return known, plain_skin * np.exp(full)


def extended(values: Map, weight: Map, blur: float) -> Map:
    """Extend a map from where its weight is to everywhere, ever smoother (push-pull).

    Args:
        values: ``(S, S, 3)``.
        weight: ``(S, S)``, [0, 1].
        blur: Standard deviation of a first blur, texels.
    """
    blur = max(blur, 0.5)
    held = np.asarray(cv2.GaussianBlur(weight, (0, 0), blur), np.float32)
    summed = np.asarray(cv2.GaussianBlur(values * weight[..., None], (0, 0), blur), np.float32)
    mean = summed / np.maximum(held, 1e-3)[..., None]
    held = (held > 0.3).astype(np.float32)
    pushed, weights = [mean * held[..., None]], [held]
    while max(weights[-1].shape) > 1:
        half = (max(1, weights[-1].shape[1] // 2), max(1, weights[-1].shape[0] // 2))
        pushed.append(np.asarray(cv2.resize(pushed[-1], half, interpolation=cv2.INTER_AREA)))
        weights.append(np.asarray(cv2.resize(weights[-1], half, interpolation=cv2.INTER_AREA)))
    pulled = pushed[-1] / np.maximum(weights[-1][..., None], 1e-6)
    for level, (value, share) in enumerate(zip(pushed[-2::-1], weights[-2::-1], strict=True)):
        size = share.shape[::-1]
        up = np.asarray(cv2.resize(pulled, size, interpolation=cv2.INTER_LINEAR))
        finest = level == len(pushed) - 2
        own = np.clip(share * (1 if finest else 4), 0, 1)[..., None]
        pulled = own * value / np.maximum(share[..., None], 1e-6) + (1 - own) * up
    return np.asarray(pulled, np.float32)


@lru_cache(maxsize=2)
def plain_maps(size: int) -> SkinMaps:
    """Return the skin of nobody in particular, which hidden texels get; read-only."""
    maps = paint_plain_skin(size)
    for shared in maps:
        shared.setflags(write=False)
    return maps
