import math
from pathlib import Path
from typing import Any

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf
from scipy.special import j1

from lrsr.calibration.parameters import (
    PARAMETERS,
    Parameter,
    lens_blur_px,
    starting_from,
    with_jpeg,
    with_values,
)
from lrsr.camera.camera import Camera
from lrsr.camera.optics import Optics
from lrsr.errors import InputError
from lrsr.paths import config_folder

VALUES = {
    "blur_px": 1.0,
    "sharpen_amount": 0.7,
    "read_noise": 0.01,
    "white_e": 2000.0,
    "exposure_ev": 0.5,
    "cast_red": 1.2,
    "cast_blue": 0.8,
    "contrast": 0.9,
    "saturation": 1.1,
}


def preset(name: str = "generic") -> dict[str, Any]:
    plain = OmegaConf.to_container(OmegaConf.load(Path(config_folder(), "camera", f"{name}.yaml")))
    assert isinstance(plain, dict)
    return {str(key): value for key, value in plain.items()}


def test_values_reach_the_stages_of_the_camera() -> None:
    camera = instantiate(with_values(preset(), VALUES))
    assert isinstance(camera, Camera)
    assert camera.sensor is not None
    assert camera.processing is not None
    assert camera.colour is not None
    assert (camera.sensor.white_e, camera.sensor.read_noise_e) == (2000.0, 20.0)
    assert camera.processing.sharpen_amount == 0.7
    assert camera.exposure_ev == 0.5
    red, green, blue = camera.colour.white_balance
    plain = instantiate(preset()).colour.white_balance
    assert red / plain[0] == pytest.approx(1.2)
    assert (green / plain[1], blue / plain[2]) == pytest.approx((1.0, 0.8))


def test_defocus_is_the_disk_of_that_sigma() -> None:
    optics = with_values(preset(), VALUES)["optics"]
    radius_um = optics["defocus_um"] / (2 * optics["f_number"])
    assert radius_um / 2 / optics["pitch_um"] == pytest.approx(1.0)  # σ of a disk: half its radius


def test_the_guess_is_what_the_preset_says() -> None:
    starts = {one.name: one.start for one in starting_from(with_values(preset(), VALUES))}
    assert starts == pytest.approx(VALUES, rel=1e-4)


def test_of_a_gain_and_a_full_well_the_electrons_at_white_are_guessed() -> None:
    starts = {one.name: one.start for one in starting_from(preset("scface_cam1"))}
    assert (starts["white_e"], starts["read_noise"]) == (2500, 0.008)
    assert starts["cast_blue"] == 0.75


def test_what_a_preset_leaves_out_is_guessed_as_the_stages_have_it() -> None:
    bare: dict[str, Any] = {"_target_": "lrsr.camera.Camera"}
    for stage in ("optics", "colour", "sensor", "processing"):
        bare[stage] = {"_target_": f"lrsr.camera.{stage.capitalize()}"}
    bare["optics"]["f_number"] = 2.0
    parameters = starting_from(bare)
    starts = {one.name: one.start for one in parameters}
    assert starts["blur_px"] == PARAMETERS[0].low  # no defocus is below the range
    assert (starts["white_e"], starts["read_noise"]) == (10_000, 3 / 10_000)
    assert (starts["contrast"], starts["saturation"], starts["sharpen_amount"]) == (1, 1, 0)


def test_measured_filters_are_refused() -> None:
    with pytest.raises(InputError, match="nikon_d5100 has measured colour filters"):
        starting_from(preset("nikon_d5100"))


def test_the_given_preset_is_left_as_it_is() -> None:
    given = preset()
    with_jpeg(with_values(given, VALUES), 30, "4:4:4", (1, 2))
    assert given == preset()


@pytest.mark.parametrize(("name", "lacks"), [("reference", "optics"), ("ideal", "colour")])
def test_a_preset_without_a_stage_is_refused(name: str, lacks: str) -> None:
    with pytest.raises(InputError, match=f"{name} has no {lacks}.*camera=generic"):
        with_values(preset(name), VALUES)


def test_a_lens_without_blur_is_refused() -> None:
    sharp = preset() | {"optics": {"pitch_um": 2.65}}
    with pytest.raises(InputError, match=r"optics\.f_number"):
        with_values(sharp, VALUES)


def test_a_preset_stores_as_it_is_told() -> None:
    camera = instantiate(with_jpeg(preset(), 42, "4:2:2", (3, 4)))
    assert (camera.stored.qualities, camera.stored.chroma) == ((42,), "4:2:2")
    assert camera.origin_px == (3, 4)
    assert instantiate(with_jpeg(preset(), None, "4:2:0", (0, 0))).stored is None


@pytest.mark.parametrize("parameter", PARAMETERS, ids=lambda one: one.name)
def test_a_coordinate_is_a_value(parameter: Parameter) -> None:
    assert parameter.coordinate(parameter.start) == 0
    for value in (parameter.low, parameter.high):
        assert parameter.value(parameter.coordinate(value)) == pytest.approx(value)


@pytest.mark.parametrize("sigma_px", [1.0, 2.0])
def test_wide_defocus_blurs_as_its_disk_does(sigma_px: float) -> None:
    defocus = Optics(f_number=1.4, pitch_um=2.65, defocus_um=4 * 1.4 * 2.65 * sigma_px)
    phase = 2 * math.pi * 0.1 * 2 * sigma_px  # a disk of radius 2 σ, at 0.1 cycles a pixel
    transfer = 2 * j1(phase) / phase
    expected = math.sqrt(-2 * math.log(transfer)) / (2 * math.pi * 0.1)
    found = lens_blur_px(Camera(optics=defocus, supersampling=2))
    assert found == pytest.approx(expected, rel=0.09)  # the rest is diffraction


def test_without_a_lens_nothing_is_blurred() -> None:
    assert lens_blur_px(Camera()) == 0.0


def test_a_blur_beyond_measure_is_refused() -> None:
    optics = Optics(f_number=1.4, pitch_um=2.65, defocus_um=60.0)
    with pytest.raises(InputError, match="contrast"):
        lens_blur_px(Camera(optics=optics))
