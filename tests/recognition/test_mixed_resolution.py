"""Tests of lrsr/recognition/mixed_resolution.py."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.numpy import save_file
from scipy.ndimage import gaussian_filter

from lrsr.errors import ImageContractError, InputError
from lrsr.images import resize_bicubic, scale_points
from lrsr.recognition.alignment import TEMPLATE_IPD_PX, TEMPLATE_PX
from lrsr.recognition.mixed_resolution import (
    Card,
    CommonSpace,
    MixedResolution,
    _read_space,
    _side_px,
    cut_faces,
    write_space,
)
from lrsr.recognition.recognisers import find_recognisers, load_recognisers

CARD = Card(8.0, 16.0, 60, "probes: poses frontal", "a test")
LANDMARKS = TEMPLATE_PX[None] + 20


def space(card: Card = CARD, dimension: int = 4) -> CommonSpace:
    rng = np.random.default_rng(0)
    small, large = (_side_px(ipd) ** 2 for ipd in (card.probe_ipd_px, card.gallery_ipd_px))
    parts = [rng.normal(size=size) for size in (small, (small, dimension))]
    parts += [rng.normal(size=size) for size in (large, (large, dimension))]
    parts = [part.astype(np.float32) / 30 for part in parts]
    return CommonSpace(*parts, np.linspace(0.9, 0.1, dimension, dtype=np.float32))


@pytest.fixture
def weights(tmp_path: Path) -> Path:
    write_space(tmp_path / "model.safetensors", space(), CARD)
    return tmp_path / "model.safetensors"


def faces(*seeds: int) -> torch.Tensor:
    noise = [np.random.default_rng(seed).normal(size=(3, 152, 152)) for seed in seeds]
    smooth = [gaussian_filter(one, (0, 4, 4)) for one in noise]
    return torch.from_numpy(np.clip(0.5 + 2 * np.stack(smooth), 0, 1).astype(np.float32))


def test_eyes_stand_as_far_apart_as_asked() -> None:
    picture = torch.zeros(1, 3, 152, 152)
    eyes = LANDMARKS[0, :2].round().astype(int)
    for x, y in eyes:
        picture[:, :, y - 2 : y + 3, x - 2 : x + 3] = 1
    rows, found = cut_faces(picture, LANDMARKS, 16.0)
    side = _side_px(16.0)
    crop = rows.reshape(side, side).clip(0)
    assert found.all()
    columns = np.arange(side)
    left, right = (
        (crop[:, part] * columns[part]).sum() / crop[:, part].sum()
        for part in (slice(0, side // 2), slice(side // 2, side))
    )
    apart = 16.0 * np.ptp(eyes[:, 0]) / TEMPLATE_IPD_PX
    assert right - left == pytest.approx(apart, abs=0.2)  # of 47 columns


def test_neither_brightness_nor_contrast_counts() -> None:
    face = faces(1)
    rows, _ = cut_faces(face, LANDMARKS, 8.0)
    assert (rows.mean(), rows.std()) == pytest.approx((0, 1), abs=1e-4)
    np.testing.assert_allclose(cut_faces(face * 0.5 + 0.2, LANDMARKS, 8.0)[0], rows, atol=1e-3)


def test_an_enlarged_probe_is_seen_as_what_it_was() -> None:
    small = resize_bicubic(faces(1), 1 / 4).clamp(0, 1)
    points = torch.from_numpy((LANDMARKS + 0.5) / 4 - 0.5)
    large = resize_bicubic(small, 4).clamp(0, 1)
    rows = [
        cut_faces(image, at.numpy(), 8.0)[0]
        for image, at in ((small, points), (large, scale_points(points, 4)))
    ]
    assert np.corrcoef(*np.vstack(rows))[0, 1] > 0.98


def test_a_score_takes_each_face_by_its_own_side(weights: Path) -> None:
    recogniser = MixedResolution(weights)
    rows = recogniser.embed(faces(1, 2), np.concatenate([LANDMARKS] * 2))
    assert (rows.shape, rows.dtype) == ((2, 8), np.float32)
    known = space()
    small, large = (cut_faces(faces(1, 2), LANDMARKS.repeat(2, 0), ipd)[0] for ipd in (8.0, 16.0))
    x, y = (small - known.probe_mean) @ known.probe_map, known.of_gallery(large)
    rho = known.correlations.astype(np.float64)
    wanted = -np.log(1 - rho**2) / 2 - (
        rho**2 * (x[0] ** 2 + y[1] ** 2) - 2 * rho * x[0] * y[1]
    ) / (2 * (1 - rho**2))
    found = recogniser.compare(rows, rows, "ab", "ab").rows(0, 2)
    assert found[0, 1] == pytest.approx(wanted.sum(), rel=1e-4)
    assert found[0, 1] != pytest.approx(found[1, 0], rel=1e-3)


def test_no_face_has_no_row(weights: Path) -> None:
    rows = MixedResolution(weights).embed(faces(1, 2), np.vstack([LANDMARKS, LANDMARKS * np.nan]))
    assert np.isnan(rows).all(axis=1).tolist() == [False, True]


def test_broken_pictures_are_refused(weights: Path) -> None:
    with pytest.raises(ImageContractError, match="srgb"):
        MixedResolution(weights).embed(faces(1) * 2, LANDMARKS)


def test_weights_come_back_with_their_card(weights: Path) -> None:
    known, card = _read_space(weights)
    assert card == CARD
    np.testing.assert_array_equal(known.gallery_map, space().gallery_map)
    about = MixedResolution(weights).describe()
    assert (about["probe_ipd_px"], about["people"], about["dimension"]) == (8.0, 60, 4)


@pytest.mark.parametrize(
    ("card", "changes", "message"),
    [
        pytest.param(replace(CARD, probe_ipd_px=9.0), {}, "do not fit its card", id="other-size"),
        pytest.param(CARD, {"correlations": [0.5, 1.0, 0.1, 0.1]}, "do not fit", id="certain"),
        pytest.param(CARD, {"probe_mean": [np.nan] * 625}, "do not fit its card", id="nan"),
    ],
)
def test_numbers_that_cannot_be_used_are_refused(
    tmp_path: Path, card: Card, changes: dict[str, list[float]], message: str
) -> None:
    path = tmp_path / "model.safetensors"
    write_space(path, replace(space(), **{k: np.float32(v) for k, v in changes.items()}), card)
    with pytest.raises(InputError, match=message):
        _read_space(path)


def test_files_of_something_else_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "other.safetensors"
    with pytest.raises(InputError, match="is missing: "):
        _read_space(path)
    path.write_bytes(b"no")
    with pytest.raises(InputError, match="no safetensors file"):
        _read_space(path)
    for told in ({"people": "60"}, {"mixed_resolution": "{}"}, {"mixed_resolution": "sixty"}):
        save_file({"weight": np.zeros(3, np.float32)}, path, metadata=told)
        with pytest.raises(InputError, match="is not of mixed_resolution"):
            _read_space(path)


def test_it_is_a_recogniser_by_name_or_by_file(weights: Path) -> None:
    by_name = find_recognisers(["hog", "mixed_resolution"], weights=weights)
    assert by_name == {"hog": "hog", "mixed_resolution": weights}
    assert find_recognisers([str(weights)]) == {"model": weights}
    assert isinstance(load_recognisers(by_name)["mixed_resolution"], MixedResolution)


def test_weights_and_name_go_together(weights: Path) -> None:
    with pytest.raises(InputError, match="lrsr train recognition=mixed_resolution"):
        find_recognisers(["mixed_resolution"])
    with pytest.raises(InputError, match="add mixed_resolution to recognisers"):
        find_recognisers(["hog"], weights=weights)
