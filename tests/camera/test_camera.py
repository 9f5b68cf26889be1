"""The chain from light to file, as a whole."""

import subprocess
import sys

import numpy as np
import pytest
import torch
from hydra.utils import instantiate
from omegaconf import OmegaConf

import lrsr.camera
from lrsr.camera import Camera
from lrsr.camera.camera import STAGES
from lrsr.camera.codec import COMPRESSIONS, Jpeg, jpeg
from lrsr.camera.colour import Colour
from lrsr.camera.encoding import encode
from lrsr.camera.exposure import KEY, expose
from lrsr.camera.mosaic import Mosaic
from lrsr.camera.optics import Optics, bin_pixels
from lrsr.camera.processing import Processing
from lrsr.camera.sensor import Sensor
from lrsr.camera.spectral import SpectralColour, observe
from lrsr.camera.video import Video
from lrsr.errors import ImageContractError, InputError, NonFiniteError
from lrsr.images import linear_to_srgb
from lrsr.paths import config_folder
from lrsr.spectra import Spectrum, band_edges, daylight


def light(batch: int = 2, height: int = 32, width: int = 32, seed: int = 0) -> torch.Tensor:
    generator = torch.Generator().manual_seed(seed)
    return torch.rand(batch, 3, height, width, generator=generator)


@pytest.mark.parametrize("codec", ["true", "differentiable"])
def test_without_compression_the_file_is_the_rounded_curve(codec: str) -> None:
    linear = light()
    wanted = (linear_to_srgb(linear * KEY / 2.0) * 255).round() / 255
    assert torch.allclose(Camera(codec=codec)(linear, torch.tensor([2.0, 2.0])), wanted)


@pytest.mark.parametrize("codec", ["true", "differentiable"])
@pytest.mark.parametrize("compression", list(COMPRESSIONS))
@pytest.mark.parametrize("size", [(32, 32), (45, 29), (1, 1)], ids=str)
def test_any_size_comes_back_as_srgb_of_eight_bits(
    compression: str, codec: str, size: tuple[int, int]
) -> None:
    srgb = Camera(compression, codec=codec)(light(3, *size), torch.ones(3))
    assert srgb.shape == (3, 3, *size)
    assert srgb.dtype == torch.float32
    assert torch.allclose(srgb * 255, (srgb * 255).round().clamp(0, 255), atol=1e-4)


@pytest.mark.parametrize("compression", list(COMPRESSIONS))
def test_a_picture_does_not_depend_on_its_batch(compression: str) -> None:
    linear, metered = light(5, 20, 30), torch.linspace(0.5, 2, 5)
    camera = Camera(compression)
    alone = [camera(linear[i : i + 1], metered[i : i + 1]) for i in range(5)]
    assert torch.equal(camera(linear, metered), torch.cat(alone))


def test_the_same_light_gives_the_same_file() -> None:
    camera = Camera("heavy")
    assert torch.equal(camera(light(), torch.ones(2)), camera(light(), torch.ones(2)))


@pytest.mark.parametrize("compression", list(COMPRESSIONS))
def test_the_differentiable_camera_passes_the_light_a_gradient(compression: str) -> None:
    linear = light().requires_grad_()
    Camera(compression, codec="differentiable")(linear, torch.ones(2)).sum().backward()
    assert linear.grad is not None
    assert bool(torch.isfinite(linear.grad).all())
    assert float(linear.grad.abs().mean()) > 0.1


def test_overexposure_clips_at_white() -> None:
    assert Camera(exposure_ev=10)(light() + 0.1, torch.ones(2)).unique().tolist() == [1.0]


def test_a_camera_has_nothing_to_train_or_to_store() -> None:
    assert Camera().state_dict() == {}


def test_another_compression_is_otherwise_the_same_camera() -> None:
    camera = Camera("none", exposure_ev=1.0, codec="differentiable", name="mine")
    heavy = camera.compressing("heavy")
    assert heavy.compression == "heavy"
    assert (heavy.exposure_ev, heavy.codec, heavy.name) == (1.0, "differentiable", "mine")


def test_a_camera_says_how_it_is_set() -> None:
    assert repr(Camera("small")) == (
        "Camera(compression='small', exposure_ev=0, codec='true', name='reference')"
    )


