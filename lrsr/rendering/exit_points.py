"""Where did the light enter that leaves a point of skin? Probe rays along three axes tell.

King, Kulla, Conty and Fajardo 2013, "BSSRDF importance sampling", with a weighted reservoir over
the hits of a probe instead of a second draw. Lengths are millimetres.
"""

from collections.abc import Callable
from functools import cache
from typing import Any

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.diffusion import NEAR, far_width, near_weight

_MOST_HITS = 4
"""A probe that meets skin more often within its reach forgets the rest."""

_MOST_STEPS = 16
"""Hits of anything, strands of hair included, after which a probe ends."""

_STEP_MM = 1e-3
"""A probe goes on so far behind a hit: more than rounding errors, less than any two skins apart."""

_FACING = 0.5
"""Points that both see the other steeper above their skin than this sine lie across a gap..."""

_FACING_OPPOSED = 0.05
"""... or than this, where their normals point against each other, as those of lips and lids do."""

_REACH_WIDTHS = 14.0
"""Where a profile ends, in its largest width: beyond is a millionth of the light."""

Find = Callable[[Any, Any], tuple[Any, Any]]
"""From a preliminary intersection and a mask: which hits are skin, and their outward normals."""


class Profile:
    """The diffusion profile of every lane, cut at a common reach and scaled up.

    Args:
        albedo: Diffuse albedo A of the channels, ``mi.Spectrum``, [0, 1].
        mean_free_path_mm: Of the channels.
        reach_mm: Farthest distance of an exit point.
    """

    def __init__(self, albedo: Any, mean_free_path_mm: Any, reach_mm: Any) -> None:
        self.mean_free_path_mm = mean_free_path_mm
        self.near, self.far = NEAR * mean_free_path_mm, far_width(albedo) * mean_free_path_mm
        self.reach = dr.minimum(reach_mm, _REACH_WIDTHS * dr.max(self.far))
        weight = near_weight(albedo)
        kept_near = weight * (1 - dr.exp(-self.reach / self.near))
        kept_far = (1 - weight) * (1 - dr.exp(-self.reach / self.far))
        kept = kept_near + kept_far
        self.near_share = kept_near / kept
        self._near_height = dr.inv_two_pi * weight / (kept * self.near)
        self._far_height = dr.inv_two_pi * (1 - weight) / (kept * self.far)

    def at(self, distance: Any) -> Any:
        """Return R of the channels, mm⁻²."""
        distance = dr.maximum(distance, 1e-4)
        near = self._near_height * dr.exp(-distance / self.near)
        far = self._far_height * dr.exp(-distance / self.far)
        return (near + far) / distance

    def draw_distance(self, uniform: Any) -> Any:
        """Draw a distance from the mean of the channels' profiles, each cut at the reach.

        One number picks channel, exponential and distance: where it is stratified, so are all.

        Args:
            uniform: [0, 1).
        """
        channels = len(self.near)
        scaled = uniform * channels
        width, inside = dr.zeros(type(uniform)), dr.zeros(type(uniform))
        for channel in range(channels):
            share = self.near_share[channel]
            # To and fro, so that the distance has no jumps: neighbours in strata are neighbours.
            rest = 1 - (scaled - channel) if channel % 2 else scaled - channel
            near = rest < share
            depth = dr.select(near, 1 - rest / share, (rest - share) / (1 - share))
            own = dr.select(near, self.near[channel], self.far[channel])
            here = scaled >= channel
            width, inside = dr.select(here, own, width), dr.select(here, depth, inside)
        inside = dr.clip(inside, 0, 1)
        return -width * dr.log(1 - inside * (1 - dr.exp(-self.reach / width)))


