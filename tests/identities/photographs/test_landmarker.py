from dataclasses import replace
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
    assert found.score is not None
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
        ('channels = "RGB"', 'channels = "RBG"', "input.channels = 'RBG'; wanted RGB or BGR"),
        (
            "[crop]",
            "symmetric = true\n[crop]",
            r"output.shape=\[\]: wanted a map, \[rows, columns, 3\]",
        ),
        ("[crop]", "shape = [468, 3]\n[crop]", r"output.shape=\[468, 3\]: wanted a map"),
        (
            "[crop]",
            "shape = [9, 52, 3]\nsymmetric = true\n[crop]",
            "output.mirror=given: wanted none with symmetric",
        ),
        ("[crop]", "unit_px = 0\n[crop]", "output.unit_px=0.0: wanted above 0"),
        ("[output]", "scale = 0\n[output]", "input.scale=0.0: wanted above 0"),
        ("[crop]", '[crop]\nbox = "retina"', "crop.box = 'retina'; wanted points or five"),
        ("size_px = 192", "size_px = 8", "input.size_px=8: wanted at least 16"),
    ],
)
def test_a_broken_contract_is_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(InputError, match=says):
        Landmarker(changed_contract(tmp_path, old, new))


def changed_contract(folder: Path, old: str, new: str) -> Path:
    """The network that ships, under a contract that says something else."""
    shipped, model = asset("landmarkers/face_landmark.onnx"), folder / "face.onnx"
    model.write_bytes(shipped.read_bytes())
    text = shipped.with_suffix(".toml").read_text()
    model.with_suffix(".toml").write_text(text.replace(old, new))
    return model


def test_what_the_contract_does_not_say_is_refused(
    tmp_path: Path, picture: NDArray[np.float32]
) -> None:
    find = Landmarker(changed_contract(tmp_path, "[crop]", "shape = [9, 50, 3]\n[crop]"))
    with pytest.raises(InputError, match="output t213 has 1404 numbers, which its contract's"):
        find(picture, FIVE_PX)


def test_channels_layout_and_range_are_those_of_the_contract() -> None:
    contract = replace(
        _read_landmarker_contract(asset("landmarkers/face_landmark.onnx")),
        channels="BGR",
        layout="NHWC",
        mean=(10.0, 20.0, 30.0),
        scale=50.0,
    )
    red = np.zeros((1, 4, 4, 3), np.float32)
    red[..., 0] = 1.0
    np.testing.assert_allclose(contract.prepare(red)[0, 0, 0], [-0.2, -0.4, 4.5], rtol=1e-6)
    assert replace(contract, layout="NCHW").prepare(red).shape == (1, 3, 4, 4)


def test_the_columns_of_a_symmetric_map_change_places_in_a_mirror() -> None:
    shipped = _read_landmarker_contract(asset("landmarkers/face_landmark.onnx"))
    for shape in ((2, 4, 3), (3, 2, 4)):
        contract = replace(shipped, mirror=(), symmetric=True, shape=shape)
        assert contract.mirrored().tolist() == [3, 2, 1, 0, 7, 6, 5, 4]


def test_the_first_axis_of_a_map_may_be_the_coordinates() -> None:
    shipped = _read_landmarker_contract(asset("landmarkers/face_landmark.onnx"))
    raw = np.arange(3 * 2 * 4, dtype=np.float32).reshape(1, 3, 2, 4)
    points = replace(shipped, shape=(3, 2, 4), unit_px=0.5).read(raw)
    assert points[0, 5].tolist() == [2.5, 6.5]


def test_a_crop_about_the_five_points_is_as_large_and_low_as_the_contract_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, picture: NDArray[np.float32]
) -> None:
    find = Landmarker(
        changed_contract(tmp_path, "side = 1.5", 'side = 2.0\nshift = 0.1\nbox = "five"')
    )
    taken: list[Crop] = []
    take = Crop.take

    def note(crop: Crop, image: NDArray[np.float32]) -> NDArray[np.float32]:
        taken.append(crop)
        return take(crop, image)

    monkeypatch.setattr(Crop, "take", note)
    level = np.array([[80.0, 100], [120, 100], [100, 120], [85, 150], [115, 150]])
    find(picture, level)
    (crop,) = taken
    assert crop.side_px == pytest.approx(2 * 2.6 * 50)
    assert crop.centre_px == pytest.approx((100, 125 + 0.1 * 2.6 * 50))
    assert crop.angle_rad == 0