def test_the_preset_builds_the_camera_it_names() -> None:
    for name in PRESETS:
        assert preset(name).name == name


def test_unknown_settings_are_refused_with_the_choice() -> None:
    with pytest.raises(InputError, match="compression=much: wanted one of none, small, heavy"):
        Camera("much")
    with pytest.raises(InputError, match="codec=webp: wanted one of true, differentiable"):
        Camera(codec="webp")
    with pytest.raises(InputError, match="compression=much"):
        Camera().compressing("much")


def test_light_from_another_lens_is_refused_by_a_camera_with_one() -> None:
    camera = full()
    camera.check_lens("pinhole", pinhole=True)
    Camera().check_lens("thin", pinhole=False)
    with pytest.raises(InputError, match=r"lens=thin camera=full: two lenses.*lens=pinhole, or a"):
        camera.check_lens("thin", pinhole=False)


def test_broken_light_is_refused() -> None:
    with pytest.raises(ImageContractError, match="metered: got shape"):
        Camera()(light(2), torch.ones(3))
    with pytest.raises(NonFiniteError, match="linear: nan"):
        Camera()(light() * float("nan"), torch.ones(2))


def test_the_package_loads_kornia_only_with_the_camera() -> None:
    script = "import sys, lrsr.camera; print('kornia' in sys.modules, 'torch' in sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", script], capture_output=True, check=True)
    assert loaded.stdout == b"False False\n"


def test_the_package_has_no_other_names() -> None:
    with pytest.raises(AttributeError, match="no attribute 'Lens'"):
        lrsr.camera.Lens  # noqa: B018 - asking is the test


PRESETS = sorted(path.stem for path in (config_folder() / "camera").glob("*.yaml"))


def full(codec: str = "true", compression: str = "none", **changes: object) -> Camera:
    stages: dict[str, object] = {
        "optics": Optics(f_number=1.4),
        "supersampling": 2,
        "colour": Colour(((0.5, 0.1, 0.0), (0.1, 0.8, 0.1), (0.0, 0.1, 0.6))),
        "mosaic": Mosaic(),
        "sensor": Sensor(2000.0),
        "processing": Processing(denoise_luma_px=0.7, sharpen_amount=0.5, contrast=1.1),
        "stored": Jpeg(70, "4:2:2"),
        "origin_px": (3, 5),
    }
    return Camera(compression, codec=codec, name="full", **{**stages, **changes})


def preset(name: str) -> Camera:
    camera = instantiate(OmegaConf.load(config_folder() / "camera" / f"{name}.yaml"))
    assert isinstance(camera, Camera)
    return camera


@pytest.mark.parametrize("codec", ["true", "differentiable"])
def test_the_whole_chain_makes_srgb_of_eight_bits_of_a_finer_film(codec: str) -> None:
    srgb = full(codec)(light(2, 48, 40), torch.ones(2), [1, 2])
    assert srgb.shape == (2, 3, 24, 20)
    assert torch.allclose(srgb * 255, (srgb * 255).round().clamp(0, 255), atol=1e-4)


def test_a_noisy_picture_depends_on_its_seed_and_not_on_its_batch() -> None:
    linear, metered, camera = light(5, 40, 56), torch.linspace(0.5, 2, 5), full()
    together = camera(linear, metered, range(5))
    order = [3, 1, 4, 0, 2]
    assert torch.equal(camera(linear[order], metered[order], order), together[order])
    alone = [camera(linear[i : i + 1], metered[i : i + 1], [i]) for i in range(5)]
    assert torch.equal(torch.cat(alone), together)
    assert not torch.equal(camera(linear[:1], metered[:1], [9]), together[:1])


def test_a_noisy_camera_wants_a_seed_for_each_image() -> None:
    with pytest.raises(InputError, match="camera 'full' is noisy: give seeds, one for each image"):
        full()(light(), torch.ones(2))
    with pytest.raises(InputError, match="seeds: got 1 for 2 noisy images"):
        full()(light(), torch.ones(2), [1])
    assert not full(sensor=Sensor(noise=False)).noisy
    full(sensor=None)(light(), torch.ones(2))


