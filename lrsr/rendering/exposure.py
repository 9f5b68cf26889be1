"""How do rays become pixels? A Gaussian film that gives the same bytes every time.

Every ray is drawn from its pixel's reconstruction filter (filter importance sampling: Ernst,
Stamminger and Greiner 2006), so that all its weight belongs to that pixel and a pixel is a plain
mean. Splatting, as Mitsuba's films do, adds up in the order in which threads finish, and its last
bits change from run to run.
"""

import math
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lrsr.errors import InputError
from lrsr.rendering.backend import dr, mi
from lrsr.rendering.geometry import AXIS_P1435LE, Viewpoint, world_to_head
from lrsr.rendering.lens import PINHOLE, Lens
from lrsr.rendering.lens_sensor import lens_sensor
from lrsr.rendering.mounted_lens import mount
from lrsr.rendering.pixel_filter import REACH_PX, describe_film, draw_offset
from lrsr.rendering.pose import Pose
from lrsr.rendering.strata import grid, order_rays, stratified
from lrsr.rendering.wavelengths import draw_wavelengths, split
from lrsr.spectra import band_edges

_MAX_RAYS = 1 << 22
"""Rays of one launch; more are split into passes."""

_Edges = tuple[float, ...] | None


def expose(
    scene: Any,
    integrator: Any,
    viewpoint: Viewpoint,
    pose: Pose,
    *,
    scale: int,
    samples: int,
    seed: int,
    lens: Lens = PINHOLE,
    focus_mm: float = math.inf,
    bands: int = 0,
) -> NDArray[np.float32]:
    """Trace the rays of one film.

    Args:
        scene: ``mi.Scene`` with the head at rest.
        integrator: ``mi.SamplingIntegrator``.
        viewpoint: Camera before the posed head.
        pose: Turns the camera instead of the head.
        scale: Film pixels per ×1 pixel.
        samples: Per pixel of this film.
        seed: Of the sampler.
        lens: Before the film.
        focus_mm: Distance of what is sharp along the optical axis, mm.
        bands: Spectral bands to deliver; 0: three colours.

    Returns:
        ``(side, side, 3)`` float32, linear sRGB, or ``(side, side, bands)``; see
        :mod:`lrsr.spectra`.

    Raises:
        InputError: The lens cannot be focused so near, or the variant has no spectrum.
    """
    edges = _edges(bands)
    side = scale * viewpoint.film_px
    right, down = (scale * shift for shift in viewpoint.shift_px)
    frame = _Frame(side, right, down)
    passes = -(-side * side * samples // _MAX_RAYS)
    per_pass = math.prod(grid(-(-samples // passes)))
    sensor = _make_sensor(viewpoint, pose, side, per_pass, lens, focus_mm, edges)
    if "scalar" in mi.variant():
        with nullcontext() if lens.is_pinhole else _one_thread():
            return np.array(mi.render(scene, sensor=sensor, integrator=integrator, seed=seed))
    total, count = np.zeros((2, side * side, bands or 3), dtype=np.float64)
    for number in range(passes):
        own_seed = _pass_seed(seed, number)
        light, rays = _trace(scene, integrator, sensor, frame, per_pass, own_seed, edges)
        total += light
        count += rays
    mean = np.divide(total, count, out=np.zeros_like(total), where=count > 0)
    return mean.astype(np.float32).reshape(side, side, -1)


def _edges(bands: int) -> _Edges:
    """Return the edges of so many bands, nm; None: three colours.

    Raises:
        InputError: The variant has no spectrum, or so many bands are not possible.
    """
    if bands and not mi.is_spectral:
        raise InputError(
            f"bands={bands}: variant {mi.variant()} traces three colours, no spectrum; set"
            " LRSR_VARIANT=llvm_ad_spectral, or choose a camera that needs no bands"
        )
    return band_edges(bands) if bands else None


@contextmanager
def _one_thread() -> Iterator[None]:
    """Trace in this thread alone: each ray through a lens is Python's, one thread at a time.

    Several take turns at every ray, which took minutes on busy cores, or for ever.
    """
    count = dr.thread_count()
    dr.set_thread_count(0)
    try:
        yield
    finally:
        dr.set_thread_count(count)


def _pass_seed(seed: int, number: int) -> int:
    """Return the 32-bit sampler seed of one pass of one picture."""
    return int(np.random.SeedSequence([seed, number]).generate_state(1)[0])


def _make_sensor(
    viewpoint: Viewpoint,
    pose: Pose,
    side: int,
    samples: int,
    lens: Lens,
    focus_mm: float,
    edges_nm: _Edges = None,
) -> Any:
    """Make the ``mi.Sensor`` of that viewpoint and lens; see :func:`expose`.

    Raises:
        InputError: The lens cannot be focused so near.
    """
    if lens.is_pinhole:
        return mi.load_dict(_describe_pinhole(viewpoint, pose, side, samples))
    constant_mm = viewpoint.pixels_per_slope * AXIS_P1435LE.pitch_um / 1000
    slope = viewpoint.film_px / 2 / viewpoint.pixels_per_slope
    # The filter reaches two pixels of the film beyond its corner.
    moved = max(map(abs, viewpoint.shift_px)) * side / viewpoint.film_px
    reach_mm = math.sqrt(2) * slope * constant_mm * (1 + 2 * (REACH_PX + moved) / side)
    mounted = mount(lens, constant_mm, focus_mm, reach_mm)
    to_world = world_to_head(pose) @ viewpoint.to_world()
    span = None if edges_nm is None else (edges_nm[0], edges_nm[-1])
    return lens_sensor(
        mounted,
        to_world,
        slope,
        side,
        samples,
        disperse=lens.dispersion,
        span_nm=span,
        shift=_scalar_shift(viewpoint),
    )


def _scalar_shift(viewpoint: Viewpoint) -> tuple[float, float]:
    """Return by what share of its side (right, down) a sensor itself has to move the picture.

    In variants with compilers that is nothing: :func:`_trace` does it, with one kernel for all.
    """
    right, down = viewpoint.shift_px if "scalar" in mi.variant() else (0.0, 0.0)
    return right / viewpoint.film_px, down / viewpoint.film_px


def _describe_pinhole(viewpoint: Viewpoint, pose: Pose, side: int, samples: int) -> dict[str, Any]:
    """Describe Mitsuba's pinhole for that viewpoint, for ``mi.load_dict``."""
    centre, (_, up, back) = viewpoint.centre_mm, viewpoint.axes()
    in_world = mi.ScalarTransform4f().look_at(
        origin=centre.tolist(), target=(centre - back).tolist(), up=up.tolist()
    )
    right, down = _scalar_shift(viewpoint)
    return {
        "type": "perspective",
        "fov": viewpoint.view_deg,
        "principal_point_offset_x": -right,
        "principal_point_offset_y": -down,
        "near_clip": 1.0,
        "far_clip": 1e6,
        "to_world": mi.ScalarTransform4f(world_to_head(pose)) @ in_world,
        **describe_film(side, samples),
    }


class _Frame(NamedTuple):
    """Side of a film, and how far its picture lies off, px of that film."""

    side: int
    right: float
    down: float


def _trace(
    scene: Any,
    integrator: Any,
    sensor: Any,
    frame: _Frame,
    samples: int,
    seed: int,
    edges_nm: _Edges,
) -> tuple[NDArray[np.float64], NDArray[np.float64] | float]:
    """Return the light of ``samples`` rays in each pixel, and as how many rays they count.

    Both are sums, ``(side², 3 or N)`` or what spreads to that.
    """
    side = frame.side
    lanes = order_rays(samples, side * side, seed)
    sampler = stratified(samples, seed, lanes)
    # Opaque, so that one kernel serves every film of that number of samples.
    pixel, width = lanes // dr.opaque(mi.UInt32, samples), dr.opaque(mi.UInt32, side)
    row = pixel // width
    corner = mi.Point2f(mi.Float(pixel - row * width), mi.Float(row))
    if frame.right or frame.down:
        corner -= mi.Vector2f(*(dr.opaque(mi.Float, off) for off in (frame.right, frame.down)))
    position = (corner + 0.5 + draw_offset(sampler.next_2d())) / mi.Float(width)
    light, counts, wavelengths = _follow(scene, integrator, sensor, sampler, position, edges_nm)
    if mi.is_spectral and edges_nm is None:
        light = mi.spectrum_to_srgb(light, wavelengths)
    light, counts, wavelengths = (
        value if value is None else _in_given_order(value, lanes)
        for value in (light, counts, wavelengths)
    )
    dr.eval(light, counts, wavelengths)  # once, not once per channel
    channels = light if edges_nm is None else split(light, wavelengths, edges_nm)
    sums = _sum(channels, samples)
    if counts is None:
        return sums, float(samples)
    return sums, _sum(counts if edges_nm is None else [counts[0]], samples)


def _in_given_order(values: Any, lanes: Any) -> Any:
    """Put what each lane found where it belongs, so that sums do not depend on the order."""
    ordered = dr.empty(type(values), len(lanes))
    dr.scatter(ordered, values, lanes, mode=dr.ReduceMode.Permute)
    return ordered


def _follow(
    scene: Any, integrator: Any, sensor: Any, sampler: Any, position: Any, edges_nm: _Edges
) -> tuple[Any, Any, Any]:
    """Return the light of one ray for each position, as how many it counts, and its wavelengths.

    None: all count as one. Rays that a lens stops bring no light. Light of a spectral variant is
    that of each wavelength over its density.
    """
    if not hasattr(sensor, "sample_balanced"):  # a pinhole
        colour = sampler.next_1d() if mi.is_spectral else 0.5
        ray, weight = sensor.sample_ray_differential(0.0, colour, position, mi.Point2f(0.5))
        if edges_nm is not None:  # a pinhole bends no light: any wavelengths may take that way
            ray.wavelengths, weight = draw_wavelengths(colour, (edges_nm[0], edges_nm[-1]))
        light, _, _ = integrator.sample(scene, sampler, ray)
        counts = None
    else:
        colour, aperture = sampler.next_1d(), sampler.next_2d()
        ray, weight, counts = sensor.sample_balanced(colour, position, aperture)
        alive = dr.any(weight != 0)
        ray = mi.RayDifferential3f(ray)
        light, _, _ = integrator.sample(scene, sampler, ray, active=alive)
        light = dr.select(alive, weight * light, 0.0)
    if mi.is_spectral:
        light = weight * light if counts is None else light
    return light, counts, ray.wavelengths


def _sum(values: Any, samples: int) -> NDArray[np.float64]:
    """Add up the values of each pixel, ``(side², C)``."""
    sums = [dr.block_sum(channel, samples, mode="evaluated").numpy() for channel in values]
    return np.stack(sums, axis=1).astype(np.float64)
