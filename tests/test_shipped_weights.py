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


@pytest.mark.parametrize("kind", ["", "_camera"])
@pytest.mark.parametrize("scale", [2, 4])
def test_srcnn_weights_are_small_and_for_their_scale(scale: int, kind: str) -> None:
    path = asset(f"weights/srcnn{scale}x{kind}.safetensors")
    assert path.stat().st_size < 40_000
    assert read_weights(path)[1].scale == scale


@pytest.mark.parametrize("scale", [2, 4])
def test_camera_aware_srcnn_is_the_best_epoch_of_its_record(scale: int) -> None:
    record = json.loads(asset(f"weights/srcnn{scale}x_camera.json").read_text())
    best = max(record["history"], key=lambda epoch: epoch["val/psnr_y_db"])
    assert record["best"] == best
    assert best["val/gain_over_bicubic_db"] > 0.5
    made_by = read_weights(asset(f"weights/srcnn{scale}x_camera.safetensors"))[1].lr_made_by
    assert "JPEG 15 to 95" in made_by


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
