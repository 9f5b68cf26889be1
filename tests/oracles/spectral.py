"""What a variant that traces wavelengths shows; it must be the only one of its process.

``python -m oracles.spectral OUT.npz`` with LRSR_VARIANT=llvm_ad_spectral; the numbers are judged by
the tests of ``lrsr.rendering``.
"""

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from fakes.scenes import LIGHTINGS, ROOMS, Studio
from numpy.typing import NDArray
from oracles.heads import ellipsoid_part, stand_in
from oracles.translucent import mean_of_ball

from lrsr.identities.head import Head
from lrsr.presets import preset
from lrsr.rendering import live_scene
from lrsr.rendering.backend import _start
from lrsr.rendering.lens_sensor import lens_sensor
from lrsr.rendering.mounted_lens import mount
from lrsr.rendering.skin_spectrum import skin_albedo
from lrsr.rendering.spectral_upsampling import _filters, _light_bands, meter_bands
from lrsr.rendering.wavelengths import draw_wavelengths, split
from lrsr.spectra import band_edges, srgb_weights

Arrays = dict[str, NDArray[Any]]
EDGES = band_edges(35)
COLOURS = np.array(
    [[1.0, 1.0, 1.0], [1.0, 0.78, 0.45], [0.3, 2.0, 0.1], [0.0, 0.0, 0.5], [0, 0, 0]]
)
SKIN = np.array([0.45, 0.28, 0.2])
RUNS = 12


def shapes() -> Arrays:
    """Light of given colours and skin of a given one, as Mitsuba has them at wavelengths."""
    import drjit as dr

    mi = _start()
    nm = np.arange(380.5, 730.0, 1.0)
    si = dr.zeros(mi.SurfaceInteraction3f, len(nm))
    si.wavelengths, si.wi = mi.Spectrum(mi.Float(nm)), mi.Vector3f(0, 0, 1)
    lights = []
    for colour in COLOURS:
        even = np.tile(colour.astype(np.float32), (4, 8, 1))
        emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(even)})
        lights.append(np.array(emitter.eval(si))[0])
    texels = mi.Bitmap(np.tile(SKIN.astype(np.float32), (2, 2, 1)))
    albedo = skin_albedo(mi.load_dict({"type": "bitmap", "bitmap": texels, "raw": True}))
    skin = np.array(albedo.eval(si))[0]
    white = mi.cie_d65(mi.Float(nm))
    seen = mi.spectrum_to_srgb(mi.Spectrum(mi.Float(skin) * white), si.wavelengths)
    return {
        "nm": nm,
        "lights": np.array(lights),
        "filters": _filters(np.clip(COLOURS / 2, 0, 1), nm),
        "light_bands": _light_bands(COLOURS, EDGES),
        "skin": skin,
        "skin_seen": np.array(seen).sum(axis=1),
        "metered_yellow": np.array(meter_bands(ROOMS["room_yellow"], EDGES)),
        "metered_above": np.array(meter_bands(LIGHTINGS["above"], EDGES)),
    }


def rays() -> Arrays:
    """Wavelengths that are drawn, and light of one each, split into bands."""
    mi = _start()
    uniform = (np.arange(1000) + 0.5) / 1000
    drawn, weight = draw_wavelengths(mi.Float(uniform), (380.0, 730.0))
    nm = np.array(
        [[380.0, 389.99, 390.0, 555.0, 729.99, 731.0], [455.0] * 6, [379.0] * 6, [600.0] * 6]
    )
    light = np.array([[1.0] * 6, [2.0] * 6, [50.0] * 6, [0.0] * 6])
    made = split(mi.Spectrum(light), mi.Spectrum(nm), EDGES)
    return {
        "drawn": np.array(drawn),
        "weight": np.array(weight),
        "split": np.array([np.array(band) for band in made]),
        "unit": np.array(mi.MI_CIE_Y_NORMALIZATION),
    }


