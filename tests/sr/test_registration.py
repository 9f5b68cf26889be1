"""Frames of a scene that is known by formula are laid over each other to a part of a pixel."""

from typing import Any

import pytest
import torch
from oracles.waves import picture, shifted

from lrsr.errors import ImageContractError, InputError
from lrsr.sr.registration import Correlation, TrueLandmarks

SIDE = 24
CORNERS = torch.tensor([[4.0, 4], [19, 4], [4, 19], [19, 19]])


def burst(*motions: torch.Tensor) -> torch.Tensor:
    return torch.stack([picture(SIDE), *(picture(SIDE, one) for one in motions)])[None]


def misplaced_px(found: torch.Tensor, true: torch.Tensor) -> float:
    """How far points of the frame land from where they are, at most."""
    ones = torch.cat([CORNERS, torch.ones(4, 1)], dim=1)
    return float((ones @ (found.double() - true).float().T).norm(dim=1).max())


@pytest.mark.parametrize(
    ("motion", "true"),
    [
        ("shift", shifted(0.37, -0.81)),
        ("rigid", shifted(-0.6, 0.25)),
        ("rigid", shifted(0.9, -0.4, turn_deg=2)),
        ("affine", shifted(0.3, 0.2, turn_deg=-1)),
    ],
    ids=["shift", "rigid, shifted", "rigid, turned", "affine"],
)
def test_a_motion_is_found_to_a_twentieth_of_a_pixel(motion: str, true: torch.Tensor) -> None:
    first, second = Correlation(motion)(burst(true))[0]
    assert torch.equal(first, torch.eye(2, 3))
    assert misplaced_px(second, true) < 0.05


def test_another_exposure_is_the_same_place() -> None:
    frames = burst(shifted(0.5, 0.3))
    frames[:, 1] = 0.6 * frames[:, 1] + 0.1
    assert misplaced_px(Correlation()(frames)[0, 1], shifted(0.5, 0.3)) < 0.05


@pytest.mark.parametrize("other", [torch.full((3, SIDE, SIDE), 0.5), 1 - picture(SIDE)])
def test_what_shows_something_else_is_not_registered(other: torch.Tensor) -> None:
    frames = torch.stack([picture(SIDE), other])[None]
    found = Correlation(finer=1)(frames)[0]
    assert torch.equal(found[0], torch.eye(2, 3))
    assert found[1].isnan().all()


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"motion": "homography"}, "registration.motion=homography: wanted one of shift, rigid"),
        ({"finer": 9}, "registration.finer=9: wanted 1 to 8"),
        ({"finer": 1.5}, "registration.finer=1.5: wanted a whole number"),
        ({"least": 2}, "registration.least=2: wanted 0 to 1"),
    ],
    ids=str,
)
def test_wrong_settings_are_refused(wrong: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Correlation(**wrong)


def test_known_points_give_their_similarity() -> None:
    true = shifted(0.7, -1.2, turn_deg=5)
    true[:, :2] *= 1.03
    ones = torch.cat([CORNERS, torch.ones(4, 1)], dim=1).double()
    points = torch.stack([CORNERS, (ones @ true.T).float()])[None]
    found = TrueLandmarks()(torch.zeros(1, 2, 3, SIDE, SIDE), points)
    torch.testing.assert_close(found[0, 0], torch.eye(2, 3), atol=1e-5, rtol=0)
    torch.testing.assert_close(found[0, 1], true.float(), atol=1e-5, rtol=0)


def test_a_frame_without_landmarks_is_not_registered_and_a_burst_without_is_refused() -> None:
    frames = torch.zeros(1, 2, 3, SIDE, SIDE)
    points = torch.stack([CORNERS, torch.full_like(CORNERS, torch.nan)])[None]
    assert TrueLandmarks()(frames, points).isnan().any(dim=(2, 3)).tolist() == [[False, True]]
    with pytest.raises(ImageContractError, match="those of a first frame are not known"):
        TrueLandmarks()(frames, points.flip(1))
    with pytest.raises(ImageContractError, match=r"got None, wanted \(1, 2, P, 2\)"):
        TrueLandmarks()(frames)
    with pytest.raises(ImageContractError, match=r"got \(1, 1, 4, 2\), wanted \(1, 2, P, 2\)"):
        TrueLandmarks()(frames, points[:, :1])
