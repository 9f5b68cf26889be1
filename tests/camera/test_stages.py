"""One photograph, step by step: every step is what the camera really made on the way."""

import pytest
import torch

from lrsr.camera import Camera, Colour, Jpeg, Mosaic, Optics, Processing, Sensor, Video
from lrsr.camera.exposure import KEY
from lrsr.camera.optics import bin_pixels
from lrsr.camera.stages import show_stages
from lrsr.errors import InputError
from lrsr.images import linear_to_srgb

pytestmark = pytest.mark.usefixtures("one_thread")

LIGHT = torch.rand(2, 3, 24, 32, generator=torch.Generator().manual_seed(0)) * 0.6
METERED, SEEDS = torch.ones(2), [1, 2]
STAGES = {
    "optics": Optics(f_number=1.4, defocus_um=5.0),
    "colour": Colour(((0.5, 0.1, 0.0), (0.1, 0.8, 0.1), (0.0, 0.1, 0.6))),
    "mosaic": Mosaic("GBRG"),
    "sensor": Sensor(2000.0),
    "processing": Processing(sharpen_amount=0.5),
    "stored": Jpeg(60),
}
STEPS = ["film", "lens", "pixels", "raw", "interpolated", "colours", "processed", "stored"]


def camera(compression: str = "none", **changes: object) -> Camera:
    return Camera(compression, supersampling=2, origin_px=(3, 4), **{**STAGES, **changes})


def test_all_steps_come_in_the_order_of_the_light() -> None:
    assert list(show_stages(camera(), LIGHT, METERED, SEEDS)) == STEPS
    assert list(show_stages(camera("heavy"), LIGHT, METERED, SEEDS)) == [*STEPS, "picture"]


def test_the_last_step_is_the_picture_that_the_camera_takes() -> None:
    taken_by = camera("heavy")
    steps = show_stages(taken_by, LIGHT, METERED, SEEDS)
    assert torch.equal(steps["picture"], taken_by(LIGHT, METERED, SEEDS))
    assert torch.equal(steps["stored"], camera()(LIGHT, METERED, SEEDS))


def test_each_step_is_what_the_stage_makes_of_the_step_before() -> None:
    steps = show_stages(camera(), LIGHT, METERED, SEEDS)
    film = LIGHT * KEY
    blurred = STAGES["optics"](film, supersampling=2)
    assert torch.equal(steps["film"], linear_to_srgb(film))
    assert torch.equal(steps["lens"], linear_to_srgb(blurred))
    assert torch.equal(steps["pixels"], linear_to_srgb(bin_pixels(blurred, 2)))
    filtered = STAGES["mosaic"].filter(STAGES["colour"].filter(bin_pixels(blurred, 2)), (3, 4))
    counted = STAGES["sensor"].light(STAGES["sensor"](filtered, SEEDS, origin_px=(3, 4)))
    assert torch.equal(steps["interpolated"], linear_to_srgb(STAGES["mosaic"](counted, (3, 4))))
    assert torch.equal(steps["raw"].amax(1, keepdim=True), linear_to_srgb(counted))


def test_a_raw_photosite_shows_its_own_colour_alone() -> None:
    raw = show_stages(camera(), LIGHT, METERED, SEEDS)["raw"]
    # GBRG at (3, 4) starts with the second letter: blue, green / green, red.
    assert bool((raw[:, :2, ::2, ::2] == 0).all())
    assert bool((raw[:, 1:, 1::2, 1::2] == 0).all())
    assert float(raw[:, 1, ::2, 1::2].min()) > 0


def test_steps_that_a_camera_lacks_are_left_out() -> None:
    assert list(show_stages(Camera(), LIGHT, METERED)) == ["film", "picture"]
    chips = show_stages(camera(mosaic=None, processing=None, stored=None), LIGHT, METERED, SEEDS)
    assert list(chips) == ["film", "lens", "pixels", "raw", "colours", "picture"]
    assert chips["raw"].shape == (2, 3, 12, 16)


def test_of_a_recording_the_last_exposure_is_shown() -> None:
    taken_by = camera(stored=Video(frames=2))
    light = taken_by.gather(LIGHT * KEY)
    last = taken_by.develop(light, SEEDS, 1)
    processed = show_stages(taken_by, LIGHT, METERED, SEEDS)["processed"]
    assert torch.equal((processed * 255).round() / 255, last)


def test_the_camera_forgets_the_walk_even_when_it_fails() -> None:
    taken_by = camera()
    with pytest.raises(InputError, match="is noisy: give seeds"):
        show_stages(taken_by, LIGHT, METERED)
    show_stages(taken_by, LIGHT, METERED, SEEDS)
    assert not any(stage._forward_hooks for stage in taken_by.children())
