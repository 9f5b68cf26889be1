"""The sensor in Dr.Jit: against rays in double precision, Mitsuba's thin lens, and energy."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from fakes.scenes import LENSES, LIGHTINGS, Studio
from oracles.heads import dots, stand_in
from scipy.stats import norm

from lrsr.presets import preset
from lrsr.rendering.backend import _start
from lrsr.rendering.exposure import _describe_pinhole, _make_sensor, expose
from lrsr.rendering.geometry import AXIS_P1435LE, Viewpoint, place_camera
from lrsr.rendering.lens import CHANNELS_NM, Lens, biconvex
from lrsr.rendering.lens_sensor import _ROW, _table, lens_sensor
from lrsr.rendering.mounted_lens import mount
from lrsr.rendering.pixel_filter import describe_film
from lrsr.rendering.pose import FRONTAL, Pose
from lrsr.rendering.surfaces import image_of

FOCUS_MM = 1100.0
SLOPE = 0.113
NAMES = ["thin", "single", "double_gauss"]


def rays(name: str, count: int, wavelength: float, **changes: Any) -> tuple[Any, ...]:
    """Trace the same rays by the sensor and in double precision."""
    lens = preset("lens", name, **changes)
    mounted = mount(lens, 3.0, FOCUS_MM, 0.5)
    shift = np.eye(4)
    shift[:3, 3] = 1, 2, 3
    mi = _start()
    sensor = lens_sensor(mounted, shift, SLOPE, 16, 16, disperse=lens.dispersion)
    rng = np.random.default_rng(0)
    position, aperture = rng.uniform(size=(2, count, 2))
    ray, weight = sensor.sample_ray_differential(
        0.0, mi.Float(wavelength), mi.Point2f(position.T), mi.Point2f(aperture.T)
    )
    disc = np.array(mi.warp.square_to_uniform_disk_concentric(mi.Point2f(aperture.T))).T
    film = (position - 0.5) * (-2, 2) * SLOPE * 3.0
    nm = CHANNELS_NM[int(3 * wavelength)] if lens.dispersion else 587.5618
    aims = disc * mounted.pupil_reach_mm(film)[:, None] + mounted.pupil_middle_mm(film)
    point, way, through = mounted.rays_from_film(film, aims, nm)
    point = point * (1, 1, -1) + (1, 2, 3 + mounted.entrance_mm)
    wanted = (point, way * (1, 1, -1), through)
    return (np.array(ray.o).T, np.array(ray.d).T, np.array(weight).T), wanted


@pytest.mark.parametrize("name", NAMES)
def test_rays_are_those_of_double_precision(renderer: Studio, name: str) -> None:
    (origin, way, weight), (point, wanted, through) = rays(name, 5000, 0.2)
    assert ((weight[:, 0] > 0) == through).mean() > 0.999  # the rest grazes a rim
    seen = through & (weight[:, 0] > 0)
    np.testing.assert_allclose(origin[seen], point[seen], atol=1e-5)
    np.testing.assert_allclose(way[seen], wanted[seen], atol=2e-6)


@pytest.mark.parametrize("channel", [0, 1, 2])
def test_a_ray_of_a_dispersing_lens_has_one_channel(renderer: Studio, channel: int) -> None:
    sample = (channel + 0.5) / 3
    (_, way, weight), (_, wanted, through) = rays("single", 500, sample, dispersion=True)
    np.testing.assert_allclose(way[through], wanted[through], atol=2e-6)
    others = [c for c in range(3) if c != channel]
    assert (weight[through][:, channel] > 1).all()
    assert not weight[:, others].any()


def field(lens: Lens, film_px: int = 16, slope: float = 0.3, samples: int = 1024) -> np.ndarray:
    """Expose a lens to a field of radiance 1 from everywhere."""
    mi = _start()
    scene = mi.load_dict({"type": "scene", "sky": {"type": "constant", "radiance": 1.0}})
    viewpoint = Viewpoint(np.array([0.0, 0.0, FOCUS_MM]), film_px, film_px / 2 / slope)
    focal_mm = viewpoint.pixels_per_slope * AXIS_P1435LE.pitch_um / 1000
    assert focal_mm > 0
    integrator = mi.load_dict({"type": "path", "max_depth": 2})
    return expose(
        scene,
        integrator,
        viewpoint,
        FRONTAL,
        scale=1,
        samples=samples,
        seed=1,
        lens=lens,
        focus_mm=FOCUS_MM,
    )


def falls(name: str, slope: float) -> Callable[[np.ndarray], np.ndarray]:
    """Return how bright a film point at a slope is beside the middle, by quadrature."""
    constant = 16 / 2 / slope * AXIS_P1435LE.pitch_um / 1000
    mounted = mount(LENSES[name], constant, FOCUS_MM, 1.5 * slope * constant)
    grid = (np.arange(141) / 70 - 1) * 1.4 * mounted.pupil_radius_mm
    aims = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)

    def share(at: float) -> float:
        film = np.tile([at * constant, 0.0], (len(aims), 1))
        _, _, through = mounted.rays_from_film(film, aims)
        square = ((aims - film) ** 2).sum(axis=1) + mounted.pupil_mm**2
        return float((through * mounted.pupil_mm**2 / square**2).sum())

    slopes = np.linspace(0, 1.7 * slope, 28)
    shares = np.array([share(at) for at in slopes])
    return lambda at: np.interp(at, slopes, shares / shares[0])


@pytest.mark.parametrize("name", ["single", "double_gauss"])
def test_a_field_of_one_is_one_in_the_middle_and_falls_off_as_rims_make_it(
    renderer: Studio, name: str
) -> None:
    slope = 0.3
    image = field(LENSES[name], slope=slope)[..., 1]
    law = falls(name, slope)
    offset = (np.arange(16) + 0.5 - 8) / 8 * slope
    spread = np.random.default_rng(0).normal(0, 0.5 / 8 * slope, (2, 4000))  # the film's filter
    for row, column in ((7, 7), (7, 11), (7, 15), (0, 0), (15, 4)):
        at = np.hypot(offset[row] + spread[0], offset[column] + spread[1])
        assert image[row, column] == pytest.approx(law(at).mean(), abs=0.006)
    assert image[0, 0] < 0.95 * image[7, 7]


def test_a_thin_lens_does_not_fall_off(renderer: Studio) -> None:
    np.testing.assert_allclose(field(LENSES["thin"]), 1.0, atol=1e-6)


def blurred(renderer: Studio, lens: Lens, seed: int, depth_mm: float = FOCUS_MM) -> np.ndarray:
    head = stand_in(1)
    scene = renderer._live.show(head, LIGHTINGS["side"], FRONTAL)
    viewpoint = place_camera(head.pupils, 6.0, camera_m=0.4)
    return expose(
        scene,
        renderer._path(),
        viewpoint,
        FRONTAL,
        scale=1,
        samples=256,
        seed=seed,
        lens=lens,
        focus_mm=depth_mm,
    )


def test_our_thin_lens_is_mitsubas(renderer: Studio) -> None:
    """The aperture is 30 mm wide and focused behind the head."""
    mi = _start()
    head = stand_in(1)
    viewpoint = place_camera(head.pupils, 6.0, camera_m=0.4)
    constant = viewpoint.pixels_per_slope * AXIS_P1435LE.pitch_um / 1000
    focal_mm = 1 / (1 / constant + 1 / 600.0)
    lens = Lens("wide", f_number=focal_mm / 30.0)
    ours = [blurred(renderer, lens, seed, 600.0) for seed in range(8)]
    description = _describe_pinhole(viewpoint, FRONTAL, viewpoint.film_px, 256)
    for axis in "xy":
        del description[f"principal_point_offset_{axis}"]  # which a thin lens has none of
    description |= {"type": "thinlens", "aperture_radius": 15.0, "focus_distance": 600.0}
    sensor, scene = mi.load_dict(description), renderer._live._scene
    theirs = [
        np.array(mi.render(scene, sensor=sensor, integrator=renderer._path(), spp=256, seed=s))
        for s in range(100, 108)
    ]
    sharp = np.array([blurred(renderer, LENSES["pinhole"], seed) for seed in range(8)])
    assert_same_expectation(np.array(ours), np.array(theirs))
    assert np.abs(np.mean(ours, axis=0) - sharp.mean(axis=0)).max() > 0.01


def assert_same_expectation(ours: np.ndarray, theirs: np.ndarray) -> None:
    # Mitsuba's filter is lowered to end at zero (by e^-8); its pixels differ by up to 0.1 %.
    variance = (ours.var(axis=0, ddof=1) + theirs.var(axis=0, ddof=1)) / len(ours)
    tolerance = np.sqrt(variance + (2e-3 * ours.mean(axis=0)) ** 2)
    z = np.abs(ours.mean(axis=0) - theirs.mean(axis=0)) / tolerance
    assert z.max() < 1.5 * norm.isf(0.001 / z.size)


@pytest.fixture(scope="module")
def sharp(renderer: Studio) -> np.ndarray:
    """Eight pictures by a pinhole."""
    return np.array([blurred(renderer, LENSES["pinhole"], seed) for seed in range(50, 58)])


@pytest.mark.parametrize("name", NAMES)
def test_a_tiny_aperture_shows_what_a_pinhole_shows(
    renderer: Studio, sharp: np.ndarray, name: str
) -> None:
    tiny = preset("lens", name, f_number=2000.0)
    through_lens, pinhole = np.array([blurred(renderer, tiny, seed) for seed in range(8)]), sharp
    if name != "thin":  # cos⁴ at the edge of ±20°
        middle = through_lens.shape[1] // 2
        window = slice(middle - 3, middle + 3)
        through_lens, pinhole = (x[:, window, window] for x in (through_lens, pinhole))
        through_lens = through_lens * (pinhole.mean() / through_lens.mean())
        assert pinhole.mean() == pytest.approx(through_lens.mean(), rel=0.02)
    assert_same_expectation(through_lens, pinhole)


@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_upright_and_landmarks_are_where_it_shows_them(
    lens_renderer: Studio, name: str
) -> None:
    points = stand_in(3).landmarks
    pose = Pose("turned", yaw_deg=20, pitch_deg=10, roll_deg=15)
    result = lens_renderer.render(
        dots(points),
        pose=pose,
        ipd_px=16,
        scale=2,
        samples_per_pixel=256,
        lens=preset("lens", name, f_number=8.0),
    )
    darkness = np.clip(1 - result.image[1].numpy() / result.image[1].numpy().max(), 0, None)
    for x, y in result.landmarks_px.numpy():
        column, row = round(float(x)), round(float(y))
        window = darkness[row - 5 : row + 6, column - 5 : column + 6] ** 2
        grid = np.mgrid[-5:6, -5:6]
        seen = (grid * window).sum(axis=(1, 2)) / window.sum()
        assert seen == pytest.approx([y - row, x - column], abs=0.2)


@pytest.fixture(scope="module")
def lens_renderer() -> Studio:
    """Return a renderer of its own for the dots, whose scene is loaded once."""
    return Studio()


def test_all_lenses_share_one_kernel(renderer: Studio) -> None:
    import drjit as dr

    ask = {"ipd_px": 4, "samples_per_pixel": 64}
    for scale in (1, 2):
        renderer.render(stand_in(0), lens="thin", scale=scale, **ask)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        renderer.render(stand_in(0), lens="single", pose="left", **ask)
        renderer.render(stand_in(0), lens="double_gauss", lighting="below", scale=2, **ask)
        renderer.render(
            stand_in(0), lens=preset("lens", "single", f_number=8.0, dispersion=True), **ask
        )
        renderer.render(stand_in(0), lens=Lens("own", biconvex(2.0, 0.8, 0.7, "F2")), **ask)
        history = dr.kernel_history([dr.KernelType.JIT])
    assert len(history) >= 4
    assert [entry["hash"] for entry in history if not entry["cache_hit"]] == []


def test_a_picture_moves_behind_a_lens_as_behind_a_pinhole(renderer: Studio) -> None:
    ask = {"ipd_px": 8, "samples_per_pixel": 256, "lens": "thin"}
    still = renderer.render(stand_in(1), **ask).image
    moved = renderer.render(stand_in(1), shift_px=(1.0, -1.0), **ask).image
    apart = float((moved - still).abs().mean())
    assert float((moved[:, 1:-2, 2:-1] - still[:, 2:-1, 1:-2]).abs().mean()) < 0.3 * apart


def test_the_same_lens_gives_the_same_bytes(renderer: Studio) -> None:
    ask = {"ipd_px": 4, "samples_per_pixel": 64, "lens": "double_gauss", "seed": 3}
    first = renderer.render(stand_in(1), **ask).image
    renderer.render(stand_in(2), ipd_px=4, samples_per_pixel=64, lens="thin")
    assert renderer.render(stand_in(1), **ask).image.equal(first)


def test_mitsuba_renders_with_the_sensor(renderer: Studio) -> None:
    """As a plain sensor of ``mi.render``: the same picture as that of our film, within noise."""
    mi = _start()
    head = stand_in(1)
    scene = renderer._live.show(head, LIGHTINGS["side"], FRONTAL)
    viewpoint = place_camera(head.pupils, 6.0, camera_m=0.4)
    lens = LENSES["double_gauss"]
    sensor = _make_sensor(viewpoint, FRONTAL, viewpoint.film_px, 256, lens, 380.0)
    theirs = [
        np.array(mi.render(scene, sensor=sensor, integrator=renderer._path(), spp=256, seed=s))
        for s in range(100, 108)
    ]
    ours = [blurred(renderer, lens, seed, 380.0) for seed in range(8)]
    assert_same_expectation(np.array(ours), np.array(theirs))
    assert sensor.film().size()[0] == describe_film(viewpoint.film_px, 256)["film"]["width"]


def test_the_table_is_what_light_from_the_film_meets() -> None:
    mounted = mount(LENSES["single"], 3.0, FOCUS_MM, 0.5)
    rows = _table(mounted)
    assert rows.shape == (3, _ROW)
    np.testing.assert_allclose(rows[:, 0] - mounted.image_mm, [0.0, 1.0, 1.0], atol=3e-3)
    front, back = mounted.surfaces[1:]
    # The back face, met first, is hollow towards the film, as its centre lies towards the scene.
    np.testing.assert_allclose(rows[:2, 1], [-back.curvature_per_mm, -front.curvature_per_mm])
    assert rows[0, 4] > 1
    assert not rows[1:, 4:7].any()
    assert image_of(mounted.surfaces, FOCUS_MM)[0] == pytest.approx(mounted.image_mm)


def test_the_slow_variant_shows_the_same(renderer: Studio, slow: dict[str, np.ndarray]) -> None:
    ask = {"lighting": "side", "ipd_px": 4, "samples_per_pixel": 1024, "lens": "single"}
    fast = renderer.render(stand_in(0), **ask).image.numpy()
    assert slow["single"].mean() == pytest.approx(float(fast.mean()), rel=0.02)
    assert np.abs(slow["single"] - fast).mean() < 0.03


def test_glass_bends_each_wavelength_by_its_own_index(traced: dict[str, np.ndarray]) -> None:
    assert len(traced["lens_errors"]) > 250
    assert traced["lens_errors"].max() < 2e-6
    first = traced["lens_nm"][0]
    assert first.min() < 430 < 650 < first.max()


def test_only_the_wavelength_that_is_traced_has_a_weight(traced: dict[str, np.ndarray]) -> None:
    weight = traced["lens_weight"]
    assert (weight[0] > 0).mean() > 0.95
    assert not weight[1:].any()


def test_one_wavelength_of_four_is_right_on_average(
    traced: dict[str, np.ndarray], renderer: Studio
) -> None:
    pinhole, tiny = traced["pinhole"], traced["tiny"]
    assert tiny.mean(axis=(1, 2)) == pytest.approx(pinhole.mean(axis=(1, 2)), rel=5e-3)
    assert np.abs(tiny - pinhole).mean() < 0.02
    ask = {"lighting": "room_blue", "ipd_px": 4, "samples_per_pixel": 512}
    rgb = renderer.render(stand_in(1), **ask).image.numpy()
    # Colours of the skin times those of the light are products of spectra there, not of channels.
    assert pinhole.mean(axis=(1, 2)) == pytest.approx(rgb.mean(axis=(1, 2)), rel=0.02)
