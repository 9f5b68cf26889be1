import json
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest
import torch
from oracles.make_alignments import CASES, picture
from skimage.transform import SimilarityTransform

from lrsr.errors import ImageContractError
from lrsr.images import scale_points
from lrsr.recognition.alignment import (
    _EYES_PX,
    TEMPLATE_PX,
    _boxes_about,
    align,
    fit_similarities,
    landmark_errors,
    read_landmarks,
    warp,
    whole_pictures,
)

DATA = Path(__file__).parents[1] / "data"


def some_landmarks(count: int, seed: int = 0) -> np.ndarray:
    """Turned, moved, scaled and disturbed copies of the template."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-0.6, 0.6, count)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    size = rng.uniform(0.1, 9, count)[:, None, None]
    points = size * np.einsum("ijb,kj->bki", turn, TEMPLATE_PX)
    return points + rng.uniform(-50, 300, (count, 1, 2)) + size * rng.normal(0, 3, (count, 5, 2))


def ramp(side: int) -> torch.Tensor:
    """Red grows by 1/1000 a pixel to the right, green downwards; blue is flat."""
    y, x = torch.meshgrid(torch.arange(side), torch.arange(side), indexing="ij")
    return torch.stack([x / 1000, y / 1000, torch.full((side, side), 0.5)])[None].float()


def test_the_fit_is_that_of_scikit_image() -> None:
    landmarks = some_landmarks(20)
    for points, matrix in zip(landmarks, fit_similarities(landmarks), strict=True):
        oracle = SimilarityTransform.from_estimate(points, TEMPLATE_PX).params[:2]
        np.testing.assert_allclose(matrix, oracle, atol=1e-9)


def test_ten_pixels_between_the_eyes_are_enlarged_three_and_a_half_times() -> None:
    ipd = np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0])
    matrix = fit_similarities(TEMPLATE_PX[None] * 10 / ipd)[0]
    assert np.sqrt(np.linalg.det(matrix[:, :2])) == pytest.approx(3.524, abs=1e-3)


def test_a_mirrored_face_is_turned_but_never_mirrored() -> None:
    mirrored = TEMPLATE_PX * [-1, 1]
    matrix = fit_similarities(mirrored[None])[0]
    oracle = SimilarityTransform.from_estimate(mirrored, TEMPLATE_PX).params[:2]
    np.testing.assert_allclose(matrix, oracle, atol=1e-9)
    assert np.linalg.det(matrix[:, :2]) > 0


@pytest.mark.parametrize(
    "landmarks",
    [np.full((1, 5, 2), np.nan), np.full((1, 5, 2), 7.0), np.full((1, 5, 2), np.inf)],
    ids=["nan", "coincident", "infinite"],
)
def test_no_face_gives_nan_and_a_black_crop(landmarks: np.ndarray) -> None:
    assert np.isnan(fit_similarities(landmarks)).all()
    crops, found = align(ramp(20), landmarks, antialias=True)
    assert not found.any()
    assert not crops.any()


def test_a_failure_leaves_the_other_faces_alone() -> None:
    landmarks = np.concatenate([TEMPLATE_PX[None], np.full((1, 5, 2), np.nan)])
    crops, found = align(ramp(112).repeat(2, 1, 1, 1), landmarks, antialias=False)
    assert found.tolist() == [True, False]
    torch.testing.assert_close(crops[0], ramp(112)[0], atol=1e-6, rtol=0)


def test_the_warp_reads_between_pixels_where_the_matrix_says() -> None:
    # x = 2 u + 3, y = 2 v + 5: the crop's (u, v) is the image's ((u - 3) / 2, (v - 5) / 2)
    matrix = np.array([[[2.0, 0.0, 3.0], [0.0, 2.0, 5.0]]])
    crop = warp(ramp(40), matrix, size_px=30, antialias=False)[0]
    assert float(crop[0, 11, 12]) == pytest.approx((12 - 3) / 2 / 1000, abs=1e-7)
    assert float(crop[1, 12, 12]) == pytest.approx((12 - 5) / 2 / 1000, abs=1e-7)


def test_the_warp_is_opencvs_within_opencvs_rounding() -> None:
    image = torch.rand(1, 3, 60, 50, generator=torch.Generator().manual_seed(0))
    image = torch.nn.functional.avg_pool2d(image, 9, 1, 4)
    matrix = fit_similarities(some_landmarks(1, seed=4) / 9)
    ours = warp(image, matrix, size_px=112, antialias=False)[0].permute(1, 2, 0).numpy()
    theirs = cv2.warpAffine(
        image[0].permute(1, 2, 0).numpy(), matrix[0], (112, 112), flags=cv2.INTER_LINEAR
    )
    assert ours.any()
    assert np.abs(ours - theirs).max() < 0.02  # OpenCV rounds places to 1/32 px


def test_outside_the_image_is_black() -> None:
    shift = np.array([[[1.0, 0.0, 10.0], [0.0, 1.0, 0.0]]])
    crop = warp(torch.ones(1, 1, 8, 8), shift, size_px=8, antialias=False)
    assert not crop.any()


def test_outside_the_image_its_edge_can_go_on() -> None:
    shift = np.array([[[1.0, 0.0, 10.0], [0.0, 1.0, 0.0]]])
    crop = warp(ramp(20)[:, :, :, 5:], shift, size_px=20, antialias=False, outside="border")
    torch.testing.assert_close(crop[0, 0, :, :10], torch.full((20, 10), 0.005))


@pytest.mark.parametrize(("height", "width", "shift"), [(224, 224, 0), (112, 96, -8), (96, 112, 8)])
def test_other_sizes_take_the_template_by_their_height(
    height: int, width: int, shift: float
) -> None:
    images = torch.rand(1, 3, height, width, generator=torch.Generator().manual_seed(0))
    landmarks = TEMPLATE_PX[None] * height / 112 + [shift, 0]
    crops, _ = align(images, landmarks, antialias=False, size_px=(height, width))
    np.testing.assert_allclose(crops, images, atol=1e-4)


def test_antialiasing_averages_what_one_sample_would_miss() -> None:
    y, x = np.mgrid[:224, :224]
    board = torch.from_numpy(((x + y) % 2).astype(np.float32))[None, None]
    half = np.array([[[0.5, 0.0, -0.5], [0.0, 0.5, -0.5]]])  # sample on pixel centres: one colour
    aliased = warp(board, half, size_px=100, antialias=False)[0, 0, 5:90, 5:90]
    torch.testing.assert_close(aliased, torch.zeros_like(aliased), atol=1e-4, rtol=0)
    smooth = warp(board, half, size_px=100, antialias=True)[0, 0, 5:90, 5:90]
    torch.testing.assert_close(smooth, torch.full_like(smooth, 0.5), atol=1e-4, rtol=0)


def test_antialiasing_leaves_an_enlarged_face_alone() -> None:
    landmarks = TEMPLATE_PX[None] * 0.5
    sharp, _ = align(ramp(56), landmarks, antialias=False)
    smooth, _ = align(ramp(56), landmarks, antialias=True)
    assert torch.equal(sharp, smooth)


def test_a_face_does_not_depend_on_its_batch() -> None:
    images = torch.rand(3, 3, 90, 90, generator=torch.Generator().manual_seed(1))
    landmarks = np.stack([TEMPLATE_PX * size for size in (0.4, 0.8, 2.5)])
    together, _ = align(images, landmarks, antialias=True)
    alone, _ = align(images[2:], landmarks[2:], antialias=True)
    assert torch.equal(together[2], alone[0])


def test_a_finer_film_of_the_same_scene_aligns_to_the_same_crop() -> None:
    """Pixel centres at half-integers, everywhere: otherwise the two would be shifted."""
    coarse = ramp(40)
    y, x = torch.meshgrid(torch.arange(160), torch.arange(160), indexing="ij")
    fine = torch.stack(
        [((x + 0.5) / 4 - 0.5) / 1000, ((y + 0.5) / 4 - 0.5) / 1000, torch.full((160, 160), 0.5)]
    )[None].float()
    points = torch.from_numpy(TEMPLATE_PX * 0.2 + 9)
    low, _ = align(coarse, points[None].numpy(), antialias=False)
    high, _ = align(fine, scale_points(points, 4)[None].numpy(), antialias=False)
    torch.testing.assert_close(low, high, atol=1e-5, rtol=0)


@pytest.mark.parametrize("shape", [(5, 2), (1, 4, 2), (1, 5, 3)])
def test_landmarks_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(ImageContractError, match=r"wanted \(B, 5, 2\)"):
        fit_similarities(np.zeros(shape))


def test_images_and_landmarks_must_be_as_many() -> None:
    with pytest.raises(ImageContractError, match="1 images but landmarks for 2"):
        align(ramp(9), np.zeros((2, 5, 2)), antialias=False)


@pytest.mark.parametrize(
    "make",
    [
        lambda points: points.tolist(),
        lambda points: tuple(map(tuple, points)),
        lambda points: points.astype(np.int64),
        lambda points: np.ma.masked_array(points),
        lambda points: torch.from_numpy(points),
        lambda points: torch.from_numpy(points).bfloat16(),
        lambda points: torch.from_numpy(points).requires_grad_(),
        lambda points: list(torch.from_numpy(points)),
    ],
    ids=["list", "tuple", "int64", "masked", "float64", "bfloat16", "gradient", "tensors"],
)
def test_landmarks_may_be_numbers_of_any_kind(make: Callable[[np.ndarray], object]) -> None:
    points = np.round(TEMPLATE_PX[None] / 4) * 2  # whole numbers that bfloat16 holds
    read = read_landmarks(make(points))
    assert read.dtype == np.float64
    np.testing.assert_array_equal(read, points)


def test_a_masked_landmark_is_none() -> None:
    mask = np.zeros((2, 5, 2), dtype=bool)
    mask[1, 3, 0] = True
    landmarks = np.ma.masked_array(np.stack([TEMPLATE_PX, TEMPLATE_PX]), mask)
    _, found = align(ramp(112).repeat(2, 1, 1, 1), landmarks, antialias=False)
    assert found.tolist() == [True, False]
    assert np.isnan(read_landmarks(landmarks)[1, 3, 0])


def test_a_masked_whole_number_is_none_too() -> None:
    whole = np.ma.masked_equal(np.stack([TEMPLATE_PX.round().astype(int)]), 38)
    assert np.isnan(read_landmarks(whole)).sum() == 1


@pytest.mark.parametrize(
    "odd",
    [[[[1, 2]] * 4 + [[1]]], "five points", [[["x", "y"]] * 5], None, [None], 3.0],
    ids=["ragged", "words", "letters", "none", "nobody", "number"],
)
def test_landmarks_that_are_no_points_are_refused(odd: object) -> None:
    with pytest.raises(ImageContractError, match=r"landmarks_px.* (give|wanted) \(B, 5, 2\)"):
        read_landmarks(odd)


def test_landmarks_of_another_number_are_refused_where_it_is_known() -> None:
    with pytest.raises(ImageContractError, match=r"got shape \(1, 5, 2\), wanted \(2, 5, 2\)"):
        read_landmarks(TEMPLATE_PX[None], 2)


def test_landmarks_far_beyond_their_picture_are_refused() -> None:
    """A lost decimal point would ask for the memory of all rays between them."""
    with pytest.raises(ImageContractError, match="5000 px from one to another"):
        align(
            torch.zeros(1, 3, 16, 16), TEMPLATE_PX[None] * 0 + np.eye(5, 2) * 5000, antialias=True
        )


@pytest.mark.parametrize("name", CASES)
def test_the_crop_is_that_of_insightface(name: str) -> None:
    levels = torch.from_numpy(picture()).permute(2, 0, 1)[None].float()
    crops, _ = align(levels / 255, [CASES[name][0]], antialias=False)
    got = crops[0].permute(1, 2, 0)[4::16, 4::16]
    oracle = json.loads((DATA / "alignments_insightface.json").read_text())[name]
    np.testing.assert_allclose(got, np.array(oracle) / 255, atol=1e-5)


@pytest.mark.parametrize("spare", [np.nan, 1e3], ids=["not known", "anywhere"])
def test_eyes_are_brought_level_whatever_the_other_points(spare: float) -> None:
    points = some_landmarks(6)
    points[:, 2:] = spare
    for matrix, eyes in zip(fit_similarities(points, _EYES_PX), points[:, :2], strict=True):
        np.testing.assert_allclose(eyes @ matrix[:, :2].T + matrix[:, 2], _EYES_PX, atol=1e-9)
        assert np.linalg.det(matrix[:, :2]) > 0


def test_a_face_cut_out_as_by_deepface_needs_its_box(rendered: torch.Tensor) -> None:
    points, box = CASES["turned"]
    twice = rendered.repeat(2, 1, 1, 1)
    crops, found = align(
        twice, [points] * 2, antialias=False, template="deepface", boxes_px=[box, [90, 90, 95, 95]]
    )
    assert found.tolist() == [True, False]
    assert crops[0].any()
    assert not crops[1].any()


def test_without_a_box_deepface_gets_one_about_the_eyes(rendered: torch.Tensor) -> None:
    points = np.array([CASES["upright"][0]], dtype=float)
    given, _ = align(
        rendered, points, antialias=False, template="deepface", boxes_px=_boxes_about(points)
    )
    crops, _ = align(rendered, points, antialias=False, template="deepface")
    assert torch.equal(crops, given)
    left, top, right, bottom = _boxes_about(points)[0]
    assert left < 14 < 22 < right
    assert top < 12 < 21 < bottom


def test_a_whole_picture_stands_for_a_face() -> None:
    (crop,) = whole_pictures(torch.full((1, 3, 8, 4), 0.6))
    torch.testing.assert_close(crop[:, :, 28:84], torch.full((3, 112, 56), 0.6))
    assert not crop[:, :, :28].any()


def test_errors_are_counted_in_distances_of_the_true_eyes() -> None:
    found = np.stack([TEMPLATE_PX + np.array([3, 4]), TEMPLATE_PX, np.full((5, 2), np.nan)])
    ipd_px = np.linalg.norm(TEMPLATE_PX[1] - TEMPLATE_PX[0])
    errors = landmark_errors(found, np.stack([TEMPLATE_PX] * 3))
    np.testing.assert_allclose(errors, [5 / ipd_px, 0, np.nan])


@pytest.fixture
def rendered() -> torch.Tensor:
    return torch.from_numpy(picture()).permute(2, 0, 1)[None].float() / 255
