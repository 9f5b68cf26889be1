"""Cameras with measured filters look at bands; others at what an observer sees of them."""

import numpy as np
import pytest
import torch

from lrsr.camera.spectral import SpectralColour, _weigh, needed, observe
from lrsr.errors import ImageContractError, InputError
from lrsr.spectra import Spectrum, _observer, average, band_edges, daylight, srgb_weights

EDGES = band_edges(35)
NM = np.arange(380.0, 731.0)
LAMP = average(NM, (560 / NM)[None] ** 5 / np.expm1(1.4388e7 / (2848 * NM)), EDGES)[0]
LAMP /= _observer(EDGES)[1] @ LAMP
WHITES = tuple(tuple(light.tolist()) for light in (daylight(EDGES), LAMP))
BOTH = Spectrum(EDGES, WHITES)


def film(level: float = 1.0) -> torch.Tensor:
    """Return a white wall in daylight and in the light of a lamp, ``(2, 35, 4, 4)``."""
    return level * torch.tensor(WHITES)[:, :, None, None].expand(2, 35, 4, 4)


def shown(colour: SpectralColour, light: torch.Tensor, spectrum: Spectrum = BOTH) -> torch.Tensor:
    """Return what three chips without noise make of light."""
    raw = colour.filter(light, spectrum)
    gains = colour.gains(spectrum, (light.shape[2], light.shape[3])).to(raw)
    return colour((raw * gains).clamp_max(1.0), spectrum)


def test_the_light_of_the_scene_becomes_white() -> None:
    colour = SpectralColour(balance="scene")
    white = shown(colour, film(0.9))
    np.testing.assert_allclose(white.numpy(), 0.9, rtol=1e-5)


def test_fixed_balance_leaves_rooms_their_hue() -> None:
    colour = SpectralColour(balance="daylight")
    day, lamp = shown(colour, film(0.4)).mean((2, 3)).tolist()
    assert day == pytest.approx([0.4] * 3, rel=1e-5)
    assert lamp[0] > lamp[1] > lamp[2] > 0
    # sRGB of illuminant A of luminance 0.4, as the observer has it, to what the filters miss.
    assert lamp == pytest.approx((0.4 * srgb_weights(EDGES) @ LAMP).tolist(), abs=0.1)


def test_filters_are_sums_over_bands() -> None:
    colour = SpectralColour()
    light = torch.rand(2, 35, 3, 5, generator=torch.Generator().manual_seed(0))
    raw = colour.filter(light, BOTH)
    weights = colour.sensitivities.weights(EDGES)
    assert raw.shape == (2, 3, 3, 5)
    by_hand = sum(weights[2, band] * light[1, band, 2, 4].item() for band in range(35))
    assert raw[1, 2, 2, 4].item() == pytest.approx(by_hand, rel=1e-5)


def test_white_clips() -> None:
    colour = SpectralColour()
    np.testing.assert_allclose(shown(colour, film(5.0)).numpy(), 1.0, rtol=1e-5)


def test_a_balance_that_misses_leaves_a_cast() -> None:
    colour = SpectralColour(cast=(0.9, 1.0, 0.8))
    balanced = colour.rendition(EDGES, WHITES[1])
    raw = colour.sensitivities.weights(EDGES) @ LAMP
    assert balanced.gains * raw == pytest.approx([0.9, 1.0, 0.8])


def test_what_is_found_for_a_light_is_found_once() -> None:
    colour = SpectralColour()
    assert colour.rendition(EDGES, WHITES[1]) is colour.rendition(EDGES, WHITES[1])
    assert not np.allclose(
        colour.rendition(EDGES, WHITES[0]).matrix, colour.rendition(EDGES, WHITES[1]).matrix
    )


def test_a_picture_does_not_depend_on_its_batch() -> None:
    colour = SpectralColour()
    light = torch.rand(2, 35, 9, 7, generator=torch.Generator().manual_seed(1))
    together = shown(colour, light)
    for i in range(2):
        alone = Spectrum(EDGES, (WHITES[i],))
        picture = shown(colour, light[i : i + 1], alone)
        assert torch.equal(picture[0], together[i])


def test_the_gradient_reaches_every_band() -> None:
    colour = SpectralColour()
    light = (0.3 * film()).double()
    few = light[:, :, :1, :1].detach().clone().requires_grad_()
    assert torch.autograd.gradcheck(lambda bands: shown(colour, bands), (few,), atol=1e-6)


def test_an_observer_sees_daylight_white_or_what_he_is_adapted_to() -> None:
    day, lamp = observe(film(0.5), BOTH).mean((2, 3)).tolist()
    assert day == pytest.approx([0.5] * 3, rel=1e-5)
    assert lamp[0] > 1.5 * lamp[1] > 2 * lamp[2]
    adapted = observe(film(0.5), BOTH, adapted=True)
    np.testing.assert_allclose(adapted.numpy(), 0.5, rtol=1e-5)


def test_each_image_is_weighed_by_its_own_matrix() -> None:
    channels = torch.arange(8.0).reshape(2, 2, 1, 2)
    mixed = _weigh(channels, [np.eye(2), np.array([[0.0, 2.0]]).repeat(2, axis=0)])
    assert torch.equal(mixed[0], channels[0])
    assert mixed[1].tolist() == [[[12.0, 14.0]]] * 2
    with pytest.raises(ImageContractError, match=r"bands: got shape \(2, 2, 1, 2\), wanted"):
        _weigh(channels, [np.eye(3)] * 2)


def test_three_colours_are_refused_with_the_remedy() -> None:
    says = "need spectral bands, .* render it with LRSR_VARIANT=llvm_ad_spectral and bands=35"
    with pytest.raises(InputError, match=says):
        SpectralColour().filter(torch.rand(1, 3, 2, 2), None)
    with pytest.raises(InputError, match=says):
        SpectralColour()(torch.rand(1, 3, 2, 2), None)
    with pytest.raises(InputError, match=says):
        SpectralColour().gains(None, (2, 2))
    assert needed(BOTH) is BOTH


@pytest.mark.parametrize(
    ("setting", "says"),
    [
        ({"balance": "auto"}, "balance=auto: wanted one of scene, daylight"),
        ({"cast": (1.0, 0.0, 1.0)}, "cast=.*wanted three gains > 0"),
        ({"sensitivities": "leica"}, "sensitivities=leica: give one of nikon_d5100"),
    ],
    ids=["balance", "cast", "name"],
)
def test_wrong_settings_are_refused(setting: dict[str, object], says: str) -> None:
    with pytest.raises(InputError, match=says):
        SpectralColour(**setting)


def test_filters_say_whose_they_are() -> None:
    assert repr(SpectralColour()) == (
        "SpectralColour(sensitivities='nikon_d5100', balance='scene')"
    )