def find_exit(
    scene: Any,
    sampler: Any,
    origin: Any,
    normal: Any,
    profile: Profile,
    find: Find,
    normal_share: Any,
    active: Any,
) -> tuple[Any, Any]:
    """Draw one exit point.

    Args:
        scene: ``mi.Scene``.
        sampler: Gives three numbers.
        origin: ``mi.SurfaceInteraction3f`` at po.
        normal: Of the skin at po, towards the viewer.
        profile: Of every lane.
        find: Says which hits are skin.
        normal_share: Of the probes along the normal.
        active: Which lanes.

    Returns:
        interaction: ``mi.SurfaceInteraction3f``, where light entered.
        weight: Estimate of ∫ S dA over the density, per channel; 0: nothing was hit.
    """
    frame = mi.Frame3f(normal)
    tangent_share = (1 - normal_share) / 2
    uniform, pick, turn = sampler.next_1d(), sampler.next_1d(), sampler.next_1d()
    along_n, along_s = uniform < normal_share, uniform < normal_share + tangent_share
    begin = dr.select(along_n, 0, dr.select(along_s, normal_share, normal_share + tangent_share))
    inside = (uniform - begin) / dr.select(along_n, normal_share, tangent_share)
    axis = dr.select(along_n, frame.n, dr.select(along_s, frame.s, frame.t))
    first = dr.select(along_n, frame.s, dr.select(along_s, frame.t, frame.n))
    second = dr.select(along_n, frame.t, dr.select(along_s, frame.n, frame.s))
    distance = profile.draw_distance(inside)
    sine, cosine = dr.sincos(dr.two_pi * turn)
    half = dr.sqrt(dr.maximum(dr.square(profile.reach) - dr.square(distance), 0))
    begin = origin.p + distance * (cosine * first + sine * second) + half * axis
    ray = mi.Ray3f(begin, -axis, dr.largest(mi.Float), origin.time, origin.wavelengths)

    def weigh(point: Any, facing: Any) -> Any:
        offset = point - origin.p
        densities = _densities(frame, profile, offset, facing, normal_share)
        own = dr.select(along_n, densities[0], dr.select(along_s, densities[1], densities[2]))
        # The power heuristic over axes: a tangent that finds a flat surface is not counted on.
        squares = sum(dr.square(density) for density in densities)
        wanted = dr.mean(profile.at(dr.norm(offset)))
        seen = _inside(offset, normal, facing) & (dr.norm(offset) < profile.reach)
        return dr.select(seen & (own > 0), wanted * own / squares, 0)

    chosen, total = jitted(_reservoir)(scene, ray, 2 * half, pick, find, weigh, active)
    found = active & (total > 0)
    interaction = chosen.compute_surface_interaction(ray, mi.RayFlags.All, found)
    spread = profile.at(dr.norm(interaction.p - origin.p))
    weight = dr.select(found, spread * (total / dr.mean(spread)), 0)
    return interaction, weight


@cache
def jitted(function: Callable[..., Any]) -> Callable[..., Any]:
    """Turn a function's loops into those of Dr.Jit, which must load after its LLVM is chosen."""
    transformed: Callable[..., Any] = dr.syntax(function)
    return transformed


def _reservoir(
    scene: Any, ray: Any, length: Any, pick: Any, find: Find, weigh: Any, active: Any
) -> tuple[Any, Any]:
    """Follow the probe; keep one hit with a chance in proportion to its weight."""
    chosen = dr.zeros(mi.PreliminaryIntersection3f)
    begin = mi.Point3f(ray.o)
    left = mi.Float(length)
    pick = mi.Float(pick)
    last = mi.UInt32(0xFFFFFFFF)
    total = mi.Float(0)
    hits = mi.UInt32(0)
    steps = mi.UInt32(0)
    going = mi.Bool(active)
    while dr.hint(going, label="probe"):
        piece = mi.Ray3f(begin, ray.d, left, ray.time, ray.wavelengths)
        hit = scene.ray_intersect_preliminary(piece, coherent=False, active=going)
        going &= hit.is_valid()
        skin, facing = find(hit, going)
        skin &= going & (hit.prim_index != last)
        weight = dr.select(skin, weigh(begin + ray.d * hit.t, facing), 0)
        total += weight
        keep = skin & (pick * total < weight)
        chosen[keep] = hit
        # One number serves all draws: what is left of it after each is uniform again.
        share = dr.select(skin & (total > 0), weight / total, 0)
        rest = dr.select(keep, pick / share, (pick - share) / (1 - share))
        pick = dr.select(skin, dr.clip(dr.select(share < 1, rest, pick), 0, 1), pick)
        last = dr.select(going, hit.prim_index, last)
        hits += dr.select(skin, mi.UInt32(1), mi.UInt32(0))
        steps += 1
        going &= (hits < _MOST_HITS) & (steps < _MOST_STEPS) & (left > hit.t + _STEP_MM)
        begin = dr.select(going, mi.Point3f(begin + ray.d * (hit.t + _STEP_MM)), begin)
        left = dr.select(going, left - hit.t - _STEP_MM, left)
    return chosen, total


def _densities(
    frame: Any, profile: Profile, offset: Any, facing: Any, normal_share: Any
) -> list[Any]:
    """Return the density per area with which each axis finds a point, all channels together."""
    local = frame.to_local(offset)
    lengths = (dr.hypot(local.x, local.y), dr.hypot(local.y, local.z), dr.hypot(local.x, local.z))
    tangent_share = (1 - normal_share) / 2
    shares = (normal_share, tangent_share, tangent_share)
    return [
        share * dr.abs(dr.dot(facing, axis)) * dr.mean(profile.at(distance))
        for axis, distance, share in zip((frame.n, frame.s, frame.t), lengths, shares, strict=True)
    ]


def _inside(offset: Any, here: Any, there: Any) -> Any:
    """Tell whether light may go straight from one point to the other through the skin."""
    sine = dr.select(dr.dot(here, there) < 0, _FACING_OPPOSED, _FACING)
    length = sine * dr.norm(offset)
    return ~((dr.dot(offset, here) > length) & (-dr.dot(offset, there) > length))
