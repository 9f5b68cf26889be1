from pathlib import Path

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.photographs.correspondence import (
    Correspondence,
    correspondence_path,
    read_correspondence,
)
from lrsr.identities.shape.build_basis import write


@pytest.fixture
def model(tmp_path: Path) -> Path:
    """A network's file, which nobody opens, and its calibration."""
    path, rng = tmp_path / "face.onnx", np.random.default_rng(0)
    noise = Correspondence(
        points=np.array([4, 65535]),
        vertices=np.array([7, 8]),
        bias_mm=rng.standard_normal((2, 2)),
        components_mm=rng.standard_normal((3, 2, 2)),
        rest_mm=0.7,
        network="ab",
    )
    write(noise.arrays("a test"), correspondence_path(path))
    return path


def test_what_is_written_is_read_to_a_hundredth_of_a_millimetre(model: Path) -> None:
    found, rng = read_correspondence(model, "ab"), np.random.default_rng(0)
    assert (found.points.tolist(), found.vertices.tolist()) == ([4, 65535], [7, 8])
    np.testing.assert_allclose(found.bias_mm, rng.standard_normal((2, 2)), atol=0.005)
    np.testing.assert_allclose(found.components_mm, rng.standard_normal((3, 2, 2)), atol=0.005)
    assert found.rest_mm == 0.7


def test_a_network_that_was_never_calibrated_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is missing: lrsr calibrate-reconstructor model="):
        read_correspondence(tmp_path / "other.onnx", "ab")


def test_the_calibration_of_another_network_is_refused(model: Path) -> None:
    with pytest.raises(InputError, match="is that of another network than"):
        read_correspondence(model, "cd")


@pytest.mark.parametrize("content", [b"no archive", b"PK\x03\x04 cut short", b""])
def test_what_is_no_calibration_is_refused(model: Path, content: bytes) -> None:
    correspondence_path(model).write_bytes(content)
    with pytest.raises(InputError, match="is no calibration"):
        read_correspondence(model, "ab")


def test_an_archive_of_something_else_is_refused(model: Path) -> None:
    np.savez(correspondence_path(model), vertices=np.zeros(3))
    with pytest.raises(InputError, match="is no calibration"):
        read_correspondence(model, "ab")
