"""What does the tracer look up where it meets skin? Albedo, roughness, normals, coefficients."""

from dataclasses import dataclass
from typing import Any

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.diffusion import scattering_albedo
from lrsr.rendering.exit_points import Profile
from lrsr.rendering.reflection import RoughReflection
from lrsr.rendering.skin import CHANNEL_NM, Skin


@dataclass(frozen=True)
class SkinSurface:
    """A mesh of skin and what is painted on it.

    Attributes:
        mesh: ``mi.Mesh`` of the scene.
        albedo: ``mi.Texture``, reflectance.
        roughness: ``mi.Texture``, √α.
        height: ``mi.Texture``, relief in mm; None: smooth.
    """

    mesh: Any
    albedo: Any
    roughness: Any
    height: Any = None


@dataclass(frozen=True)
class Sampling:
    """How exit points are sampled; no choice changes the mean.

    Attributes:
        normal_share: Of the probes along the normal; two tangents share the rest, 0..1.
        least_lobe_share: Of the paths for each of the two ways, reflection and scattering, 0..0.5.
    """

    normal_share: float = 0.9
    least_lobe_share: float = 0.1


class PaintedSkin:
    """What the kernel needs to know of skin; all numbers opaque, so that no value recompiles."""

    def __init__(
        self,
        skin: Skin,
        surfaces: tuple[SkinSurface, ...],
        max_depth: int,
        roulette_depth: int,
        sampling: Sampling,
    ) -> None:
        self.fixed = skin.fixed
        self.surfaces = surfaces
        self.pointers = [mi.ShapePtr(surface.mesh) for surface in surfaces]
        self.reflection = RoughReflection(skin.refractive_index)
        self.absorption = [dr.opaque(mi.Float, x) for x in skin.absorption_per_mm]
        self.scattering = [dr.opaque(mi.Float, x) for x in skin.scattering_per_mm]
        self.reach = dr.opaque(mi.Float, skin.reach_mm)
        self.normal_share = dr.opaque(mi.Float, sampling.normal_share)
        self.least_lobe_share = dr.opaque(mi.Float, sampling.least_lobe_share)
        self.max_depth = dr.opaque(mi.UInt32, max_depth)
        self.roulette_depth = dr.opaque(mi.UInt32, roulette_depth)

    def find(self, hit: Any, active: Any) -> tuple[Any, Any]:
        """Tell which hits are skin, and the normals of their triangles."""
        skin, normal = mi.Bool(False), mi.Normal3f(0, 0, 1)
        for pointer, surface in zip(self.pointers, self.surfaces, strict=True):
            here = active & (hit.shape == pointer)
            of_face = mi.Normal3f(surface.mesh.face_normal(hit.prim_index, here))
            skin, normal = skin | here, dr.select(here, of_face, normal)
        return skin, normal

    def is_skin(self, si: Any) -> Any:
        """Tell which lanes lie on skin."""
        skin = mi.Bool(False)
        for pointer in self.pointers:
            skin |= si.shape == pointer
        return skin

    def look_up(self, si: Any, active: Any) -> tuple[Any, Any]:
        """Return the albedo and the roughness of skin."""
        albedo, roughness = mi.Spectrum(0.5), mi.Float(0.5)
        for pointer, surface in zip(self.pointers, self.surfaces, strict=True):
            here = active & (si.shape == pointer)
            albedo = dr.select(here, mi.Spectrum(surface.albedo.eval(si, here)), albedo)
            roughness = dr.select(here, surface.roughness.eval_1(si, here), roughness)
        return albedo, roughness

    def normal(self, si: Any, active: Any) -> Any:
        """Return the shading normal with the relief on it."""
        normal = si.sh_frame.n
        for pointer, surface in zip(self.pointers, self.surfaces, strict=True):
            if surface.height is not None:
                here = active & (si.shape == pointer)
                normal = dr.select(here, _bumped(si, surface.height, here), normal)
        return normal

    def profile(self, albedo: Any, wavelengths: Any) -> Profile:
        """Return the diffusion profile of skin with that albedo of the entered light."""
        scattering = _at_wavelengths(self.scattering, wavelengths)
        if self.fixed == "scattering":
            path = scattering_albedo(albedo) / scattering
        else:
            path = 1 / (scattering + _at_wavelengths(self.absorption, wavelengths))
        return Profile(albedo, path, self.reach)


def _at_wavelengths(channels: list[Any], wavelengths: Any) -> Any:
    """Return a coefficient per channel, or where light has a spectrum, linear between those."""
    if not mi.is_spectral:
        return mi.Spectrum(*channels) if len(mi.Spectrum()) == 3 else mi.Spectrum(channels[1])
    red, green, blue = CHANNEL_NM
    low = dr.clip((wavelengths - blue) / (green - blue), 0, 1)
    high = dr.clip((wavelengths - green) / (red - green), 0, 1)
    below = dr.lerp(mi.Spectrum(channels[2]), channels[1], low)
    return mi.Spectrum(dr.lerp(below, channels[0], high))


def _bumped(si: Any, height: Any, active: Any) -> Any:
    """Tilt the normal as Mitsuba's ``bumpmap`` does."""
    normal = si.sh_frame.n
    slope = height.eval_1_grad(si, active)
    along_u = si.dp_du + normal * (slope.x - dr.dot(normal, si.dp_du))
    along_v = si.dp_dv + normal * (slope.y - dr.dot(normal, si.dp_dv))
    tilted = dr.normalize(dr.cross(along_u, along_v))
    return mi.Normal3f(dr.mulsign(tilted, dr.dot(si.n, tilted)))
