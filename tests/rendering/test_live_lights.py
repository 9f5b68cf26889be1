"""Panels in the live scene: metered rightly, turned with the world, moved without a recompile."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pytest
from fakes.scenes import ROOMS, Studio
from oracles.heads import ellipsoid_part, stand_in

from lrsr.identities.head import Head
from lrsr.rendering import live_scene
from lrsr.rendering.backend import _start
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.lights import Light, Panel
from lrsr.rendering.live_lights import _opaque, describe_panels, map_data, move_panels

LAMP = Panel((400.0, 250.0, 700.0), 200.0, 300.0, kelvin=3500.0)
ASK = {"ipd_px": 4.0, "samples_per_pixel": 64}


@pytest.fixture(scope="module")
def lit() -> Studio:
    """Return a renderer of its own, whose scene has panels."""
    return Studio()


def lambert(_: object, textures: Mapping[str, object]) -> tuple[dict[str, Any], dict[str, str]]:
    diffuse = {"type": "diffuse", "reflectance": textures["albedo"]}
    return diffuse, {"albedo": "reflectance.data"}


@pytest.mark.parametrize("name", [*ROOMS, "lamp"])
def test_the_meter_reads_what_a_small_grey_sphere_between_the_eyes_sends(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(live_scene, "bsdf", lambert)
    lighting = ROOMS.get(name, Lighting("lamp", fill_share=0.1, panels=(LAMP,)))
    radius = 6.0
    grey = np.full((2, 2, 3), 0.18)
    ball = ellipsoid_part("skin", "skin", (radius,) * 3, (0, -1.26, 0), grey, 48, 96)
    head = Head("ball", (ball,), np.array([[-3.15, 0, 0], [3.15, 0, 0]]), np.zeros((5, 3)))
    result = Studio().render(
        head, lighting=lighting, ipd_px=16, samples_per_pixel=512, camera_m=10.0
    )
    luminance = np.tensordot([0.2126, 0.7152, 0.0722], result.image.numpy(), axes=1)
    area = np.pi * (16 * radius / 6.3) ** 2
    backdrop = luminance[0, 0]
    sphere = (luminance.sum() - backdrop * (luminance.size - area)) / area
    assert sphere / 0.18 == pytest.approx(result.metered, rel=0.015)


def test_a_far_panel_lights_a_face_as_a_far_disc_does(lit: Studio) -> None:
    light = Light(azimuth_deg=50.0, elevation_deg=20.0, diameter_deg=12.0)
    side = 1e5 * np.sqrt(2 * np.pi * (1 - np.cos(np.radians(6.0))))
    panel = Panel(tuple((1e5 * light.direction()).tolist()), side, side)
    ask = {"ipd_px": 4.0, "samples_per_pixel": 1024, "pose": "left"}
    by_disc = lit.render(stand_in(1), lighting=Lighting("disc", (light,)), **ask)
    by_panel = lit.render(stand_in(1), lighting=Lighting("panel", panels=(panel,)), **ask)
    seen, wanted = (r.image.numpy() / r.metered for r in (by_panel, by_disc))
    assert np.abs(seen - wanted).mean() < 0.02 * wanted.mean()
    assert np.abs(seen - wanted).max() < 0.1


@pytest.mark.parametrize(("x", "brighter"), [(900.0, "right"), (-900.0, "left")])
@pytest.mark.parametrize("pose", ["frontal", "left"])
def test_a_panel_stays_where_it_is_when_the_head_turns(
    lit: Studio, x: float, brighter: str, pose: str
) -> None:
    lighting = Lighting("beside", fill_share=0.05, panels=(Panel((x, 0.0, 300.0), 200.0, 200.0),))
    image = lit.render(stand_in(1, grey=0.5), lighting=lighting, pose=pose, **ASK).image.mean(0)
    middle = image[6:10]
    halves = {"left": float(middle[:, 3:8].mean()), "right": float(middle[:, 8:13].mean())}
    assert max(halves, key=lambda half: halves[half]) == brighter


def test_moved_panels_give_the_bytes_of_a_fresh_scene_and_compile_nothing(lit: Studio) -> None:
    import drjit as dr

    one, other = (
        Lighting("lamp", panels=(panel,)) for panel in (LAMP, ROOMS["room_blue"].panels[0])
    )
    lit.render(stand_in(1), lighting=one, pose="up", **ASK)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        moved = lit.render(stand_in(2), lighting=other, pose="left", **ASK)
        history = dr.kernel_history([dr.KernelType.JIT])
    assert [entry["hash"] for entry in history if not entry["cache_hit"]] == []
    fresh = Studio().render(stand_in(2), lighting=other, pose="left", **ASK)
    assert moved.image.equal(fresh.image)


def test_a_lighting_without_panels_is_the_same_before_and_after(lit: Studio) -> None:
    first = lit.render(stand_in(1), lighting="side", **ASK)
    lit.render(stand_in(1), lighting="room_yellow", **ASK)
    assert lit.render(stand_in(1), lighting="side", **ASK).image.equal(first.image)


def test_a_scene_has_as_many_rectangles_as_panels() -> None:
    lighting = Lighting("two", panels=(LAMP, LAMP))
    mi = _start()
    assert list(describe_panels(lighting)) == ["panel_0", "panel_1"]
    assert describe_panels(Lighting("none", (Light(0, 0),))) == {}
    scene = mi.load_dict({"type": "scene", **describe_panels(lighting)})
    parameters = mi.traverse(scene)
    move_panels(parameters, lighting, np.eye(4))
    parameters.update()
    corner = np.array(parameters["panel_1.to_world"].matrix)[:3, 3].ravel()
    np.testing.assert_allclose(corner, LAMP.position_mm, rtol=1e-5)
    colour = np.array(parameters["panel_0.emitter.radiance.value"]).ravel()
    np.testing.assert_allclose(colour / colour[1], LAMP.colour / LAMP.colour[1], rtol=1e-5)
    assert np.array(_opaque(mi.Color3f(1, 2, 3))).ravel().tolist() == [1, 2, 3]


def test_a_map_is_kept_with_copies_of_its_outer_columns(lit: Studio) -> None:
    painted = np.random.default_rng(0).uniform(0, 1, (4, 8, 3)).astype(np.float32)
    mi = _start()
    emitter = mi.load_dict({"type": "envmap", "bitmap": mi.Bitmap(painted.copy())})
    wanted = np.array(mi.traverse(emitter)["data"])
    np.testing.assert_array_equal(np.array(map_data(painted, wanted.shape[1])), wanted)
