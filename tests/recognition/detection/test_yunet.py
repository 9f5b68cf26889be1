"""YuNet's arithmetic is OpenCV's; here it is held that we hand it pictures and read its rows."""

from pathlib import Path

import numpy as np
import pytest
import torch
from fakes.detectors import declare, write_constants, yunet_lists

from lrsr.errors import InputError
from lrsr.onnx import sha256_of
from lrsr.recognition.detection.detector import Detector
from lrsr.recognition.detection.enlargement import Enlargement

AS_IT_IS = Enlargement(border=0, shorter_px=1)


def test_a_face_is_read_from_opencvs_row(tmp_path: Path) -> None:
    lists = yunet_lists(64)
    cell = 3 * 8 + 2  # row 3, column 2 of the stride 8
    lists["cls_8"][0, cell] = lists["obj_8"][0, cell] = 0.81  # the score: sqrt(0.81 * 0.81)
    lists["bbox_8"][0, cell] = [0.5, 0.25, np.log(3), np.log(4)]
    lists["kps_8"][0, cell] = np.arange(10) / 10
    model = write_constants(tmp_path / "yunet.onnx", lists, (1, 3, 64, 64))
    declare(model, "yunet", sha256_of(model))
    ((face,), (other,)) = Detector(model, enlargement=AS_IT_IS)(torch.zeros(2, 3, 64, 64))
    assert face.score == other.score == pytest.approx(0.81)
    middle, half = np.array([2.5, 3.25]) * 8, np.array([12.0, 16.0])  # OpenCV: face_detect.cpp
    np.testing.assert_allclose(face.box_px, [*(middle - half), *(middle + half)], rtol=1e-5)
    points = (np.array([2, 3]) + np.arange(10).reshape(5, 2) / 10) * 8
    np.testing.assert_allclose(face.landmarks_px, points, rtol=1e-5)


def test_no_face_is_an_empty_list(tmp_path: Path) -> None:
    model = write_constants(tmp_path / "yunet.onnx", yunet_lists(64), (1, 3, 64, 64))
    declare(model, "yunet", sha256_of(model))
    assert Detector(model, enlargement=AS_IT_IS)(torch.zeros(1, 3, 64, 64)) == [[]]


def test_a_file_that_is_no_network_is_refused(tmp_path: Path) -> None:
    model = tmp_path / "yunet.onnx"
    model.write_bytes(b"no network")
    declare(model, "yunet", sha256_of(model))
    with pytest.raises(InputError, match=r"yunet\.onnx: "):
        Detector(model)


def test_another_network_is_refused(tmp_path: Path) -> None:
    model = write_constants(tmp_path / "other.onnx", {"x": np.zeros((1, 4, 1), np.float32)})
    declare(model, "yunet", sha256_of(model))
    with pytest.raises(InputError, match=r"other\.onnx: "):
        Detector(model, enlargement=AS_IT_IS)(torch.zeros(1, 3, 64, 64))
