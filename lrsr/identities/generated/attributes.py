"""How is a face held, what does it do, and whence comes its light? Measured on its picture.

The landmark network, the fit and the light of :mod:`lrsr.identities.photographs`, without the
texture that a head needs: a fraction of a second.
"""

import numpy as np
from numpy.typing import NDArray

from lrsr.identities.face.resting import acting_skin, place_face
from lrsr.identities.photographs.light import estimate_shading
from lrsr.identities.photographs.picture_file import Photograph
from lrsr.identities.photographs.reconstructor import shared_reconstructor
from lrsr.identities.photographs.shot import Depths, Mesh, Texels, take_shot
from lrsr.identities.photographs.zones import zones
from lrsr.identities.shape.basis import load_basis
from lrsr.identities.shape.position_map import cover

ATTRIBUTES = ("yaw_deg", "pitch_deg", "smile", "jaw_open", "light_across", "light_above")
"""Yaw and pitch as :class:`lrsr.rendering.pose.Pose`; strength of face units, [0, 1]; logarithm of
the light on skin that faces the subject's left over that on the right, and of up over down."""
_TEXELS = 64
_FACING = (0.3, 0.1)
"""Least cosine to the camera of skin that light is read from; least share of plain skin so seen."""
_LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


class AttributeMeter:
    """Measures :data:`ATTRIBUTES` with the landmark network that ships."""

    def __init__(self) -> None:
        surface = load_basis().surface
        self._raster = cover(surface.uv, surface.faces, _TEXELS)

    def __call__(self, photograph: Photograph) -> dict[str, float]:
        """Measure a face; of light there is NaN where too little skin is seen."""
        found = shared_reconstructor()(photograph.srgb, photograph.five_px)
        fit = found.fit
        face = place_face(fit.rest)
        seen = fit.perspective.moved_axes(face.rotation, face.origin)
        shot = take_shot(photograph.srgb, seen, found.points_px, face.eyes.pupils)
        surface = load_basis().surface
        mesh = Mesh(acting_skin(face, fit.acting), surface.faces, surface.uv)
        # without a map of depths: what is plain and faces the camera is hidden by little
        nowhere = Depths(np.full((2, 2), -1e3, np.float32), np.zeros(2), 1.0)
        texels = shot.texels(mesh, _TEXELS, nowhere, self._raster)
        across, above = _imbalances(texels, texels.sample(shot.linear))
        yaw, pitch, _ = seen.angles_deg
        smile = (fit.units["mouthSmileLeft"] + fit.units["mouthSmileRight"]) / 2
        values = (yaw, pitch, smile, fit.units["jawOpen"], across, above)
        return dict(zip(ATTRIBUTES, values, strict=True))


def _imbalances(seen: Texels, linear: NDArray[np.float32]) -> tuple[float, float]:
    """Return how uneven light is from side to side and from above to below, by the fitted light."""
    parts = zones(len(linear))
    weight = (parts.plain & seen.visible & (seen.facing > _FACING[0])).astype(np.float32)
    if weight[parts.core].mean() < _FACING[1]:
        return np.nan, np.nan
    luminance = np.maximum(linear @ _LUMINANCE, np.float32(1e-4))
    shading, _ = estimate_shading(luminance, seen.normals, weight, parts.core)
    light, normals = shading[parts.plain], seen.normals[parts.plain]
    sides = (np.maximum(sign * normals[:, axis], 0) for axis in (0, 1) for sign in (1, -1))
    left, right, up, down = (float(light @ side / side.sum()) for side in sides)
    return float(np.log(left / right)), float(np.log(up / down))
