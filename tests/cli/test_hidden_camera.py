"""Does ``lrsr fit-camera`` find a camera that it was not told of? A quarter of an hour each: slow.

docs/camera.md says how well it does for more cameras than these.
"""

import json
from pathlib import Path

import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from lrsr.calibration.parameters import PARAMETERS, lens_blur_px
from lrsr.cli import main

pytestmark = [pytest.mark.slow, pytest.mark.timeout(7200)]


@pytest.mark.parametrize(
    ("family", "ipd_px", "hidden"),
    [
        (
            "scface_cam1",
            13,
            {
                "optics.defocus_um": 15,
                "colour.cast": [1.1, 1.0, 0.8],
                "sensor.read_noise_e": 26,
                "sensor.full_well_e": 24000,
                "processing.sharpen_amount": 1.2,
                "stored.qualities": 70,
                "origin_px": [3, 10],
            },
        ),
        (
            "scface_cam3",
            9,
            {
                "optics.defocus_um": 22,
                "colour.cast": [0.9, 1.0, 1.15],
                "sensor.read_noise_e": 30,
                "processing.sharpen_amount": 0.8,
                "processing.contrast": 0.95,
                "stored.qualities": 80,
                "origin_px": [14, 1],
            },
        ),
    ],
)
def test_a_hidden_camera_is_recovered_from_50_pictures(
    family: str,
    ipd_px: int,
    hidden: dict[str, object],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LRSR_CACHE", str(tmp_path / "cache"))
    words = [f"++camera.{name}={value}" for name, value in hidden.items()]
    shown = ["render", "identities.count=50", f"camera={family}", f"ipd_px={ipd_px}", *words]
    assert main([*shown, "out=pictures"]) == 0
    assert main(["fit-camera", "images=pictures", f"camera={family}", "name=found"]) == 0

    folder = Path(capsys.readouterr().out.strip().splitlines()[-1])
    found = json.loads((folder / "results.json").read_text())
    true = OmegaConf.load(tmp_path / "pictures" / "config.yaml").camera
    values = {name: found["values"][name]["value"] for name in (one.name for one in PARAMETERS)}
    read_noise = true.sensor.read_noise_e * true.sensor.gain / true.sensor.full_well_e
    assert found["jpeg"]["qualities"] == pytest.approx(true.stored.qualities, abs=5)
    assert [place % 16 for place in found["origin_px"]] == true.origin_px
    assert values["cast_red"] == pytest.approx(true.colour.cast[0], rel=0.03)
    assert values["cast_blue"] == pytest.approx(true.colour.cast[2], rel=0.03)
    assert found["blur_px"] == pytest.approx(lens_blur_px(instantiate(true)), rel=0.1)
    assert values["read_noise"] == pytest.approx(read_noise, rel=0.2)
