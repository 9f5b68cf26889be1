"""A path tracer whose skin is translucent: light leaves it elsewhere than it entered.

The separable BSSRDF of the PBRT book (Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd
edition, sections 11.4 and 15.4), which Mitsuba lacks:

    S(po, wo, pi, wi) = (1 - E(cos o)) A(po) R(|po - pi|) (1 - E(cos i)) / (c π),
    c = 1 - 2 ∫ E(µ) µ dµ,

with the diffusion profile R of :mod:`lrsr.rendering.diffusion` and, where others write the Fresnel
term of a smooth boundary, the directional albedo E of the rough lobe that reflects above it
(:mod:`lrsr.rendering.reflection`). A = ρ / c for the albedo texture ρ, so that ρ is what the skin
sends back by way of its inside, of uniform light.

Exit points are found as King et al. 2013 do ("BSSRDF importance sampling"): a line through a disc
around po, along its normal or a tangent, at a distance drawn from one channel's profile. All hits
within the reach are weighted, by the balance heuristic over channels and the power heuristic over
axes, and one is kept.

A profile measured on a plane is too dark where skin curves: in red by 2.4 % on a sphere of 100 mm,
by 11 % on one of 20 mm (uniform light, skin1, against ``volpath``). With the curvature between
entry and exit, :func:`~lrsr.rendering.diffusion.curved_gain` leaves 0.3 % and 1 %. It does not mend
thickness: a disc of 4 mm with the light behind it sends 68 % too little red, 86 % too little green
and 97 % too little blue. ``docs/skin.md`` has the pictures and the numbers.

All lengths are millimetres: with metres, Mitsuba's rays would start a tenth of a millimetre off
the surface and tangential probes would miss it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

from lrsr.rendering.backend import start
from lrsr.rendering.diffusion import curved_gain, scattering_albedo
from lrsr.rendering.probing import Profile, find_exit, jitted
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


def subsurface_integrator(
    skin: Skin,
    surfaces: Sequence[SkinSurface],
    *,
    max_depth: int = 5,
    roulette_depth: int = 2,
    sampling: Sampling | None = None,
) -> Any:
    """Make the integrator for one scene, in whichever variant is set.

    Args:
        skin: Coefficients.
        surfaces: The meshes of skin; everything else keeps its own BSDF.
        max_depth: Longest path, in edges from the camera; the way under the skin is no edge.
        roulette_depth: From which bounce on dim paths may end by chance.
        sampling: How exit points are sampled.

    Returns:
        ``mi.SamplingIntegrator``.
    """
    own = _integrator_class(start().variant())
    return own(skin, tuple(surfaces), max_depth, roulette_depth, sampling or Sampling())


@cache
def _integrator_class(variant: str) -> type:
    """Make the class for a variant of Mitsuba, whose base class has one of its own."""
    mi = start()

    class SubsurfacePath(mi.SamplingIntegrator):  # type: ignore[name-defined,misc]  # untyped
        def __init__(
            self,
            skin: Skin,
            surfaces: tuple[SkinSurface, ...],
            max_depth: int,
            roulette_depth: int,
            sampling: Sampling,
        ) -> None:
            super().__init__(mi.Properties())
            self.surfaces = surfaces
            self.tracer = _Tracer(skin, surfaces, max_depth, roulette_depth, sampling)

        def sample(
            self,
            scene: Any,
            sampler: Any,
            ray: Any,
            medium: Any = None,
            active: Any = True,
        ) -> tuple[Any, Any, list[Any]]:
            light, valid = jitted(_trace)(self.tracer, scene, sampler, ray, active)
            return light, valid, []

    SubsurfacePath.__qualname__ = f"SubsurfacePath[{variant}]"
    return SubsurfacePath


class _Tracer:
    """What the kernel needs to know of skin; all numbers opaque, so that no value recompiles."""

    def __init__(
        self,
        skin: Skin,
        surfaces: tuple[SkinSurface, ...],
        max_depth: int,
        roulette_depth: int,
        sampling: Sampling,
    ) -> None:
        import drjit as dr

        mi = start()
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
        import drjit as dr

        mi = start()
        skin, normal = mi.Bool(False), mi.Normal3f(0, 0, 1)
        for pointer, surface in zip(self.pointers, self.surfaces, strict=True):
            here = active & (hit.shape == pointer)
            of_face = mi.Normal3f(surface.mesh.face_normal(hit.prim_index, here))
            skin, normal = skin | here, dr.select(here, of_face, normal)
        return skin, normal

    def is_skin(self, si: Any) -> Any:
        mi = start()
        skin = mi.Bool(False)
        for pointer in self.pointers:
            skin |= si.shape == pointer
        return skin

    def look_up(self, si: Any, active: Any) -> tuple[Any, Any]:
        """Return the albedo and the roughness of skin."""
        import drjit as dr

        mi = start()
        albedo, roughness = mi.Spectrum(0.5), mi.Float(0.5)
        for pointer, surface in zip(self.pointers, self.surfaces, strict=True):
            here = active & (si.shape == pointer)
            albedo = dr.select(here, mi.Spectrum(surface.albedo.eval(si, here)), albedo)
            roughness = dr.select(here, surface.roughness.eval_1(si, here), roughness)
        return albedo, roughness

    def normal(self, si: Any, active: Any) -> Any:
        """Return the shading normal with the relief on it."""
        import drjit as dr

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
    import drjit as dr

    mi = start()
    if not mi.is_spectral:
        return mi.Spectrum(*channels) if len(mi.Spectrum()) == 3 else mi.Spectrum(channels[1])
    red, green, blue = CHANNEL_NM
    low = dr.clip((wavelengths - blue) / (green - blue), 0, 1)
    high = dr.clip((wavelengths - green) / (red - green), 0, 1)
    below = dr.lerp(mi.Spectrum(channels[2]), channels[1], low)
    return mi.Spectrum(dr.lerp(below, channels[0], high))


def _bumped(si: Any, height: Any, active: Any) -> Any:
    """Tilt the normal as Mitsuba's ``bumpmap`` does."""
    import drjit as dr

    mi = start()
    normal = si.sh_frame.n
    slope = height.eval_1_grad(si, active)
    along_u = si.dp_du + normal * (slope.x - dr.dot(normal, si.dp_du))
    along_v = si.dp_dv + normal * (slope.y - dr.dot(normal, si.dp_dv))
    tilted = dr.normalize(dr.cross(along_u, along_v))
    return mi.Normal3f(dr.mulsign(tilted, dr.dot(si.n, tilted)))


