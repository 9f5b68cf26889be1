from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import torch
from scipy.ndimage import gaussian_filter

from lrsr.camera import Camera
from lrsr.camera.codec import Jpeg, jpeg
from lrsr.camera.encoding import encode
from lrsr.errors import ImageContractError, InputError
from lrsr.images import srgb_to_linear
from lrsr.presets import preset
from lrsr.training.shrinking.one_camera import OneCamera
from lrsr.training.shrinking.random_cameras import RandomCameras

SHIPPED: RandomCameras = preset("degradation", "random_cameras")
NOTHING = replace(
    SHIPPED,
    blur_px=(0, 0),
    elongation=(1, 1),
    exposure_ev=(0, 0),
    noise_share=0,
    mosaic_share=0,
    denoise_px=(0, 0),
    sharpen_amount=(0, 0),
    jpeg_share=0,
)


def small(degradation: RandomCameras, true: torch.Tensor, first: int = 0) -> torch.Tensor:
    seeds = list(range(first, first + len(true)))
    return torch.cat([few for few, _ in degradation(true, 2, seeds, Camera())])


def test_without_any_flaw_it_is_the_reference_camera(pictures: torch.Tensor) -> None:
    ((wanted, _),) = OneCamera()(pictures, 2, [0] * 4, Camera())
    assert torch.equal(small(NOTHING, pictures), wanted)


def test_a_round_blur_is_scipys_gaussian_in_linear_light(pictures: torch.Tensor) -> None:
    blurred = small(replace(NOTHING, blur_px=(1, 1)), pictures)[0, 0]
    light = srgb_to_linear(pictures[0, 0]).numpy().astype(float)
    wanted = gaussian_filter(light, 2.0, mode="nearest", truncate=3.0)
    wanted = wanted.reshape(24, 2, 24, 2).mean((1, 3))
    assert np.abs(blurred.numpy() - encode(torch.from_numpy(wanted)).numpy()).max() < 1.5 / 255


def test_exposure_changes_both_pictures(pictures: torch.Tensor) -> None:
    darker = replace(NOTHING, exposure_ev=(-1, -1))
    ((few, true),) = darker(pictures, 2, [0, 1, 2, 3], Camera())
    assert torch.equal(true, encode(srgb_to_linear(pictures) / 2))
    assert float(few.mean()) == pytest.approx(float(true.mean()), abs=0.02)


def test_fewer_electrons_are_more_noise() -> None:
    grey = torch.full((4, 3, 64, 64), 0.5).mul(255).round().div(255)
    noisy = replace(NOTHING, noise_share=1, read_noise_e=(0, 0))
    spread = [
        float(small(replace(noisy, white_e=(electrons, electrons)), grey).std())
        for electrons in (500, 8000)
    ]
    assert spread[0] / spread[1] == pytest.approx(4, rel=0.2)


def test_compression_is_the_codecs_at_a_random_place_of_its_grid(pictures: torch.Tensor) -> None:
    heavy = replace(NOTHING, jpeg_share=1, jpeg_quality=(15, 15), chromas=["4:2:0"])
    drawn = [np.random.default_rng(seed) for seed in (0, 9)]
    assert [rng.uniform() for rng in drawn]  # the exposure comes first
    places = [heavy._camera(rng).origin_px for rng in drawn]
    assert places[0] != places[1]
    for seed, place in zip((0, 9), places, strict=True):
        wanted = jpeg(small(NOTHING, pictures), 15, origin_px=place)
        assert torch.equal(small(heavy, pictures, seed), wanted)


def test_a_mosaic_mixes_colours_where_they_change(pictures: torch.Tensor) -> None:
    colours = pictures.clone()
    colours[:, 0] = 1 - colours[:, 0]
    mixed = small(replace(NOTHING, mosaic_share=1, methods=["bilinear"]), colours)
    assert float((mixed - small(NOTHING, colours)).abs().max()) > 0.05


def test_pictures_of_one_group_share_a_camera_and_no_others() -> None:
    grey = torch.full((6, 3, 16, 16), 0.5).mul(255).round().div(255)
    drawn = small(replace(NOTHING, exposure_ev=(-1, 1), group=3), grey).mean((1, 2, 3))
    assert len(set(drawn[:3].tolist())) == len(set(drawn[3:].tolist())) == 1
    assert drawn[0] != drawn[3]


def test_shares_are_met_over_many_groups() -> None:
    drawn = [SHIPPED._camera(np.random.default_rng(seed)) for seed in range(200)]
    stages = ("mosaic", "stored", "sensor")
    shares = [sum(getattr(one, name) is not None for one in drawn) / 200 for name in stages]
    wanted = [SHIPPED.mosaic_share, SHIPPED.jpeg_share, SHIPPED.noise_share]
    assert shares == pytest.approx(wanted, abs=0.1)
    qualities = [one.stored.qualities[0] for one in drawn if isinstance(one.stored, Jpeg)]
    assert (min(qualities), max(qualities)) == pytest.approx((15, 95), abs=3)


def test_a_small_picture_without_room_for_a_mosaic_is_refused() -> None:
    with pytest.raises(ImageContractError, match="wanted 3 x 3 or more"):
        small(replace(NOTHING, mosaic_share=1), torch.zeros(1, 3, 4, 4))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"blur_px": (1, 0)}, r"degradation.blur_px=\[1,0\]: .* the least first"),
        ({"noise_share": 2}, "degradation.noise_share=2: wanted 0 to 1"),
        ({"jpeg_quality": (0, 95)}, r"degradation.jpeg_quality=\[0,95\]: wanted 1 to 100"),
        ({"white_e": (0, 95)}, r"degradation.white_e=\[0,95\]: wanted 10 to"),
        ({"group": 0}, "degradation.group=0: wanted 1 to 4096"),
        ({"methods": ["best"]}, "method=best: wanted one of bilinear"),
        ({"chromas": []}, r"degradation.chromas=\[\]: wanted at least one"),
        ({"chromas": "4:2:0"}, "degradation.chromas=4:2:0: wanted a list"),
    ],
)
def test_what_cannot_be_drawn_is_refused(wrong: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        replace(SHIPPED, **wrong)
