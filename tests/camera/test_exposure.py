"""The exposure follows the light, never the subject."""

import pytest
import torch

from lrsr.camera.camera import Camera
from lrsr.camera.exposure import KEY, check_is_light, expose
from lrsr.errors import ImageContractError, NonFiniteError
from lrsr.images import linear_to_srgb

METERED = torch.tensor([2.0])


def film(value: float, batch: int = 1) -> torch.Tensor:
    return torch.full((batch, 3, 2, 2), value)


def test_a_white_sphere_averages_the_key() -> None:
    # Radiance.metered is what a white sphere sends on average.
    assert float(expose(film(2.0), METERED).mean()) == pytest.approx(KEY)


def test_a_face_of_medium_tone_lies_in_the_middle_of_srgb() -> None:
    srgb = float(linear_to_srgb(expose(film(0.35 * 2.0), METERED)).mean())
    assert 0.55 < srgb < 0.65


def test_the_lit_side_of_a_fair_face_does_not_clip() -> None:
    # Albedo 0.7; seen from its light a Lambertian sphere peaks at 3/2 of its mean.
    assert float(expose(film(0.7 * 1.5 * 2.0), METERED).max()) < 1.0


@pytest.mark.parametrize("stops", [-2.0, 0.5, 1.0])
def test_a_stop_doubles_the_light(stops: float) -> None:
    corrected, plain = expose(film(1.0), METERED, stops), expose(film(1.0), METERED)
    assert torch.allclose(corrected, plain * 2.0**stops)


def test_ten_times_the_light_gives_the_same_picture() -> None:
    assert torch.allclose(expose(film(1.0), METERED), expose(film(10.0), METERED * 10))


def test_each_image_has_its_own_meter() -> None:
    exposed = expose(film(1.0, batch=2), torch.tensor([1.0, 4.0]))
    assert torch.allclose(exposed[0], 4 * exposed[1])


def test_light_beyond_white_is_not_clipped_here() -> None:
    assert float(expose(film(100.0), METERED).max()) > 1.0


@pytest.mark.parametrize(
    "metered",
    [[0.0], [-1.0], [float("nan")], [float("inf")], [1.0, 1.0], []],
    ids=["zero", "negative", "nan", "infinite", "too many", "none"],
)
def test_a_meter_that_reads_no_light_is_refused(metered: list[float]) -> None:
    with pytest.raises(ImageContractError, match="metered: got"):
        expose(film(1.0), torch.tensor(metered))


def test_broken_light_is_refused() -> None:
    with pytest.raises(ImageContractError, match="linear: got shape"):
        expose(torch.zeros(3, 2, 2), METERED)
    with pytest.raises(NonFiniteError, match="linear: nan"):
        expose(film(float("nan")), METERED)


def test_a_little_below_black_is_no_light() -> None:
    linear = torch.full((1, 3, 8, 8), 0.5)
    linear[:, 0, 2:4] = -0.2  # a colour that sRGB has not, or a filter's undershoot
    dark = Camera()(linear, torch.ones(1))[:, 0, 2:4]
    assert float(dark.max()) == 0.0


@pytest.mark.parametrize("low", [-1.0, -0.3, -1e-6], ids=["normalised", "much", "dark"])
def test_what_is_no_light_is_refused(low: float) -> None:
    linear = torch.zeros(2, 3, 2, 2)
    linear[1, 0, 0] = torch.tensor([low, abs(low)])
    with pytest.raises(ImageContractError, match="in image 1, wanted light, which is 0 or more"):
        Camera()(linear, torch.ones(2))


def test_darkness_is_light() -> None:
    assert float(check_is_light(torch.zeros(1, 3, 2, 2)).sum()) == 0.0