@pytest.mark.parametrize("stage", ["optics", "colour", "mosaic", "sensor", "processing", "stored"])
def test_each_stage_can_be_left_out_and_changes_the_picture(stage: str) -> None:
    linear, metered = light() * 0.6, torch.ones(2)
    picture = full(**{stage: None})(linear, metered, [1, 2])
    assert not torch.equal(picture, full()(linear, metered, [1, 2]))


def test_perfect_stages_leave_the_reference_picture() -> None:
    perfect = Camera(
        optics=Optics(),
        colour=Colour(((0.5, 0.1, 0.0), (0.1, 0.8, 0.1), (0.0, 0.1, 0.6))),
        sensor=Sensor(noise=False, prnu=0.0, bits=16, black_level_dn=0),
        processing=Processing(),
    )
    difference = perfect(light(), torch.ones(2)) - Camera()(light(), torch.ones(2))
    assert float(difference.abs().max()) * 255 <= 1.001


def test_every_stage_keeps_the_mean_of_an_even_light() -> None:
    # 2304 photosites of 0.0216 (shot noise of 2000 e-): the mean is known to 0.0005.
    even = torch.full((4, 3, 48, 48), 0.4)
    exposed = expose(even, torch.ones(4))
    camera = full(stored=None, processing=None)
    picture = camera.develop(camera.gather(exposed), range(4))
    assert float(picture.mean()) == pytest.approx(float(linear_to_srgb(exposed).mean()), abs=0.003)


def test_the_stages_come_in_their_order() -> None:
    linear, metered, camera = light(), torch.ones(2), full()
    film = camera.optics(expose(linear, metered), supersampling=2)
    raw = camera.mosaic.filter(camera.colour.filter(bin_pixels(film, 2)), (3, 5))
    counted = camera.sensor.light(camera.sensor(raw, [1, 2], origin_px=(3, 5)))
    colours = camera.colour(camera.mosaic(counted, (3, 5)))
    rounded = (camera.processing(colours) * 255).round() / 255
    wanted = jpeg(rounded, 70, chroma="4:2:2", origin_px=(3, 5))
    assert torch.equal(camera(linear, metered, [1, 2]), wanted)
    assert torch.equal(camera.compressing("heavy")(linear, metered, [1, 2]), jpeg(wanted, 15))


def test_a_recording_takes_several_exposures_with_noise_of_their_own() -> None:
    camera = full(stored=Video(frames=2, crf=20))
    film = camera.gather(expose(light(), torch.ones(2)))
    frames = torch.stack([camera.develop(film, [1, 2], frame) for frame in (0, 1)])
    assert not torch.equal(*frames)
    wanted = camera.stored(frames, origin_px=(3, 5))
    assert torch.equal(camera(light(), torch.ones(2), [1, 2]), wanted)


def test_the_gradient_reaches_the_light_through_every_stage() -> None:
    linear = (light() * 0.6).requires_grad_()
    full("differentiable", "small")(linear, torch.ones(2), [1, 2]).sum().backward()
    assert linear.grad is not None
    assert bool(torch.isfinite(linear.grad).all())
    assert float(linear.grad.abs().mean()) > 0.01


def test_a_step_along_the_gradient_does_what_it_says() -> None:
    target = full()(light(seed=1) * 0.6, torch.ones(2), [1, 2])
    linear = (light(seed=2) * 0.6).requires_grad_()
    soft = full("differentiable")(linear, torch.ones(2), [1, 2])
    (soft - target).square().sum().backward()
    assert linear.grad is not None
    step = (linear - 0.02 * linear.grad).detach().clamp_min(0)
    loss = [
        float((full()(film, torch.ones(2), [1, 2]) - target).square().mean())
        for film in (linear.detach(), step)
    ]
    assert loss[1] < 0.98 * loss[0]


def test_points_of_the_film_move_onto_the_picture() -> None:
    film = torch.tensor([[0.5, 2.5], [31.5, 15.5]])
    halved = (film + 0.5) / 2 - 0.5
    assert torch.allclose(full().place_points(film, (48, 48)), halved, atol=1e-4)
    assert torch.equal(Camera().place_points(film, (48, 48)), film)
    bent = full(optics=Optics(focal_mm=3.0, distortion=(0.1, 0.0)), field_mm=(1.5, 0.0))
    moved = bent.place_points(film, (48, 48)) - halved
    assert 1e-3 < float(moved.abs().max()) < 24


