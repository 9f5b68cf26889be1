"""The whole renderer: IPD, landmarks, the meter, same bytes, no waste, and its errors."""

import time
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import torch
from fakes.scenes import LIGHTINGS, POSES, SKINS, Studio, scene
from oracles.heads import dots, ellipsoid_part, stand_in

import lrsr.rendering
from lrsr.errors import InputError, NonFiniteError
from lrsr.identities.head import Head
from lrsr.images import linear_to_srgb
from lrsr.rendering import live_scene
from lrsr.rendering import renderer as module
from lrsr.rendering.environment import environment
from lrsr.rendering.lighting import Lighting
from lrsr.rendering.pose import Pose
from lrsr.rendering.renderer import Renderer, render
from lrsr.rendering.scene import Film
from lrsr.rendering.skin import REFLECTIVE

CLOUDY = Lighting("cloudy", (), fill_share=1.0)
FAR = Pose("far", yaw_deg=45, pitch_deg=25, roll_deg=10)


@pytest.fixture(scope="module")
def dot_renderer() -> Studio:
    """Return a renderer of its own for the dots, so that scenes are not reloaded all the time."""
    return Studio()


def centroids(darkness: np.ndarray, guesses: np.ndarray, reach: int) -> np.ndarray:
    """Find the centre of darkness in a window around each guess, px."""
    found = []
    for guess in guesses:
        x0, y0 = np.round(guess).astype(int) - reach
        window = darkness[y0 : y0 + 2 * reach + 1, x0 : x0 + 2 * reach + 1]
        y, x = np.mgrid[: window.shape[0], : window.shape[1]]
        found.append(
            [x0 + (window * x).sum() / window.sum(), y0 + (window * y).sum() / window.sum()]
        )
    return np.array(found)


@pytest.mark.parametrize("pose", [*POSES.values(), FAR], ids=lambda pose: pose.name)
def test_landmarks_are_where_the_picture_shows_them(dot_renderer: Studio, pose: Pose) -> None:
    points = stand_in(3).landmarks
    result = dot_renderer.render(
        dots(points), pose=pose, lighting=CLOUDY, ipd_px=16, scale=4, samples_per_pixel=1024
    )
    expected = result.landmarks_px.numpy()
    seen = centroids(1 - result.image[1].numpy(), expected, reach=7)
    np.testing.assert_allclose(seen, expected, atol=0.08)


@pytest.mark.parametrize("scale", [1, 4])
def test_a_face_that_has_moved_is_where_its_landmarks_say(dot_renderer: Studio, scale: int) -> None:
    ask = {"lighting": CLOUDY, "ipd_px": 16, "scale": scale, "samples_per_pixel": 1024}
    points = stand_in(3).landmarks
    moved = dot_renderer.render(dots(points), shift_px=(1.7, -2.3), **ask)
    seen = centroids(1 - moved.image[1].numpy(), moved.landmarks_px.numpy(), reach=2 + scale)
    np.testing.assert_allclose(seen, moved.landmarks_px.numpy(), atol=0.08)
    still = dot_renderer.render(dots(points), **ask)
    shift = (moved.landmarks_px - still.landmarks_px).numpy()
    np.testing.assert_allclose(shift, np.full((5, 2), (1.7, -2.3)) * scale, atol=1e-4)


def test_who_comes_nearer_is_larger_by_as_much(dot_renderer: Studio) -> None:
    result = dot_renderer.render(dots(stand_in(3).landmarks), lighting=CLOUDY, nearer=0.2)
    eyes = centroids(1 - result.image[1].numpy(), result.landmarks_px.numpy()[:2], reach=3)
    assert result.ipd_px == 8 / 0.8
    assert np.hypot(*(eyes[1] - eyes[0])) == pytest.approx(10, abs=0.05)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_the_ipd_in_the_picture_is_what_was_asked_for(dot_renderer: Studio, seed: int) -> None:
    points = stand_in(seed).landmarks
    result = dot_renderer.render(dots(points), lighting=CLOUDY, ipd_px=8)
    eyes = centroids(1 - result.image[1].numpy(), result.landmarks_px.numpy()[:2], reach=3)
    assert np.hypot(*(eyes[1] - eyes[0])) == pytest.approx(8, abs=0.05)
    assert result.ipd_px == 8.0


@pytest.mark.parametrize("pose", [*POSES.values(), FAR], ids=lambda pose: pose.name)
def test_landmarks_stay_well_inside_the_frame(pose: Pose, monkeypatch: pytest.MonkeyPatch) -> None:
    quick = Studio()
    monkeypatch.setattr(quick._live, "show", lambda *_: None)
    monkeypatch.setattr(quick, "_path", lambda: None)
    monkeypatch.setattr(module, "expose", lambda *_, **__: np.zeros((32, 32, 3), np.float32))
    for seed in range(20):
        landmarks = quick.render(stand_in(seed), pose=pose).landmarks_px
        assert landmarks.min() > 2
        assert landmarks.max() < 29