def pictures(renderer: Studio) -> Arrays:
    """The same face as sRGB and as bands, several times; and by a lens."""
    ask: dict[str, Any] = {"lighting": "room_yellow", "ipd_px": 3, "samples_per_pixel": 256}
    head, weights = stand_in(1), srgb_weights(EDGES)
    renderer.render(stand_in(0), **ask)
    plain = [renderer.render(head, seed=run, **ask).image.numpy() for run in range(RUNS)]
    films = [renderer.render(head, seed=run, bands=35, **ask) for run in range(100, 100 + RUNS)]
    again = renderer.render(head, seed=100, bands=35, **ask)
    lens = renderer.render(head, bands=35, lens=preset("lens", "thin", f_number=2000.0), **ask)
    return {
        "plain": np.array(plain),
        "observed": np.array([np.tensordot(weights, film.image.numpy(), 1) for film in films]),
        "again": np.array([films[0].image.numpy(), again.image.numpy()]),
        "by_lens": lens.image.numpy(),
        "by_pinhole": np.mean([film.image.numpy() for film in films], axis=0),
        "edges_nm": np.array(films[0].edges_nm),
        "metered_bands": np.array(films[0].metered_bands),
    }


def glass(renderer: Studio) -> Arrays:
    """Rays of one wavelength each through a lens, and a face through a tiny one and a pinhole."""
    mi = _start()
    mounted = mount(preset("lens", "single"), 3.0, 1100.0, 0.5)
    sensor = lens_sensor(mounted, np.eye(4), 0.1, 16, 16, disperse=False)
    position, aperture = np.random.default_rng(0).uniform(size=(2, 300, 2))
    colour = np.random.default_rng(1).uniform(size=300)
    ray, weight = sensor.sample_ray_differential(
        0.0, mi.Float(colour), mi.Point2f(position.T), mi.Point2f(aperture.T)
    )
    disc = np.array(mi.warp.square_to_uniform_disk_concentric(mi.Point2f(aperture.T))).T
    film = (position - 0.5) * (-2, 2) * 0.1 * 3.0
    aims = disc * mounted.pupil_reach_mm(film)[:, None] + mounted.pupil_middle_mm(film)
    nm, way = np.array(ray.wavelengths), np.array(ray.d).T
    errors = []
    for number in range(300):
        one = slice(number, number + 1)
        _, wanted, through = mounted.rays_from_film(film[one], aims[one], float(nm[0, number]))
        if through.all():
            errors.append(np.abs(way[number] - wanted[0] * (1, 1, -1)).max())
    ask: dict[str, Any] = {"lighting": "room_blue", "ipd_px": 4, "samples_per_pixel": 2048}
    pinhole, tiny = (
        renderer.render(stand_in(1), lens=lens, **ask).image.numpy()
        for lens in ("pinhole", preset("lens", "thin", f_number=2000.0))
    )
    return {
        "lens_errors": np.array(errors),
        "lens_nm": nm,
        "lens_weight": np.array(weight),
        "pinhole": pinhole,
        "tiny": tiny,
    }


def lambert(_: object, textures: Mapping[str, object]) -> tuple[dict[str, Any], dict[str, str]]:
    diffuse = {"type": "diffuse", "reflectance": textures["albedo"]}
    return diffuse, {"albedo": "reflectance.data"}


def sphere() -> Arrays:
    """A grey Lambertian sphere where the face would be, in a yellow room."""
    usual, live_scene.bsdf = live_scene.bsdf, lambert
    radius = 60.0
    ball = ellipsoid_part("ball", "hair", (radius,) * 3, (0, -12.6, 0), np.full((2, 2, 3), 0.18))
    head = Head("sphere", (ball,), np.array([[-31.5, 0, 0], [31.5, 0, 0]]), np.zeros((5, 3)))
    light = replace(ROOMS["room_yellow"], panels=(), fill_share=1.0)
    asked = {"ipd_px": 16, "samples_per_pixel": 512, "camera_m": 10.0, "bands": 35}
    result = Studio().render(head, lighting=light, **asked)
    live_scene.bsdf = usual
    image = result.image.numpy()
    side = image.shape[-1]
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    disc = x**2 + y**2 < (0.8 * 16 * radius / 63) ** 2
    return {
        "sphere": image[:, disc].mean(axis=1),
        "sphere_metered": np.array(result.metered_bands),
        "backdrop": image[:, 0, :].mean(axis=1),
    }


if __name__ == "__main__":
    people = [stand_in(3), stand_in(4, ipd_mm=63.0), stand_in(3)]
    renderer = Studio()
    ask: dict[str, Any] = {"ipd_px": 3, "samples_per_pixel": 64, "bands": 7}
    turns = np.array([renderer.render(head, **ask).image.numpy() for head in people])
    seen = {**shapes(), **rays(), **pictures(renderer), **glass(renderer), **sphere()}
    translucent, _ = mean_of_ball(0.4, samples=128, runs=2)
    np.savez(sys.argv[1], **seen, turns=turns, translucent=translucent)
