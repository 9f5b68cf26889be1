import numpy as np
import pytest

from lrsr.identities.photographs.hair import paint_hair
from lrsr.identities.photographs.perspective import Perspective
from lrsr.identities.photographs.shot import Shot, Texels
from lrsr.identities.photographs.skin import PhotographedSkin
from lrsr.identities.photographs.zones import zones

SIZE = 64
SIDE_PX = 320
"""Of the picture, a px for a millimetre, its middle between the eyes."""
SKIN, DARK, WHITE = (0.5, 0.3, 0.2), (0.03, 0.02, 0.015), (0.6, 0.6, 0.6)
UP, ASIDE = SIDE_PX / 2 - np.arange(SIDE_PX)[:, None], np.arange(SIDE_PX)[None] - SIDE_PX / 2
PERSON = np.hypot(ASIDE / 90, (UP + 10) / 150) < 1
POINTS = zones(SIZE).points
BEHIND = (POINTS[..., 1] > 80) & (POINTS[..., 2] < -100)


def painted(
    hair: tuple[float, ...], *, from_mm: float = 60.0, until_mm: float = 160.0
) -> np.ndarray:
    """Paint the head of somebody whose hair begins that high; the picture ends that high."""
    picture = np.full((SIDE_PX, SIDE_PX, 3), (0.0, 0.0, 1.0), np.float32)
    picture[PERSON] = SKIN
    picture[PERSON & (from_mm < UP)] = hair
    cut = round(SIDE_PX / 2 - until_mm)
    middle = np.array([SIDE_PX / 2, cut - SIDE_PX / 2])
    seen_by = Perspective(np.eye(3), 1.0, middle, 1e-6, np.zeros(3))
    shot = Shot(picture[cut:], seen_by, np.zeros((468, 2)), 64.0)
    px, _ = shot.perspective.project(POINTS.reshape(-1, 3).astype(np.float64))
    front = (POINTS[..., 2] > -60).astype(np.float32)
    places = px.reshape(SIZE, SIZE, 2).astype(np.float32)
    seen = Texels(places, front, np.zeros_like(POINTS), front > 0)
    known = ((POINTS[..., 1] < 40) & (front > 0)).astype(np.float32)
    skin = PhotographedSkin(
        albedo=np.full((SIZE, SIZE, 3), SKIN, np.float32),
        lit=seen.sample(shot.linear),
        gain=np.ones(3, np.float32),
        known=known,
        hidden=np.zeros_like(known),
        seen=1.0,
        unevenness=0.0,
        tint=(0.0, 0.0),
    )
    return paint_hair(skin, shot, seen, PERSON[cut:])


@pytest.mark.parametrize("hair", [DARK, WHITE], ids=["dark", "white"])
def test_hair_goes_on_behind_the_crown(hair: tuple[float, ...]) -> None:
    np.testing.assert_allclose(painted(hair)[BEHIND], np.broadcast_to(hair, (BEHIND.sum(), 3)), 0.1)


def test_hair_that_begins_above_the_skull_goes_on_too() -> None:
    crown = np.median(painted(DARK, from_mm=95)[BEHIND], axis=0)
    np.testing.assert_allclose(crown, DARK, rtol=0.1)


def test_who_is_bald_stays_bald() -> None:
    albedo = painted(SKIN)
    np.testing.assert_allclose(albedo, np.broadcast_to(SKIN, albedo.shape), atol=0.01)


def test_the_face_is_left_alone() -> None:
    face = (POINTS[..., 1] < 20) & (POINTS[..., 2] > -40)
    np.testing.assert_allclose(painted(DARK)[face], np.broadcast_to(SKIN, (face.sum(), 3)), 1e-3)


def test_nothing_is_painted_of_a_head_that_is_cut_at_the_forehead() -> None:
    albedo = painted(DARK, until_mm=50)
    np.testing.assert_allclose(albedo, np.broadcast_to(SKIN, albedo.shape), atol=1e-6)
