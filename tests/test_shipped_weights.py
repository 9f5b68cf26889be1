"""The weights that ship are trained ones, and their records are theirs."""

import json

import pytest

from lrsr.paths import asset
from lrsr.recognition.contract import read_contract
from lrsr.sr.weights import read_weights


@pytest.mark.parametrize("scale", [2, 4])
def test_srcnn_beats_bicubic_on_people_it_was_not_trained_on(scale: int) -> None:
    record = json.loads(asset(f"weights/srcnn{scale}x.json").read_text())
    assert record["best"]["val/gain_over_bicubic_db"] > 0.5
    assert record["recipe"]["scale"] == scale


#: Bytes, at most, and the gain over bicubic of the best epoch, dB, at least.
SHIPPED = {
    "srcnn2x_camera": (40_000, 0.5),
    "srcnn4x_camera": (40_000, 0.5),
    "fsrcnn2x_camera": (60_000, 0.5),
    "fsrcnn4x_camera": (60_000, 0.7),
    "imdn4x_camera": (600_000, 0.7),
    "fusion4x": (300_000, 1.0),
}


@pytest.mark.parametrize("name", ["srcnn2x", "srcnn4x", *SHIPPED])
def test_weights_are_small_and_for_their_scale(name: str) -> None:
    path = asset(f"weights/{name}.safetensors")
    assert path.stat().st_size < SHIPPED.get(name, (40_000, 0))[0]
    card = read_weights(path)[1]
    assert name.startswith(f"{card.architecture}{card.scale}x")


@pytest.mark.parametrize("name", SHIPPED)
def test_camera_aware_weights_are_the_best_epoch_of_their_record(name: str) -> None:
    record = json.loads(asset(f"weights/{name}.json").read_text())
    best = max(record["history"], key=lambda epoch: epoch["val/psnr_y_db"])
    assert record["best"] == best
    assert best["val/gain_over_bicubic_db"] > SHIPPED[name][1]
    made_by = read_weights(asset(f"weights/{name}.safetensors"))[1].lr_made_by
    assert "JPEG 15 to 95" in made_by
    assert record["card"]["lr_made_by"] == made_by


def test_the_fusion_beats_the_mean_of_the_frames() -> None:
    best = json.loads(asset("weights/fusion4x.json").read_text())["best"]
    assert best["val/psnr_y_db"] > best["val/mean_psnr_y_db"] > best["val/bicubic_psnr_y_db"]


def test_embedder_is_the_one_of_its_record() -> None:
    model = asset("weights/arcface_small.onnx")
    record = json.loads(asset("weights/arcface_small.json").read_text())
    assert read_contract(model).sha256 == record["model_sha256"]
    # People on another day: the embedder before, trained without, has 0.935 on them.
    assert record["onnx"]["val/auc_ipd64"] > 0.97
    best = max(record["history"], key=lambda epoch: epoch["val/auc"])
    assert record["best"]["epoch"] == best["epoch"]
    for name, value in record["onnx"].items():
        assert value == pytest.approx(best[name], abs=1e-6)
    assert model.stat().st_size <= 5_000_000
