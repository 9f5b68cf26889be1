"""How does light come through thin panes, such as glasses? Straight on, less what they mirror.

A path passes a pane by chance, as often as light does, and does not notice: what it met before
stays its last vertex, so lights behind the pane are weighed as ever. What does not pass is
mirrored.
"""

from typing import Any

from lrsr.rendering.backend import dr, mi

_MOST = 3
"""Panes in a row that are passed."""


def is_pane(si: Any, active: Any) -> Any:
    """Tell which lanes have met a pane."""
    return active & si.is_valid() & mi.has_flag(si.bsdf().flags(), mi.BSDFFlags.Null)


def pass_panes(scene: Any, sampler: Any, ray: Any, si: Any, active: Any) -> Any:
    """Return what rays meet that pass panes by chance, where ``si`` is what they met first."""
    for _ in range(_MOST):
        pane = is_pane(si, active)
        through = dr.mean(si.bsdf().eval_null_transmission(si, pane))
        passes = pane & (sampler.next_1d() < through)
        beyond = scene.ray_intersect(si.spawn_ray(ray.d), mi.RayFlags.All, False, passes)
        si, active = dr.select(passes, beyond, si), passes
    return si


def sample_light(scene: Any, start: Any, uniform: Any, active: Any) -> tuple[Any, Any]:
    """Draw a light as ``sample_emitter_direction`` does, which may stand behind panes."""
    seen, radiance = scene.sample_emitter_direction(start, uniform, False, active)
    ray, looking = start.spawn_ray_to(seen.p), mi.Bool(active)
    clear = mi.Spectrum(1)
    for _ in range(_MOST):
        si = scene.ray_intersect(ray, mi.RayFlags.All, False, looking)
        pane = is_pane(si, looking)
        through = dr.select(pane, si.bsdf().eval_null_transmission(si, pane), 0)
        clear *= dr.select(looking & si.is_valid(), through, 1)
        ray, looking = si.spawn_ray_to(seen.p), pane
    return seen, radiance * clear
