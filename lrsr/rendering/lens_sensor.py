"""A lens as a sensor of Mitsuba: rays from the film, through every surface, into the scene.

One loop over a table of surfaces, so that one kernel serves every lens. Rays are aimed at the plane
of the exit pupil; those that a rim stops or a surface reflects totally have no weight. The weight
is A cos⁴θ / Z² (Kolb, Mitchell and Hanrahan 1995, equation 4), divided by its mean for the middle
of the film: a field of light of one colour has that colour there, at any f-number.

In spectral variants glass has its index at the first wavelength of the ray. The others would be
bent elsewhere, so they get no weight and the first the weight of all (it has their distribution).
Reflections between the surfaces and at them are left out, as is diffraction.
"""

from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lrsr.rendering.backend import dr, mi
from lrsr.rendering.glass import D_LINE_NM, coefficients, index_of_ray
from lrsr.rendering.lens import CHANNELS_NM
from lrsr.rendering.mounted_lens import MountedLens
from lrsr.rendering.pixel_filter import describe_film
from lrsr.rendering.wavelengths import draw_wavelengths

_ROW = 10
"""Numbers of a surface in the table."""


def _table(mounted: MountedLens) -> NDArray[np.float64]:
    """Return what a ray from the film meets, ``(N, 10)``, nearest the film first.

    Columns: vertex before the film (mm), curvature (1/mm, > 0 if the centre lies towards the
    scene), square of the semi-aperture (mm²), power of an ideal lens (1/mm), and the Sellmeier
    coefficients of what lies beyond.
    """
    backwards, vertices = mounted.from_film()
    rows = [
        [
            vertex,
            surface.curvature_per_mm,
            surface.semi_aperture_mm**2,
            surface.power_per_mm,
            *coefficients(surface.glass),
        ]
        for surface, vertex in zip(backwards, vertices, strict=True)
    ]
    return np.array(rows)


def lens_sensor(
    mounted: MountedLens,
    to_world: NDArray[np.float64],
    slope: float,
    side: int,
    samples: int,
    *,
    disperse: bool,
    span_nm: tuple[float, float] | None = None,
    shift: tuple[float, float] = (0.0, 0.0),
) -> Any:
    """Make the sensor.

    Args:
        mounted: The lens.
        to_world: ``(4, 4)``, rigid: from the entrance pupil's frame (x to the right of the picture,
            y up, z away from the scene) to the world's, mm.
        slope: Of the rays at the right edge of the square film, near the axis: x / -z.
        side: Of the film, px.
        samples: Per pixel.
        disperse: Let each ray of an rgb variant be of one channel, chosen by the wavelength sample.
        span_nm: In spectral variants wavelengths are drawn evenly between these two; None: as
            sRGB needs them.
        shift: (right, down) of the picture, as a share of its side; for scalar variants alone.

    Returns:
        ``mi.Sensor``; it renders by ``mi.render``, too.
    """
    properties = mi.Properties()
    for name, description in describe_film(side, samples).items():
        properties[name] = mi.load_dict(description)
    sensor = _sensor_class()(properties)
    sensor._mounted, sensor._matrix = mounted, to_world
    sensor._disperse, sensor._span_nm, sensor._shift = disperse, span_nm, shift
    sensor._width = -2 * slope * mounted.constant_mm  # the lens turns the picture round
    sensor._numbers = None if "scalar" in mi.variant() else _opaque(sensor)
    return sensor


@cache
def _sensor_class() -> Any:
    class LensSensor(mi.Sensor):  # type: ignore[misc]
        """See the module."""

        def sample_ray(
            self, time: Any, wavelength: Any, position: Any, aperture: Any, active: Any = True
        ) -> tuple[Any, Any]:
            """Return a ray into the scene and its weight, per channel or wavelength."""
            if self._numbers is None:
                return _scalar_ray(self, time, wavelength, position, aperture)
            ray, colour, fall = _wavefront_ray(self, time, wavelength, position, aperture, active)
            return ray, colour * fall

        def sample_balanced(
            self, wavelength: Any, position: Any, aperture: Any
        ) -> tuple[Any, Any, Any]:
            """Return a ray, its weight, and a number per channel that is 1 on average.

            Rims let rays of a pixel through by chance. A pixel's sum of light over its sum of these
            numbers is free of that chance, and its expectation is the same but for 1 / samples.
            """
            ray, colour, fall = _wavefront_ray(self, 0.0, wavelength, position, aperture, True)
            share = fall * _reciprocal_fall_off(self, position)
            balance = mi.Color3f(share) if mi.is_spectral else colour * share
            return ray, colour * fall, balance

        def sample_ray_differential(
            self, time: Any, wavelength: Any, position: Any, aperture: Any, active: Any = True
        ) -> tuple[Any, Any]:
            """Return the same ray, without differentials."""
            ray, weight = self.sample_ray(time, wavelength, position, aperture, active)
            return mi.RayDifferential3f(ray), weight

    return LensSensor


