from pathlib import Path

import numpy as np
import pytest
import torch
from fakes.detectors import declare, scrfd_lists, write_constants

from lrsr.errors import ImageContractError, InputError
from lrsr.onnx import sha256_of
from lrsr.recognition.detection.detector import Detector


@pytest.fixture(scope="module")
def detector() -> Detector:
    return Detector()


@pytest.fixture
def tiny(rendered_face: torch.Tensor) -> torch.Tensor:
    """The rendered face with 8 px between the pupils."""
    return torch.nn.functional.avg_pool2d(rendered_face, 3)


def test_a_face_of_eight_pixels_is_found_where_the_large_one_is(
    detector: Detector, rendered_face: torch.Tensor, tiny: torch.Tensor
) -> None:
    ((large,),), ((small,),) = detector(rendered_face), detector(tiny)
    points = (large.landmarks_px + 0.5) / 3 - 0.5
    away = np.linalg.norm(small.landmarks_px - points, axis=1)
    assert away.mean() < 0.1 * 8
    assert small.score > 0.9


def test_a_picture_among_others_is_found_as_if_alone(
    detector: Detector, tiny: torch.Tensor
) -> None:
    nothing = torch.full_like(tiny, 0.5)
    first, second, third = detector(torch.cat([tiny, nothing, tiny.flip(-1)]))
    assert second == []
    np.testing.assert_allclose(first[0].landmarks_px, detector(tiny)[0][0].landmarks_px, atol=1e-4)
    mirrored = 31 - third[0].landmarks_px[[1, 0, 2, 4, 3], 0]
    np.testing.assert_allclose(mirrored, first[0].landmarks_px[:, 0], atol=0.6)


def test_small_faces_on_a_frame_are_found_where_their_size_is_known(
    detector: Detector, tiny: torch.Tensor
) -> None:
    places = [(20, 30), (100, 180), (60, 250)]
    x = torch.linspace(0.2, 0.7, 320).expand(1, 3, 200, 320).clone()
    for top, left in places:
        x[..., top : top + 32, left : left + 32] = tiny
    (unenlarged,), (faces,) = detector(x, ipd_px=48), detector(x, ipd_px=8)
    assert sum(face.score for face in unenlarged) < sum(face.score for face in faces)
    middles = [(face.box_px[:2] + face.box_px[2:]) / 2 for face in faces]
    for top, left in places:
        assert any(np.hypot(*(middle - [left + 16, top + 16])) < 4 for middle in middles)
    assert len(faces) == 3


def test_the_threshold_of_the_user_comes_before_the_contracts(tiny: torch.Tensor) -> None:
    assert Detector(score_threshold=1.0)(tiny) == [[]]


def test_a_report_can_say_what_found_the_faces(detector: Detector) -> None:
    told = detector.describe()
    assert (told["kind"], told["licence"], told["score_threshold"]) == ("retinaface", "MIT", 0.5)
    assert told["enlargement"]["shorter_px"] == 256


def test_a_threshold_out_of_range_is_refused() -> None:
    with pytest.raises(InputError, match=r"recognition\.score_threshold=2: wanted 0 to 1"):
        Detector(score_threshold=2)


def test_pictures_of_another_range_are_refused(detector: Detector) -> None:
    with pytest.raises(ImageContractError, match="got values"):
        detector(torch.full((1, 3, 20, 20), 255.0))


def scrfd(folder: Path, shape: tuple[int | str, ...], **fields: object) -> Path:
    lists = scrfd_lists(32, (8,), 1, landmarks=True)
    model = write_constants(folder / "scrfd.onnx", lists, shape)
    told = {"output__names": [*lists], "output__strides": [8], "output__per_cell": 1, **fields}
    declare(model, "scrfd", sha256_of(model), **told)
    return model


def test_a_network_for_one_picture_at_a_time_gets_them_one_by_one(tmp_path: Path) -> None:
    model = scrfd(tmp_path, ("n", 3, "h", "w"))  # it returns lists without an axis for the batch
    detector = Detector(model, score_threshold=0.9)
    detector.enlargement = type(detector.enlargement)(border=0, shorter_px=1)
    one, other = detector(torch.zeros(2, 3, 32, 32))
    assert [face.score for face in one] == [face.score for face in other]


@pytest.mark.parametrize(
    ("shape", "fields", "says"),
    [
        (("n", 4, "h", "w"), {}, r"scrfd\.onnx: takes .* contract says one input of NCHW"),
        ((1, 3, "h", "w"), {"output__names": ["a", "b", "c"]}, "has no output a, only score_8"),
    ],
)
def test_a_graph_that_disagrees_with_its_contract_is_refused(
    tmp_path: Path, shape: tuple[int | str, ...], fields: dict[str, object], says: str
) -> None:
    with pytest.raises(InputError, match=says):
        Detector(scrfd(tmp_path, shape, **fields))


def test_a_network_whose_lists_do_not_fit_is_refused(tmp_path: Path) -> None:
    detector = Detector(scrfd(tmp_path, (1, 3, "h", "w")))
    with pytest.raises(InputError, match=r"scrfd\.onnx: outputs .* do not fit"):
        detector(torch.zeros(1, 3, 64, 64))


def test_a_missing_detector_is_the_users_to_mend(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"gone\.onnx is missing"):
        Detector(tmp_path / "gone.onnx")