def test_another_compression_keeps_every_stage() -> None:
    camera = full()
    heavy = camera.compressing("heavy")
    assert heavy.compression == "heavy"
    assert all(getattr(heavy, stage) is getattr(camera, stage) for stage in STAGES)
    assert (heavy.supersampling, heavy.origin_px, heavy.name) == (2, (3, 5), "full")
    once = heavy.compressing("none")(light(), torch.ones(2), [1, 2])
    assert torch.equal(once, full()(light(), torch.ones(2), [1, 2]))


def test_a_clean_camera_has_the_exposure_and_no_flaw() -> None:
    clean = full(exposure_ev=-1.0).clean()
    assert clean.flawless
    assert (clean.name, clean.exposure_ev, clean.compression) == ("reference", -1.0, "none")
    assert torch.equal(clean(light(), torch.ones(2)), Camera("none", -1.0)(light(), torch.ones(2)))
    assert Camera("heavy", name="mine").clean().name == "mine"
    assert not full().flawless


def banded(film: torch.Tensor, bands: int = 35) -> tuple[torch.Tensor, Spectrum]:
    """Make bands of light of three colours: daylight behind three filters that share no band."""
    edges = band_edges(bands)
    white = daylight(edges)
    places = [min(2, 3 * (bands - 1 - band) // bands) for band in range(bands)]
    light = film[:, places] * torch.tensor(white, dtype=torch.float32)[:, None, None]
    return light, Spectrum(edges, (tuple(white.tolist()),) * len(film))


@pytest.mark.parametrize("name", PRESETS)
def test_a_preset_takes_pictures_whose_seed_decides_them(name: str) -> None:
    camera = preset(name)
    film = light(2, 32 * camera.supersampling, 32 * camera.supersampling)
    spectrum = None
    if camera.bands:
        film, spectrum = banded(film, camera.bands)
    srgb = camera(film, torch.ones(2), [1, 2], spectrum)
    assert srgb.shape == (2, 3, 32, 32)
    assert torch.equal(srgb, camera(film, torch.ones(2), [1, 2], spectrum))


def hue(name: str) -> torch.Tensor:
    camera = preset(name)
    grey = torch.full((1, 3, 64 * camera.supersampling, 64 * camera.supersampling), 0.4)
    return camera(grey, torch.ones(1), [0])[..., 16:-16, 16:-16].mean((0, 2, 3))


def test_the_surveillance_cameras_have_the_hues_they_are_known_for() -> None:
    red, green, blue = hue("scface_cam1").tolist()
    assert min(red, green) > blue + 0.03, "yellow"
    red, green, blue = hue("scface_cam3").tolist()
    assert blue > max(red, green) + 0.03, "blue"
    assert float(hue("ideal").max() - hue("ideal").min()) < 0.002


def test_a_place_or_a_film_that_does_not_fit_is_refused() -> None:
    with pytest.raises(InputError, match="supersampling=3: wanted one of"):
        full(supersampling=3)
    with pytest.raises(InputError, match="origin_px"):
        full(origin_px=(-1, 0))
    with pytest.raises(ImageContractError, match="film: got 31x32, wanted multiples of 2"):
        full()(light(1, 31, 32), torch.ones(1), [0])


MEASURED = SpectralColour("nikon_d5100")
LAMP = Spectrum(
    band_edges(35), (tuple((daylight(band_edges(35)) * np.linspace(0.6, 1.4, 35)).tolist()),) * 2
)


def test_one_film_of_bands_serves_cameras_with_and_without_measured_filters() -> None:
    film, spectrum = banded(light() * 0.6)
    real, three = full(colour=MEASURED), full(bands=35)
    assert (real.bands, three.bands, full().bands) == (35, 35, 0)
    for camera in (real, three, Camera(bands=35)):
        srgb = camera(film, torch.ones(2), [1, 2], spectrum)
        assert srgb.shape[:2] == (2, 3)
    observed = observe(film, spectrum)
    plain = full()(observed, torch.ones(2), [1, 2])
    assert torch.equal(three(film, torch.ones(2), [1, 2], spectrum), plain)


def test_measured_filters_record_a_white_sphere_as_every_camera_does() -> None:
    wall = torch.tensor(LAMP.whites)[:, :, None, None].expand(2, 35, 32, 32)
    white = round(255 * float(linear_to_srgb(torch.tensor(KEY))))
    for camera in (Camera(colour=MEASURED), Camera(colour=MEASURED, mosaic=Mosaic())):
        picture = camera(2 * wall, torch.full((2,), 2.0), None, LAMP).mul(255)
        assert picture.unique().tolist() == pytest.approx([white])


def test_measured_filters_differ_from_three_numbers_each() -> None:
    film, spectrum = banded(light() * 0.6)
    real = full(colour=MEASURED)(film, torch.ones(2), [1, 2], spectrum)
    three = full()(observe(film, spectrum), torch.ones(2), [1, 2])
    assert 2 < float((real - three).abs().mean()) * 255 < 60


def test_the_references_of_a_camera_with_measured_filters_have_its_white_and_no_flaw() -> None:
    scene = full(colour=SpectralColour(balance="scene"), exposure_ev=-1.0)
    day = full(colour=SpectralColour(balance="daylight"), exposure_ev=-1.0)
    for camera, adapted in ((scene, True), (day, False)):
        clean = camera.clean()
        assert clean.flawless
        assert (clean.bands, clean.adapted, clean.name) == (35, adapted, "reference")
        assert clean.clean().adapted == clean.compressing("heavy").adapted == adapted
        film = torch.tensor(LAMP.whites)[:, :, None, None] * torch.rand(2, 1, 8, 8)
        plain = Camera(exposure_ev=-1.0)(observe(film, LAMP, adapted=adapted), torch.ones(2))
        assert torch.equal(clean(film, torch.ones(2), None, LAMP), plain)


def test_another_compression_keeps_bands_and_filters() -> None:
    heavy = full(colour=MEASURED, bands=70).compressing("heavy")
    assert heavy.bands == 70
    assert heavy.colour is MEASURED


def test_the_gradient_reaches_the_bands_through_every_stage() -> None:
    film, spectrum = banded(light() * 0.6)
    film.requires_grad_()
    camera = full("differentiable", "small", colour=MEASURED)
    camera(film, torch.ones(2), [1, 2], spectrum).sum().backward()
    assert film.grad is not None
    assert bool(torch.isfinite(film.grad).all())
    assert float(film.grad.abs().mean()) > 1e-4


def test_measured_filters_refuse_light_of_three_colours() -> None:
    with pytest.raises(InputError, match="LRSR_VARIANT=llvm_ad_spectral and bands=70"):
        full(colour=MEASURED, bands=70)(light(), torch.ones(2), [1, 2])
    with pytest.raises(InputError, match="bands=0: wanted 7 to 350, or 0 without measured"):
        full(colour=MEASURED, bands=0)
    with pytest.raises(InputError, match="bands=3: wanted 7 to 350"):
        Camera(bands=3)
    film, spectrum = banded(light())
    with pytest.raises(ImageContractError, match=r"bands: got shape \(2, 34, 32, 32\)"):
        Camera(bands=35)(film[:, 1:], torch.ones(2), None, spectrum)


def test_photosites_are_balanced_before_colours_are_interpolated() -> None:
    # The edges of a grey wall have one profile in all balanced channels.
    edge = torch.full((1, 1, 16, 16), 0.2)
    edge[..., 5:11] = 0.8
    film = torch.tensor(LAMP.whites)[:1, :, None, None] * edge
    light = Spectrum(LAMP.edges_nm, LAMP.whites[:1])
    srgb = Camera(colour=MEASURED, mosaic=Mosaic())(film, torch.ones(1), None, light)
    grey = Mosaic()(Mosaic().filter(KEY * edge.expand(1, 3, 16, 16)))
    wanted = encode(MEASURED(grey, light))
    assert float((srgb - wanted).abs().max()) <= 1.001 / 255
