"""A path tracer whose skin is translucent: light leaves it elsewhere than it entered.

The separable BSSRDF of the PBRT book (Pharr, Jakob and Humphreys, "Physically Based Rendering", 3rd
edition, sections 11.4 and 15.4), which Mitsuba lacks::

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
from functools import cache
from typing import Any

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.exit_points import jitted
from lrsr.rendering.painted_skin import PaintedSkin, Sampling, SkinSurface
from lrsr.rendering.panes import is_pane, pass_panes, sample_light
from lrsr.rendering.skin import Skin
from lrsr.rendering.skin_vertex import SkinVertex


def subsurface_integrator(
    skin: Skin,
    surfaces: Sequence[SkinSurface],
    max_depth: int = 5,
    roulette_depth: int = 2,
    sampling: Sampling | None = None,
    *,
    glazed: bool = False,
) -> Any:
    """Make the integrator for one scene, in whichever variant is set.

    Args:
        skin: Coefficients.
        surfaces: The meshes of skin; everything else keeps its own BSDF.
        max_depth: Longest path, in edges from the camera; the way under the skin is no edge.
        roulette_depth: From which bounce on dim paths may end by chance.
        sampling: How exit points are sampled.
        glazed: There are panes that lights shine through.

    Returns:
        ``mi.SamplingIntegrator``.
    """
    depths = (max_depth, roulette_depth)
    tracer = PaintedSkin(skin, tuple(surfaces), *depths, sampling or Sampling())
    return _integrator_class(mi.variant())(tracer, glazed)


@cache
def _integrator_class(variant: str) -> type:
    """Make the class for a variant of Mitsuba, whose base class has one of its own."""

    class SubsurfacePath(mi.SamplingIntegrator):  # type: ignore[misc]  # untyped
        def __init__(self, tracer: PaintedSkin, glazed: bool) -> None:
            super().__init__(mi.Properties())
            self.tracer = tracer
            self.glazed = glazed

        def sample(
            self, scene: Any, sampler: Any, ray: Any, medium: Any = None, active: Any = True
        ) -> tuple[Any, Any, list[Any]]:
            light, valid = jitted(_trace)(self.tracer, scene, sampler, ray, active, self.glazed)
            return light, valid, []

    SubsurfacePath.__qualname__ = f"SubsurfacePath[{variant}]"
    return SubsurfacePath


def _mis(density: Any, other: Any) -> Any:
    """Return the power heuristic."""
    square = dr.square(density)
    weight = square / dr.fma(other, other, square)
    return dr.select(dr.isfinite(weight), weight, 0)


def _sample_light(
    scene: Any, start: Any, uniform: Any, active: Any, glazed: bool
) -> tuple[Any, Any]:
    if glazed:
        return sample_light(scene, start, uniform, active)
    seen, radiance = scene.sample_emitter_direction(start, uniform, True, active)
    return seen, radiance


def _trace(
    tracer: PaintedSkin, scene: Any, sampler: Any, ray: Any, active: Any, glazed: bool
) -> tuple[Any, Any]:
    """Follow paths from the camera; the loop is Mitsuba's ``path``, its skin is ours."""
    context = mi.BSDFContext()
    ray, active = mi.Ray3f(ray), mi.Bool(active)
    si = scene.ray_intersect(ray, mi.RayFlags.All, True, active)
    si = pass_panes(scene, sampler, ray, si, active) if glazed else si
    valid = si.is_valid()
    light, throughput = si.emitter(scene).eval(si, active), mi.Spectrum(1)
    depth, squared_index = mi.UInt32(1), mi.Float(1)
    active = active & valid & (depth < tracer.max_depth)
    # What misses everything never comes here, and so costs none of what follows.
    while dr.hint(active, label="subsurface path"):
        skin = active & tracer.is_skin(si)
        vertex = SkinVertex(tracer, scene, sampler, si, ray, skin)

        # What the surface of skin reflects of a light is seen from where the path arrived...
        seen, radiance = _sample_light(scene, si, sampler.next_2d(), skin, glazed)
        value, chance = vertex.reflect(seen.d)
        share = dr.select(seen.delta, 1, _mis(seen.pdf, chance))
        light[skin & (seen.pdf != 0)] += throughput * value * radiance * share

        # ... and what leaves its inside, or any other surface, from where the path goes on.
        bsdf = si.bsdf()
        plain = active & ~skin
        lit = (skin & vertex.enters) | (plain & mi.has_flag(bsdf.flags(), mi.BSDFFlags.Smooth))
        seen, radiance = _sample_light(scene, vertex.interaction, sampler.next_2d(), lit, glazed)
        lobe = sampler.next_1d()  # what has not passed a pane, it mirrors
        lobe = dr.select(is_pane(si, plain), 0, lobe) if glazed else lobe
        value, chance, sample, weight = bsdf.eval_pdf_sample(
            context, si, si.to_local(seen.d), lobe, sampler.next_2d(), plain
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
        si = pass_panes(scene, sampler, ray, si, active) if glazed else si
        depth += 1
        seen = mi.DirectionSample3f(scene, si, before)
        chance = scene.pdf_emitter_direction(before, seen, active & ~delta)
        emitted = seen.emitter.eval(si, active) * dr.select(delta, 1, _mis(density, chance))
        light[active] += throughput * emitted
        active &= si.is_valid() & (depth < tracer.max_depth)
    return light, valid
