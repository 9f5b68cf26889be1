from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.identities.photographs.crop import Crop
from lrsr.identities.photographs.landmarker import Landmarker, _read_landmarker_contract
from lrsr.paths import asset

FIVE_PX = np.array([[205.0, 101.0], [247.0, 103.0], [224.0, 129.0], [202.0, 138.0], [244.0, 141.0]])
"""Of the astronaut."""


@pytest.fixture(scope="module")
def picture() -> NDArray[np.float32]:
    return np.asarray(astronaut() / 255, np.float32)


def test_a_crop_comes_back_to_where_it_was_taken() -> None:
    x, y = np.meshgrid(np.arange(64.0), np.arange(48.0))
    places = np.stack([x, y, x], axis=2).astype(np.float32)
    crop = Crop((30.0, 22.0), 20.0, 0.3, 32)
    taken = crop.take(places)[5, 9, :2]
    np.testing.assert_allclose(crop.back(np.array([[9.0, 5.0]]))[0], taken, atol=0.05)


def test_the_network_that_ships_declares_what_it_is() -> None:
    contract = _read_landmarker_contract(asset("landmarkers/face_landmark.onnx"))
    assert (contract.licence, contract.size_px, len(contract.mirror)) == ("Apache-2.0", 192, 468)
    assert "photographs" in contract.source
    assert "Apache License" in asset("landmarkers/LICENSE.txt").read_text()


def test_points_lie_on_the_eyes_nose_and_mouth_that_they_started_from(
    picture: NDArray[np.float32],
) -> None:
    found = Landmarker()(picture, FIVE_PX)
    assert found.score > 0.99
    eyes = [found.points_px[[33, 133]].mean(axis=0), found.points_px[[362, 263]].mean(axis=0)]
    five = np.array([*eyes, *found.points_px[[4, 61, 291]]])
    assert np.abs(five - FIVE_PX).max() < 6


def test_a_mirrored_picture_has_mirrored_points(picture: NDArray[np.float32]) -> None:
    find = Landmarker()
    mirrored = np.ascontiguousarray(picture[:, ::-1])
    five = (FIVE_PX * [-1, 1] + [511, 0])[[1, 0, 2, 4, 3]]
    points = find(mirrored, five).points_px[list(find.contract.mirror)]
    np.testing.assert_allclose(
        points * [-1, 1] + [511, 0], find(picture, FIVE_PX).points_px, atol=0.02
    )


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("side = 1.5", "side = 0", "crop.side=0.0: wanted above 0"),
        ("level = [33, 263]", "level = [33, 468]", "crop.level=.*two points, 0 to 467"),
        ("mirror = [", "mirror = [0, ", "output.mirror=.*an involution"),
        ('channels = "RGB"', 'channels = "BGR"', "input.channels = 'BGR'; wanted RGB"),
        ("size_px = 192", "size_px = 8", "input.size_px=8: wanted at least 16"),
    ],
)
def test_a_broken_contract_is_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    shipped, model = asset("landmarkers/face_landmark.onnx"), tmp_path / "face.onnx"
    model.write_bytes(shipped.read_bytes())
    text = shipped.with_suffix(".toml").read_text()
    model.with_suffix(".toml").write_text(text.replace(old, new))
    with pytest.raises(InputError, match=says):
        Landmarker(model)