def _curvature(here: Any, there: Any, side: Any) -> Any:
    """Return one over the radius of the circle through two points with their normals, mm⁻¹."""
    import drjit as dr

    offset = there.p - here.p
    turned = side * dr.dot(there.sh_frame.n - here.sh_frame.n, offset)
    return turned / (dr.squared_norm(offset) + 1e-2)  # nearer than 0.1 mm it is noise


def _mis(density: Any, other: Any) -> Any:
    """Return the power heuristic."""
    import drjit as dr

    square = dr.square(density)
    weight = square / dr.fma(other, other, square)
    return dr.select(dr.isfinite(weight), weight, 0)


def _trace(tracer: _Tracer, scene: Any, sampler: Any, ray: Any, active: Any) -> tuple[Any, Any]:
    """Follow paths from the camera; the loop is Mitsuba's ``path``, its skin is ours."""
    import drjit as dr

    mi = start()
    context = mi.BSDFContext()
    ray, active = mi.Ray3f(ray), mi.Bool(active)
    si = scene.ray_intersect(ray, mi.RayFlags.All, True, active)
    valid = si.is_valid()
    light, throughput = si.emitter(scene).eval(si, active), mi.Spectrum(1)
    depth, squared_index = mi.UInt32(1), mi.Float(1)
    active = active & valid & (depth < tracer.max_depth)
    # What misses everything never comes here, and so costs none of what follows.
    while dr.hint(active, label="subsurface path"):
        skin = active & tracer.is_skin(si)
        vertex = _Vertex(tracer, scene, sampler, si, ray, skin)

        # What the surface of skin reflects of a light is seen from where the path arrived...
        seen, radiance = scene.sample_emitter_direction(si, sampler.next_2d(), True, skin)
        value, chance = vertex.reflect(seen.d)
        share = dr.select(seen.delta, 1, _mis(seen.pdf, chance))
        light[skin & (seen.pdf != 0)] += throughput * value * radiance * share

        # ... and what leaves its inside, or any other surface, from where the path goes on.
        bsdf = si.bsdf()
        plain = active & ~skin
        lit = (skin & vertex.enters) | (plain & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth))
        seen, radiance = scene.sample_emitter_direction(
            vertex.interaction, sampler.next_2d(), True, lit
        )
        value, chance, sample, weight = bsdf.eval_pdf_sample(
            context, si, si.to_local(seen.d), sampler.next_1d(), sampler.next_2d(), plain
        )
        own_value, own_chance = vertex.enter(seen.d)
        value = dr.select(skin, own_value, value)
        chance = dr.select(skin, own_chance, chance)
        share = dr.select(seen.delta, 1, _mis(seen.pdf, chance))
        light[lit & (seen.pdf != 0)] += throughput * value * radiance * share

        direction, density, own_weight, mirrors = vertex.sample(
            sampler.next_1d(), sampler.next_2d()
        )
        direction = dr.select(skin, direction, si.to_world(sample.wo))
        density = dr.select(skin, density, sample.pdf)
        throughput *= dr.select(skin, own_weight, weight)
        squared_index *= dr.select(skin, 1, dr.square(sample.eta))
        delta = ~skin & mi.has_flag(sample.sampled_type, mi.BSDFFlags.Delta)
        brightest = dr.max(throughput)
        survival = dr.minimum(brightest * squared_index, 0.95)
        dim = depth > tracer.roulette_depth
        throughput[dim] *= dr.rcp(survival)
        active &= (brightest != 0) & (~dim | (sampler.next_1d() < survival))

        before = dr.select(mirrors, mi.Interaction3f(si), vertex.interaction)
        ray = before.spawn_ray(direction)
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, active)
        depth += 1
        seen = mi.DirectionSample3f(scene, si, before)
        chance = scene.pdf_emitter_direction(before, seen, active & ~delta)
        emitted = seen.emitter.eval(si, active) * dr.select(delta, 1, _mis(density, chance))
        light[active] += throughput * emitted
        active &= si.is_valid() & (depth < tracer.max_depth)
    return light, valid