def _opaque(sensor: Any) -> dict[str, Any]:
    """Return all numbers of the lens so that no kernel holds one of them."""
    mounted = sensor._mounted
    rows = _table(mounted)
    scalars = {
        "width": sensor._width,
        "pupil": mounted.pupil_mm,
        "radius": mounted.pupil_radius_mm,
        "entrance": mounted.entrance_mm,
        "growth": mounted.pupil_growth_per_mm,
        "brightness": max(mounted.brightness, 1e-30),
        "falls_off": float(mounted.falls_off),
        "disperse": float(sensor._disperse),
    }
    return {
        **{name: dr.opaque(mi.Float, value) for name, value in scalars.items()},
        "table": mi.Float(rows.ravel()),
        "fall_off": mi.Float(list(mounted.fall_off)),
        "steps_per_mm": dr.opaque(mi.Float, (len(mounted.fall_off) - 1) / mounted.film_mm),
        "last_step": dr.opaque(mi.Float, len(mounted.fall_off) - 1.001),
        "shift": [dr.opaque(mi.Float, value) for value in mounted.pupil_shift],
        "count": dr.opaque(mi.UInt32, len(rows)),
        "matrix": [[dr.opaque(mi.Float, float(x)) for x in row] for row in sensor._matrix[:3]],
    }


def _wavefront_ray(
    sensor: Any, time: Any, wavelength: Any, position: Any, aperture: Any, active: Any
) -> tuple[Any, Any, Any]:
    """Return a ray, the weight of its colours, and that of its place; 0 if it does not pass."""
    number = sensor._numbers
    film = mi.Vector3f(
        (position.x - 0.5) * number["width"], (0.5 - position.y) * number["width"], 0.0
    )
    first, third, fifth = number["shift"]
    square = dr.square(film.x) + dr.square(film.y)
    radius = number["radius"] + number["growth"] * square
    disc = radius * mi.warp.square_to_uniform_disk_concentric(aperture)
    shift = first + square * (third + square * fifth)
    aim = mi.Vector3f(disc.x + shift * film.x, disc.y + shift * film.y, number["pupil"]) - film
    cosine = number["pupil"] * dr.rcp(dr.norm(aim))
    aim *= dr.rcp(dr.norm(aim)) * dr.sign(number["pupil"])
    wavelengths, traced_um, colour = _colours(sensor, wavelength, number)
    point, way, through = _refract(
        number["table"], number["count"], film, aim, traced_um, mi.Bool(active)
    )
    fall = dr.square(radius * dr.square(cosine) / number["pupil"]) / number["brightness"]
    fall = dr.select(number["falls_off"] > 0, fall, 1.0)
    # z runs from the film to the scene here, and the other way in the frame of the entrance pupil.
    origin = [point.x, point.y, number["entrance"] - point.z]
    bent = [way.x, way.y, -way.z]
    rows = number["matrix"]
    ray = mi.Ray3f(
        mi.Point3f(
            *(sum(m * x for m, x in zip(row, origin, strict=False)) + row[3] for row in rows)
        ),
        mi.Vector3f(*(sum(m * x for m, x in zip(row, bent, strict=False)) for row in rows)),
        time,
        wavelengths,
    )
    return ray, colour, dr.select(through, fall, 0.0)


def _reciprocal_fall_off(sensor: Any, position: Any) -> Any:
    """Return 1 / mean weight of the rays of a film position; 0 where no light arrives."""
    number = sensor._numbers
    radius = dr.abs(number["width"]) * dr.norm(position - 0.5)
    step = dr.minimum(radius * number["steps_per_mm"], number["last_step"])
    below = mi.UInt32(step)
    low = dr.gather(mi.Float, number["fall_off"], below)
    high = dr.gather(mi.Float, number["fall_off"], below + 1)
    expected = dr.lerp(low, high, step - mi.Float(below))
    return dr.select(expected > 1e-6, dr.rcp(expected), 0.0)


