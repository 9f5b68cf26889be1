"""What does a photograph become? Itself, the fitted mesh over it, and the head in other light."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from numpy.typing import NDArray

from lrsr.camera import Camera
from lrsr.experiments.report.sheets import draw_portraits
from lrsr.identities.photographs.person import Photographed
from lrsr.identities.photographs.reconstruct import Reconstruction
from lrsr.identities.shape.basis import load_basis
from lrsr.pictures.cache import RenderCache
from lrsr.pictures.maker import Maker
from lrsr.pictures.recipe import Recipe
from lrsr.pictures.render import take_pictures
from lrsr.presets import preset
from lrsr.rendering.pose import FRONTAL, Pose
from lrsr.rendering.scene import Film, Quality, Scene

_TILE_IPD_PX, _SMALL_IPD_PX = 48.0, 8.0
_QUALITY = Quality(samples_per_pixel=64)
_TURNED = Pose("turned", yaw_deg=30.0)
_VIEWS = (
    (FRONTAL, "frontal", _TILE_IPD_PX, "frontal"),
    (_TURNED, "frontal", _TILE_IPD_PX, "30 degrees"),
    (FRONTAL, "side", _TILE_IPD_PX, "side light"),
    (FRONTAL, "frontal", _SMALL_IPD_PX, "8 px"),
)
"""Pose, light, distance of the pupils and caption."""
_LETTERS = 26  # that fit under a tile


def draw_reconstruction(
    person: Photographed,
    srgb: NDArray[np.float32],
    made: Reconstruction,
    cache: RenderCache,
    *,
    maker: Maker | None = None,
) -> bytes:
    """Draw a row of a contact sheet; what the cache lacks of its pictures is rendered.

    Args:
        person: Who.
        srgb: ``(H, W, 3)`` srgb, [0, 1]: the part of the photograph that was fitted.
        made: Of that part.
        cache: Where renderings are kept.
        maker: Renders; Mitsuba when None.

    Returns:
        A PNG.

    Raises:
        InputError: The cache cannot be written.
    """
    recipes = [
        Recipe(person, Scene(preset("lighting", light), pose), Film(ipd_px), _QUALITY).seeded(
            0, "probe"
        )
        for pose, light, ipd_px, _ in _VIEWS
    ]
    pictures = list(take_pictures(recipes, cache, Camera(), progress=False, maker=maker))
    side = pictures[0].image.shape[-1]
    tiles = [*_photographed(srgb, made, side)]
    for picture in pictures:
        image = picture.image[None]
        tiles.append(torch.nn.functional.interpolate(image, size=(side, side))[0].numpy())
    measured, name = made.quality, Path(person.file).name
    yaw_deg, pitch_deg = round(measured.yaw_deg), round(measured.pitch_deg)
    captions = [
        name if len(name) <= _LETTERS else f"{name[: _LETTERS - 3]}...",
        f"yaw {yaw_deg}, pitch {pitch_deg}, {measured.ipd_px:.0f} px",
        *(title for *_, title in _VIEWS),
    ]
    return draw_portraits(tiles, captions, columns=len(tiles))


def _photographed(
    srgb: NDArray[np.float32], made: Reconstruction, size: int
) -> Iterator[NDArray[np.float32]]:
    """Yield the photograph as large as the renderings, and the same with the fitted mesh."""
    seen = made.fit.perspective.moved_axes(made.face.rotation, made.face.origin)
    left, right = seen.project(made.face.eyes.pupils)[0]
    scale = float(np.hypot(*(right - left))) / _TILE_IPD_PX
    middle = (left + right) / 2 + [0, 0.2 * scale * _TILE_IPD_PX]  # as the reference camera frames
    corner = middle - scale * (size - 1) / 2
    matrix = np.array([[scale, 0, corner[0]], [0, scale, corner[1]]])
    smooth = cv2.GaussianBlur(srgb, (0, 0), 0.45 * scale) if scale > 1.4 else srgb
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    tile = np.clip(cv2.warpAffine(smooth, matrix, (size, size), flags=flags), 0, 1)
    yield tile.transpose(2, 0, 1)
    drawn = tile.copy()
    places = ((seen.project(made.coarse())[0] - corner) / scale).round(2)
    for a, b in _wires():
        start, end = (tuple(int(v) for v in 16 * places[k]) for k in (a, b))
        cv2.line(drawn, start, end, (0.1, 1.0, 0.4), 1, cv2.LINE_AA, shift=4)
    yield (0.5 * tile + 0.5 * drawn).transpose(2, 0, 1)


def _wires() -> NDArray[np.int64]:
    """Return the sides of the quads on the front of the coarse head ``(n, 2)``."""
    basis = load_basis()
    quads = basis.quads[basis.region == 0]
    base = basis.shape(basis.neutral)
    points = base.skin - base.eyes.mean(axis=(0, 1))
    front = (points[quads, 2] > -40).all(axis=1) & (points[quads, 1] > -115).all(axis=1)
    quads = quads[front]
    sides = np.concatenate([quads[:, [0, 1]], quads[:, [1, 2]], quads[:, [2, 3]], quads[:, [3, 0]]])
    return np.unique(np.sort(sides, axis=1), axis=0).astype(np.int64)