@pytest.fixture(scope="module")
def sphere_renderer() -> Studio:
    """Return a renderer of its own for the sphere, whose scene is loaded once."""
    return Studio()


def lambert(_: object, textures: Mapping[str, object]) -> tuple[dict[str, Any], dict[str, str]]:
    diffuse = {"type": "diffuse", "reflectance": textures["albedo"]}
    return diffuse, {"albedo": "reflectance.data"}


@pytest.mark.parametrize("name", LIGHTINGS)
def test_the_meter_reads_what_a_grey_sphere_sends(
    name: str, monkeypatch: pytest.MonkeyPatch, sphere_renderer: Studio
) -> None:
    monkeypatch.setattr(live_scene, "bsdf", lambert)
    radius, distance = 60.0, 1e4
    ball = ellipsoid_part("skin", "skin", (radius,) * 3, (0, -12.6, 0), np.full((2, 2, 3), 0.18))
    pupils = np.array([[-31.5, 0, 0], [31.5, 0, 0]])
    head = Head("sphere", (ball,), pupils, np.zeros((5, 3)))
    result = sphere_renderer.render(
        head, lighting=name, ipd_px=16, samples_per_pixel=512, camera_m=distance / 1000
    )
    side = result.image.shape[-1]
    y, x = np.mgrid[:side, :side] - (side - 1) / 2
    disc = x**2 + y**2 < (16 * radius / 63) ** 2
    backdrop = float(result.image[1, 0, 0])
    area = np.pi * (16 * radius / 63) ** 2
    # Pixels of the rim are part backdrop: take the whole frame, less what the backdrop fills.
    sphere = (float(result.image[1].sum()) - backdrop * (side**2 - area)) / area
    assert disc.sum() == pytest.approx(area, rel=0.05)
    assert sphere / 0.18 == pytest.approx(result.metered, rel=0.01)


def test_what_a_radiance_says(renderer: Studio, head: Head) -> None:
    result = renderer.render(
        head, pose="up", lighting="below", ipd_px=4.2, scale=2, samples_per_pixel=64, seed=5
    )
    assert result.image.shape == (3, 32, 32)
    assert result.image.dtype == torch.float32
    assert result.landmarks_px.shape == (5, 2)
    assert result.landmarks_px.dtype == torch.float32
    assert result.metered == environment(LIGHTINGS["below"])[1]
    assert (result.ipd_px, result.scale, result.traits) == (4.2, 2, None)
    assert (result.edges_nm, result.metered_bands) == (None, None)


def test_the_same_request_is_the_same_bytes_whoever_came_before(renderer: Studio) -> None:
    ask = {"pose": "down", "lighting": "side", "ipd_px": 4, "samples_per_pixel": 64}
    first = renderer.render(stand_in(1), **ask)
    renderer.render(stand_in(2), pose="left", ipd_px=4, samples_per_pixel=16)
    assert renderer.render(stand_in(1), **ask).image.equal(first.image)


def test_another_seed_is_other_noise_about_the_same_light(renderer: Studio, head: Head) -> None:
    a, b = (renderer.render(head, ipd_px=4, samples_per_pixel=256, seed=s).image for s in (0, 1))
    assert not a.equal(b)
    assert float(a.mean()) == pytest.approx(float(b.mean()), rel=2e-3)


