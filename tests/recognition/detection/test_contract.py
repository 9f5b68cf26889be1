from pathlib import Path
from typing import Any

import pytest
from fakes.detectors import declare, scrfd_lists, write_constants

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.paths import asset
from lrsr.recognition.detection.contract import read_detector_contract

RETINAFACE = {
    "output__names": ["a", "b", "c"],
    "output__strides": [8],
    "output__sizes_px": [[16, 32]],
    "output__variances": [0.1, 0.2],
}


def declared(folder: Path, kind: str, **fields: Any) -> Path:
    model = folder / "finder.onnx"
    write_constants(model, scrfd_lists(32, (8,), 1, landmarks=False))
    declare(model, kind, sha256_of(model), **fields)
    return model


def test_the_detector_that_ships_declares_what_it_is() -> None:
    contract = read_detector_contract(asset("detectors/retinaface_mnet025.onnx"))
    assert (contract.kind, contract.channels, contract.mean) == (
        "retinaface",
        "BGR",
        (104.0, 117.0, 123.0),
    )
    assert contract.sizes_px == ((16, 32), (64, 128), (256, 512))
    assert contract.licence == "MIT"
    assert "photographs" in contract.source
    assert asset("detectors/LICENSE.txt").is_file()


def test_yunet_needs_no_outputs(tmp_path: Path) -> None:
    assert read_detector_contract(declared(tmp_path, "yunet")).names == ()


@pytest.mark.parametrize(
    ("kind", "fields", "says"),
    [
        ("retinaface", {"output__variances": [0.1]}, r"output.variances=\[0.1\]: wanted two"),
        ("retinaface", {"output__variances": 0.1}, "output.variances = 0.1; wanted a list"),
        ("retinaface", {"output__strides": []}, r"output.strides=\[\]: wanted at least one"),
        ("retinaface", {"output__strides": ["x"]}, "output.strides = .'x'.; wanted int"),
        ("retinaface", {"output__names": ["a"]}, r"wanted 3 of them for kind retinaface"),
        ("retinaface", {"output__sizes_px": [[16], [32]]}, "a list of sizes above 0 for each"),
        ("retinaface_deepface", {"output__sizes_px": [[]]}, "a list of sizes above 0 for each"),
        ("scrfd", {"output__names": ["a"]}, "wanted 2 or 3 of them for kind scrfd"),
        ("scrfd", {}, "output.per_cell=0: wanted at least 1"),
        ("magic", {}, "kind = 'magic'; wanted retinaface or scrfd"),
        ("yunet", {"input__mean": [1]}, r"input.mean=\[1.0\]: wanted three numbers"),
        ("yunet", {"input__scale": 0}, "input.scale=0.0: wanted above 0"),
        ("yunet", {"input__multiple_px": 0}, "input.multiple_px=0"),
        ("yunet", {"input__channels": None}, "input.channels is missing"),
        ("yunet", {"detection__nms_iou": 2}, "detection.nms_iou=2.0: wanted 0 to 1"),
        ("yunet", {"detection__score_threshold": -1}, "detection.score_threshold=-1.0"),
    ],
)
def test_what_does_not_fit_is_refused_by_name(
    tmp_path: Path, kind: str, fields: dict[str, Any], says: str
) -> None:
    with pytest.raises(InputError, match=rf"finder\.toml: .*{says}"):
        read_detector_contract(declared(tmp_path, kind, **{**RETINAFACE, **fields}))


def test_another_file_than_the_declared_one_is_refused(tmp_path: Path) -> None:
    model = declared(tmp_path, "yunet")
    model.write_bytes(model.read_bytes() + b"0")
    with pytest.raises(InputError, match=r"finder\.onnx: sha256 is"):
        read_detector_contract(model)