class _Vertex:
    """What happens at a point of skin: light is reflected there, and enters at another point.

    Both are lit at every vertex; the path goes on by one of them.

    Attributes:
        interaction: Where light enters; off skin, the point itself.
        enters: Whether there is such a point.
    """

    def __init__(
        self, tracer: _Tracer, scene: Any, sampler: Any, si: Any, ray: Any, skin: Any
    ) -> None:
        import drjit as dr

        mi = start()
        self._reflection = tracer.reflection
        self._skin = skin
        albedo, self._roughness = tracer.look_up(si, skin)
        side = dr.mulsign(mi.Float(1), -dr.dot(si.n, ray.d))  # both sides of a sheet are skin
        self._here = mi.Frame3f(side * tracer.normal(si, skin))
        self._view = self._here.to_local(-ray.d)
        reflected = self._reflection.directional(self._view.z, self._roughness)
        self._entering = 1 - self._reflection.mean(self._roughness)
        albedo = dr.clip(albedo / self._entering, 0, 1)
        least = tracer.least_lobe_share
        scattered = (1 - reflected) * dr.mean(albedo)
        share = dr.clip(reflected / (reflected + scattered), least, 1 - least)
        self._share = dr.select(self._view.z > 0, share, 0)

        profile = tracer.profile(albedo, si.wavelengths)
        exit_ = find_exit(
            scene,
            sampler,
            si,
            side * si.sh_frame.n,
            profile,
            tracer.find,
            tracer.normal_share,
            skin,
        )
        bend = _curvature(si, exit_.interaction, side)
        gain = curved_gain(albedo, bend * profile.mean_free_path_mm)
        self._through = exit_.weight * albedo * gain * (1 - reflected)
        self.enters = dr.any(self._through != 0)
        self.interaction = dr.select(
            skin & self.enters, mi.Interaction3f(exit_.interaction), mi.Interaction3f(si)
        )
        self._there = mi.Frame3f(side * tracer.normal(exit_.interaction, skin & self.enters))

    def reflect(self, direction: Any) -> tuple[Any, Any]:
        """Return the lobe times cos θ for light from there, and the density of drawing it."""
        light = self._here.to_local(direction)
        value, density = self._reflection.eval_pdf(self._view, light, self._roughness)
        return value, self._share * density

    def enter(self, direction: Any) -> tuple[Any, Any]:
        """Return what of that light enters and comes back, and the density of drawing it."""
        import drjit as dr

        cosine = dr.maximum(dr.dot(self._there.n, direction), 0)
        value = self._through * (self._entered(cosine) * cosine * dr.inv_pi)
        return value, (1 - self._share) * cosine * dr.inv_pi

    def sample(self, choice: Any, uniform: Any) -> tuple[Any, Any, Any, Any]:
        """Draw how the path goes on.

        Args:
            choice: Of the two ways, [0, 1).
            uniform: Two numbers in [0, 1).

        Returns:
            The direction, its density, value over density, and whether skin reflected it.
        """
        import drjit as dr

        mi = start()
        mirrors = self._skin & (choice < self._share)
        out, lobe_density, lobe = self._reflection.sample(self._view, self._roughness, uniform)
        into = mi.warp.square_to_cosine_hemisphere(uniform)
        other = 1 - self._share
        density = dr.select(mirrors, self._share * lobe_density, other * into.z * dr.inv_pi)
        through = self._through * (self._entered(into.z) / other)
        weight = dr.select(mirrors, mi.Spectrum(lobe / self._share), through)
        direction = dr.select(mirrors, self._here.to_world(out), self._there.to_world(into))
        return direction, density, weight, mirrors

    def _entered(self, cosine: Any) -> Any:
        return (1 - self._reflection.directional(cosine, self._roughness)) / self._entering