@pytest.mark.parametrize(
    ("scale", "rays", "samples"),
    [
        *[(1, 2048, 2048), (2, 2048, 512), (4, 2048, 128)],
        *[(4, 64, 16), (1, 4, 4), (2, 4, 4), (1, 1, 1)],
    ],
)
def test_every_scale_has_the_same_rays_and_no_pixel_fewer_than_16_unless_asked(
    scale: int, rays: int, samples: int, head: Head, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked = {}
    quick = Studio()
    monkeypatch.setattr(quick._live, "show", lambda *_: None)
    monkeypatch.setattr(quick, "_path", lambda: None)

    def record(*_: object, **settings: int) -> np.ndarray:
        asked.update(settings)
        return np.zeros((1, 1, 3), np.float32)

    monkeypatch.setattr(module, "expose", record)
    quick.render(head, scale=scale, samples_per_pixel=rays)
    assert (asked["scale"], asked["samples"]) == (scale, samples)


@pytest.mark.parametrize("lighting", ["frontal", "side"])
def test_2048_samples_leave_no_fireflies(renderer: Studio, lighting: str) -> None:
    a, b = (renderer.render(stand_in(1), lighting=lighting, ipd_px=6, seed=s) for s in (0, 1))
    shown = [255 * linear_to_srgb(picture.image / picture.metered) for picture in (a, b)]
    difference = (shown[0] - shown[1]).abs() / 2**0.5
    assert float(difference.median()) < 0.5
    assert float(difference.max()) < 4


def test_heads_poses_lights_and_seeds_compile_nothing_new(renderer: Studio) -> None:
    import drjit as dr

    ask = {"ipd_px": 4, "samples_per_pixel": 64}
    for scale in (1, 2):
        renderer.render(stand_in(0), scale=scale, **ask)
        renderer.render(stand_in(1), scale=scale, pose="up", lighting="below", **ask)
    with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
        dr.kernel_history_clear()
        for number, (pose, lighting) in enumerate(zip(POSES, LIGHTINGS, strict=True)):
            for scale in (1, 2):
                settings = {"pose": pose, "lighting": lighting, "seed": 7 + number}
                settings["nearer"] = number / 100
                renderer.render(stand_in(2 + number), scale=scale, **settings, **ask)
        history = dr.kernel_history([dr.KernelType.JIT])
    assert len(history) > 8
    assert [entry["hash"] for entry in history if not entry["cache_hit"]] == []


def test_the_slow_variant_renders_the_same(renderer: Studio, slow: dict[str, np.ndarray]) -> None:
    ask = {"lighting": "side", "ipd_px": 4, "samples_per_pixel": 1024, "shift_px": (0.9, -0.7)}
    fast = renderer.render(stand_in(0), **ask).image.numpy()
    assert slow["pinhole"].shape == fast.shape
    assert slow["pinhole"].mean() == pytest.approx(float(fast.mean()), rel=0.02)
    assert np.abs(slow["pinhole"] - fast).mean() < 0.03


def test_a_pixel_that_is_no_number_names_who_and_how(renderer: Studio, head: Head) -> None:
    skin = head.parts[0]
    broken = replace(skin, albedo=np.full_like(skin.albedo, np.nan))
    ghost = replace(head, identity_id="ghost", parts=(broken, *head.parts[1:]))
    with pytest.raises(NonFiniteError, match="head ghost, pose up, lighting side"):
        renderer.render(ghost, pose="up", lighting="side", ipd_px=4, samples_per_pixel=16)


@pytest.mark.parametrize("wrong", [{"samples_per_pixel": 0}, {"seed": -1}, {"camera_m": -1}])
def test_numbers_out_of_range_are_refused(renderer: Studio, head: Head, wrong: dict) -> None:
    with pytest.raises(InputError, match="give"):
        renderer.render(head, **wrong)


def test_a_depth_without_light_is_refused(head: Head) -> None:
    with pytest.raises(InputError, match=r"rendering\.max_depth=1: wanted 2 to"):
        render(head, max_depth=1)


@pytest.mark.parametrize("group", ["pose", "lighting", "lens", "standpoint", "skin"])
def test_a_name_that_does_not_exist_is_refused_before_any_work(head: Head, group: str) -> None:
    with pytest.raises(InputError, match=f"{group}=wax: there is none"):
        render(head, **{group: "wax"})


def test_names_are_turned_into_the_values_of_their_files(
    head: Head, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[object, ...]] = []

    class Recorder:
        def render(self, *values: object, **more: object) -> None:
            asked.append((*values, more))

    monkeypatch.setattr(module, "shared_renderer", lambda *key: asked.append(key) or Recorder())
    named = {"pose": "left", "lighting": "room_blue", "lens": "single", "standpoint": "scface_far"}
    render(head, **named, skin="tone", ipd_px=9, scale=2, samples_per_pixel=32, seed=3)
    assert asked == [
        (SKINS["subsurface_tone"], 5),
        (head, scene(**named), Film(9.0, 2), {"samples_per_pixel": 32, "seed": 3}),
    ]


def test_the_module_renders_with_one_shared_renderer(
    head: Head, renderer: Studio, monkeypatch: pytest.MonkeyPatch
) -> None:
    shared = module.shared_renderer
    assert shared(REFLECTIVE, 5) is shared(REFLECTIVE, 5)
    assert shared(REFLECTIVE, 5) is not shared(REFLECTIVE, 6)
    plain = Renderer.render
    monkeypatch.setattr(
        module, "shared_renderer", lambda *_: SimpleNamespace(render=partial(plain, renderer))
    )
    assert render(head, ipd_px=4, samples_per_pixel=16).image.shape == (3, 16, 16)
    skin = replace(head.parts[0], albedo=np.full_like(head.parts[0].albedo, np.nan))
    ghost = replace(head, parts=(skin, *head.parts[1:]))
    with pytest.raises(NonFiniteError, match="stand-in-0"):
        render(ghost, ipd_px=4, samples_per_pixel=16)


def test_threads_that_ask_at_once_get_one_renderer(monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []

    class Slow:
        def __init__(self, *_: object, **__: object) -> None:
            time.sleep(0.05)
            made.append(self)

    monkeypatch.setattr(module, "Renderer", Slow)
    skin = replace(REFLECTIVE, name="of this test alone")
    with ThreadPoolExecutor(4) as pool:
        found = list(pool.map(lambda _: module.shared_renderer(skin, 5), range(4)))
    assert found == made * 4


def test_the_folder_offers_its_names_and_no_others() -> None:
    assert lrsr.rendering.Renderer is Renderer
    assert all(getattr(lrsr.rendering, name) for name in lrsr.rendering.__all__)
    with pytest.raises(AttributeError, match="no attribute 'Camera'"):
        _ = lrsr.rendering.Camera
