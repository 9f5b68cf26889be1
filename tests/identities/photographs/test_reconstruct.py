from dataclasses import replace

import cv2
import numpy as np
import pytest
from skimage.data import astronaut

from lrsr.errors import InputError
from lrsr.identities.day.another_day import AnotherDay
from lrsr.identities.face.expression import Expression
from lrsr.identities.head import Head
from lrsr.identities.morphable import sample_head
from lrsr.identities.photographs.mouth import _island
from lrsr.identities.photographs.outlines import filled
from lrsr.identities.photographs.picture_file import Photograph, decode, frame
from lrsr.identities.photographs.reconstruct import Reconstruction, reconstruct
from lrsr.identities.photographs.reconstructor import shared_reconstructor
from lrsr.identities.photographs.skin import extended

FIVE_PX = np.array([[205.0, 101.0], [247.0, 103.0], [224.0, 129.0], [202.0, 138.0], [244.0, 141.0]])
INNER_LIPS = (78, 82, 13, 312, 308, 317, 14, 87)
"""MediaPipe's, around the gap."""
SIZE = 128


@pytest.fixture(scope="module")
def photograph() -> Photograph:
    return frame(astronaut(), FIVE_PX)


@pytest.fixture(scope="module")
def made(photograph: Photograph) -> Reconstruction:
    return reconstruct(photograph, texture_size=SIZE)


@pytest.fixture(scope="module")
def head(made: Reconstruction) -> Head:
    return made.head("astronaut", {"photograph": "00"})


def test_a_head_has_the_topology_of_drawn_ones(head: Head) -> None:
    drawn = sample_head(1, texture_size=SIZE)
    assert [part.name for part in head.parts] == [part.name for part in drawn.parts]
    for ours, theirs in zip(head.parts, drawn.parts, strict=True):
        assert ours.material == theirs.material
        assert ours.vertices.shape == theirs.vertices.shape
        assert ours.albedo.shape == theirs.albedo.shape
        np.testing.assert_array_equal(ours.faces, theirs.faces)
        np.testing.assert_array_equal(ours.uv, theirs.uv)
    assert np.isfinite(head.parts[0].vertices).all()


def test_skin_is_matt_because_its_shine_is_painted(head: Head) -> None:
    roughness = head.part("skin").roughness
    assert roughness is not None
    assert (roughness == 1).all()


def test_the_photograph_measures_as_it_looks(made: Reconstruction) -> None:
    quality = made.quality
    assert abs(quality.yaw_deg) < 8
    assert 0 < quality.roll_deg < 6  # the eye on the right is 2 px of 42 lower
    assert abs(quality.ipd_px - 42) < 1
    assert quality.score is not None
    assert quality.score > 0.99
    assert quality.glasses_edge < 70
    assert made.parted  # teeth are seen
    assert made.fit.units["mouthSmileLeft"] > 0.2


def test_the_same_photograph_gives_the_same_bytes(
    photograph: Photograph, made: Reconstruction
) -> None:
    again = reconstruct(photograph, texture_size=SIZE)
    assert again.albedo.tobytes() == made.albedo.tobytes()


def test_cheeks_have_the_colour_of_skin_and_no_texel_is_missing(made: Reconstruction) -> None:
    assert np.isfinite(made.albedo).all()
    assert 0 < made.albedo.min() <= made.albedo.max() <= 1


def test_between_parted_lips_is_the_photograph(
    photograph: Photograph, made: Reconstruction
) -> None:
    points = shared_reconstructor()(photograph.srgb, photograph.five_px).points_px
    height, width = photograph.srgb.shape[:2]
    painted = photograph.srgb.copy()
    painted[filled(points, INNER_LIPS, (height, width))] = (0.0, 0.8, 0.0)
    box, mask = _island(SIZE)

    def green(of: Reconstruction) -> float:
        albedo = of.albedo[box][mask]
        return float((albedo[:, 1] > 2 * albedo[:, 0]).mean())

    teeth_of_grass = reconstruct(photograph._replace(srgb=painted), texture_size=SIZE)
    assert green(made) == 0
    assert green(teeth_of_grass) > 0.5


def test_a_neutral_face_has_a_closed_mouth(made: Reconstruction) -> None:
    smiling, neutral = made.head("a", {}), replace(made, kept="neutral").head("a", {})
    assert np.ptp(smiling.landmarks[3:, 0]) > np.ptp(neutral.landmarks[3:, 0])
    np.testing.assert_array_equal(smiling.pupils, neutral.pupils)


def test_a_head_acts_beyond_the_photograph(made: Reconstruction) -> None:
    calm, blinking = (
        made.head("a", {}, expression)
        for expression in (Expression("as it is"), Expression("blink", {"eyeBlink": 1.0}))
    )
    moved = np.linalg.norm(calm.parts[0].vertices - blinking.parts[0].vertices, axis=1)
    assert moved.max() > 3


def test_glasses_can_be_worn(made: Reconstruction) -> None:
    dressed = made.head("a", {}, another_day=AnotherDay("glasses", glasses=1.0))
    assert dressed.part("glasses").vertices.shape[0] > 0
    assert dressed.parameters["another_day"]


def test_a_face_that_is_not_seen_is_refused(photograph: Photograph) -> None:
    elsewhere = photograph._replace(five_px=photograph.five_px * [1, -1] - [500, 500])
    with pytest.raises(InputError, match="neither cheeks nor nose are seen"):
        reconstruct(elsewhere, texture_size=64)


def test_a_large_picture_is_cut_and_reduced() -> None:
    large = np.zeros((4000, 5000, 3), np.uint8)
    five = np.array([[2000, 1500], [2900, 1500], [2450, 2000], [2100, 2400], [2800, 2400]])
    cut = frame(large, five)
    np.testing.assert_allclose(np.linalg.norm(cut.five_px[1] - cut.five_px[0]), 300, rtol=0.01)
    assert max(cut.srgb.shape) < 8.5 * 300
    assert cut.ipd_px == 900


def test_sixteen_bits_and_grey_are_read() -> None:
    grey = (np.arange(64, dtype=np.uint16).reshape(8, 8)) * 1000
    _, png = cv2.imencode(".png", grey)
    assert decode(png.tobytes(), "x").shape == (8, 8, 3)


def test_what_is_no_picture_is_refused() -> None:
    with pytest.raises(InputError, match="is no picture"):
        decode(b"no picture", "x.jpg")


def test_extension_keeps_what_is_known_and_fills_with_it() -> None:
    values, weight = np.zeros((32, 32, 3), np.float32), np.zeros((32, 32), np.float32)
    values[:, :8], weight[:, :8] = 2.0, 1.0
    filled = extended(values, weight, blur=0.5)
    np.testing.assert_allclose(filled, 2.0, atol=1e-3)
