"""A ball of skin in a light, for tests of the tracer alone."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from oracles.heads import ball

from lrsr.presets import preset
from lrsr.rendering.backend import _start
from lrsr.rendering.painted_skin import Sampling, SkinSurface
from lrsr.rendering.skin import Skin
from lrsr.rendering.subsurface import subsurface_integrator

SIDE = 24
DISTANCE = 20.0
"""Of the camera, in radii."""


def texture(value: Any, channels: int) -> Any:
    mi = _start()
    texels = np.full((2, 2, channels), value, np.float32)
    raw = channels == 1 or not mi.is_spectral
    return mi.load_dict({"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": raw})


def mesh(radius_mm: float, properties: Any) -> Any:
    mi = _start()
    vertices, faces, uv = ball(96, 192)
    made = mi.Mesh(
        "skin", len(vertices), len(faces), properties, has_vertex_normals=True,
        has_vertex_texcoords=True,
    )  # fmt: skip
    values = mi.traverse(made)
    values["faces"] = faces.astype(np.uint32).ravel()
    values["vertex_positions"] = (radius_mm * vertices).astype(np.float32).ravel()
    values["vertex_normals"] = vertices.astype(np.float32).ravel()
    values["vertex_texcoords"] = uv.astype(np.float32).ravel()
    values.update()
    return made


def mean_of_ball(
    albedo: Any,
    *,
    radius_mm: float = 100.0,
    roughness: float = 0.5,
    skin: Skin | None = None,
    sampling: Sampling | None = None,
    samples: int = 256,
    runs: int = 4,
) -> tuple[NDArray, NDArray]:
    """Return the mean radiance of a ball's disc in white light, and its standard error."""
    mi = _start()
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "diffuse"})
    made = mesh(radius_mm, properties)
    surface = SkinSurface(made, texture(albedo, 3), texture(roughness, 1))
    skin = skin or preset("rendering/skin", "jensen_skin1")
    integrator = subsurface_integrator(skin, [surface], sampling=sampling)
    return _mean(made, integrator, radius_mm, samples, runs)


def brute_force(
    absorption_per_mm: float, scattering_per_mm: float, radius_mm: float, samples: int, runs: int
) -> tuple[NDArray, NDArray]:
    """Return the same for a grey medium behind a smooth boundary of index 1.4, by ``volpath``."""
    mi = _start()
    extinction = absorption_per_mm + scattering_per_mm
    medium = {"type": "homogeneous", "scale": extinction, "sigma_t": 1.0}
    properties = mi.Properties()
    properties["bsdf"] = mi.load_dict({"type": "dielectric", "int_ior": 1.4, "ext_ior": 1.0})
    properties["interior"] = mi.load_dict({**medium, "albedo": scattering_per_mm / extinction})
    integrator = mi.load_dict({"type": "volpath", "max_depth": 2000, "rr_depth": 50})
    return _mean(mesh(radius_mm, properties), integrator, radius_mm, samples, runs)


def _mean(
    made: Any, integrator: Any, radius_mm: float, samples: int, runs: int
) -> tuple[NDArray, NDArray]:
    mi = _start()
    white = {"type": "constant", "radiance": {"type": "rgb", "value": 1.0}}
    scene = mi.load_dict({"type": "scene", "light": white, "skin": made})
    view = mi.ScalarTransform4f().look_at([0, 0, DISTANCE * radius_mm], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": SIDE, "height": SIDE, "rfilter": {"type": "box"}}
    sensor = mi.load_dict(
        {
            "type": "perspective",
            "fov": 2 * np.degrees(np.arcsin(1 / DISTANCE)),
            "near_clip": 1.0,
            "far_clip": 1e6,
            "to_world": view,
            "film": film,
        }
    )
    y, x = np.mgrid[:SIDE, :SIDE] - (SIDE - 1) / 2
    disc = np.hypot(x, y) < 0.95 * SIDE / 2
    means = []
    for seed in range(runs):
        image = mi.render(scene, sensor=sensor, integrator=integrator, spp=samples, seed=seed)
        means.append(np.array(image)[disc].mean(axis=0))
    return np.mean(means, axis=0), np.std(means, axis=0, ddof=1) / runs**0.5