def _colours(sensor: Any, sample: Any, number: dict[str, Any]) -> tuple[Any, Any, Any]:
    """Return the ray's wavelengths (nm), the one that is traced (µm), and the weights."""
    if mi.is_spectral:
        if sensor._span_nm is None:
            wavelengths, weight = mi.sample_rgb_spectrum(mi.sample_shifted(sample))
        else:
            wavelengths, weight = draw_wavelengths(sample, sensor._span_nm)
        first = [float(len(wavelengths)), *[0.0] * (len(wavelengths) - 1)]
        return wavelengths, wavelengths[0] / 1000, weight * mi.Spectrum(*first)
    channel = dr.minimum(mi.UInt32(3 * sample), 2)
    ones = mi.Spectrum(*(dr.select(channel == c, 3.0, 0.0) for c in range(3)))
    spread = number["disperse"] > 0
    of_channel = dr.select(channel == 0, CHANNELS_NM[0], CHANNELS_NM[1])
    of_channel = dr.select(channel == 2, CHANNELS_NM[2], of_channel)
    traced = dr.select(spread, of_channel, D_LINE_NM) / 1000
    return mi.Color0f(), traced, dr.select(spread, ones, mi.Spectrum(1.0))


def _refract(rows: Any, count: Any, point: Any, way: Any, traced_um: Any, active: Any) -> Any:
    """Refract at one surface after the other, as :func:`lrsr.rendering.surfaces.trace` does."""

    def meet(row: Any, point: Any, way: Any, before: Any, alive: Any) -> tuple[Any, ...]:
        vertex, c, square, power, *glass = (
            dr.gather(mi.Float, rows, _ROW * row + column, alive) for column in range(_ROW)
        )
        local = point - mi.Vector3f(0, 0, vertex)
        local = local - (local.z * dr.rcp(way.z)) * way
        f = c * (dr.square(local.x) + dr.square(local.y))
        g = way.z - c * (local.x * way.x + local.y * way.y)
        discriminant = dr.square(g) - c * f
        cosine = dr.safe_sqrt(discriminant)
        local = local + f * dr.rcp(g + cosine) * way
        behind = index_of_ray(glass, traced_um, dr.sqrt)
        ratio = before * dr.rcp(behind)
        bent = (1 - ratio) * (1 + ratio) + dr.square(ratio * cosine)  # cos² of refraction
        inside = dr.square(local.x) + dr.square(local.y) <= square
        turn = dr.safe_sqrt(bent) - ratio * cosine
        way = ratio * way + turn * (mi.Vector3f(0, 0, 1) - c * local)
        way = dr.normalize(way - power * way.z * mi.Vector3f(local.x, local.y, 0))
        alive = alive & (discriminant > 0) & inside & (bent > 0)
        return row + 1, local + mi.Vector3f(0, 0, vertex), way, behind, alive

    _, point, way, _, alive = dr.while_loop(
        state=(mi.UInt32(0), point, way, mi.Float(1.0), active),
        cond=lambda row, point, way, before, alive: (row < count) & alive,
        body=meet,
        label="surfaces of a lens",
    )
    return point, way, alive


def _scalar_ray(
    sensor: Any, time: Any, wavelength: Any, position: Any, aperture: Any
) -> tuple[Any, Any]:
    """Trace one ray in double precision, for variants without Dr.Jit's compilers."""
    mounted = sensor._mounted
    right, down = sensor._shift
    film = np.array([[position[0] - right - 0.5, 0.5 - (position[1] - down)]]) * sensor._width
    disc = mi.warp.square_to_uniform_disk_concentric(aperture)
    radius = float(mounted.pupil_reach_mm(film)[0])
    aim = np.array([[disc[0], disc[1]]]) * radius
    aim += mounted.pupil_middle_mm(film)
    channel = min(int(3 * wavelength), 2)
    weight = np.ones(3)
    traced_nm = D_LINE_NM
    if sensor._disperse:
        weight, traced_nm = 3.0 * np.eye(3)[channel], CHANNELS_NM[channel]
    point, way, through = mounted.rays_from_film(film, aim, traced_nm)
    if mounted.falls_off:
        weight = weight * mounted.weight(film, aim, np.array([radius]))
    origin = point[0] * (1, 1, -1) + (0, 0, mounted.entrance_mm)
    rows = sensor._matrix[:3]
    ray = mi.Ray3f(
        mi.Point3f(*(rows[:, :3] @ origin + rows[:, 3])),
        mi.Vector3f(*(rows[:, :3] @ (way[0] * (1, 1, -1)))),
    )
    ray.time = time
    return ray, mi.Color3f(*(weight * bool(through[0])))
