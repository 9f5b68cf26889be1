"""Tests of lrsr/experiments/likeness.py."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from fakes.networks import write_difference

from lrsr.evaluation.quality import psnr_y, ssim_y
from lrsr.experiments.likeness import MEASURES, Truth, by_size
from lrsr.pictures.picture import Picture
from lrsr.recognition import Engine
from lrsr.recognition.alignment import TEMPLATE_PX
from lrsr.recognition.features import Features
from lrsr.sr.perceptual import PerceptualDistance

POINTS = torch.from_numpy(TEMPLATE_PX / 2).float()


class Counting(Engine):
    """Counts the faces that it is shown."""

    shown = 0

    def embed(self, srgb: Any, landmarks_px: Any, boxes_px: Any = None) -> Any:
        self.shown += len(srgb)
        return super().embed(srgb, landmarks_px)


def pictures(count: int, seed: int = 0) -> list[Picture]:
    images = torch.rand(count, 3, 56, 56, generator=torch.Generator().manual_seed(seed))
    return [Picture(image, "p", POINTS, "") for image in images]


def images(some: list[Picture]) -> torch.Tensor:
    return torch.stack([one.image for one in some])


def test_pictures_of_one_size_make_a_batch() -> None:
    a, b = pictures(2), [replace(one, image=one.image[:, :40]) for one in pictures(1)]
    assert by_size([a[0], *b, a[1]]) == [[0, 2], [1]]


def test_each_measure_holds_a_picture_against_its_own_reference(tone_model: Path) -> None:
    true, made = pictures(3), pictures(3, seed=1)
    engine = Engine(tone_model)
    embedded = engine.embed(images(made), np.stack([POINTS] * 3))
    found = Truth(true, engine).measure([2, 0], images(made)[[2, 0]], embedded[[2, 0]], scale=2)
    pair = images(made)[[2, 0]].numpy(), images(true)[[2, 0]].numpy()
    np.testing.assert_array_equal(found["psnr_y_db"], psnr_y(*pair, 2))
    np.testing.assert_array_equal(found["ssim_y"], ssim_y(*pair, 2))
    other = engine.embed(images(true), np.stack([POINTS] * 3))
    cosines = (embedded * other).sum(axis=1)[[2, 0]]
    np.testing.assert_allclose(found["identity_similarity"], cosines, rtol=1e-5)
    assert "lpips" not in found


def test_the_truth_is_like_itself(tone_model: Path) -> None:
    true, engine = pictures(2), Engine(tone_model)
    rows = engine.embed(images(true), np.stack([POINTS] * 2))
    found = Truth(true, engine).measure([0, 1], images(true), rows, scale=2)
    assert found["ssim_y"] == pytest.approx([1, 1])
    assert found["identity_similarity"] == pytest.approx([1, 1])
    assert np.isposinf(found["psnr_y_db"]).all()


def test_histograms_are_compared_as_histograms_are() -> None:
    true, engine = pictures(2), Features("lbp")
    rows = engine.embed(images(true), np.stack([POINTS] * 2))
    found = Truth(true, engine).measure([0, 1], images(true), rows[::-1], scale=2)
    ids = ["0", "1"]
    wanted = engine.compare(rows[::-1].astype(float), rows.astype(float), ids, ids).mated_scores()
    assert found["identity_similarity"] == pytest.approx(wanted)


def test_references_are_embedded_once_for_all_methods(tone_model: Path) -> None:
    mixed = pictures(3) + [replace(one, image=one.image[:, :40]) for one in pictures(2)]
    engine = Counting(tone_model)
    truth = Truth(mixed, engine)
    rows = np.zeros((3, 147), dtype=np.float32)
    for _ in range(3):
        truth.measure([0, 1, 2], images(mixed[:3]), rows, scale=2)
    assert engine.shown == 5


def test_where_nobody_knows_the_landmarks_identity_is_not_known(tone_model: Path) -> None:
    true = [replace(one, landmarks_px=None) for one in pictures(2)]
    rows = np.full((2, 147), np.nan, dtype=np.float32)
    found = Truth(true, Engine(tone_model)).measure([0, 1], images(true), rows, scale=2)
    assert np.isnan(found["identity_similarity"]).all()
    assert np.isfinite(found["ssim_y"]).all()


def test_a_network_of_the_users_is_asked_too(tone_model: Path, tmp_path: Path) -> None:
    true, made = pictures(2), pictures(2, seed=1)
    rows = np.zeros((2, 147), dtype=np.float32)
    looks = PerceptualDistance(write_difference(tmp_path / "lpips.onnx"))
    found = Truth(true, Engine(tone_model), looks).measure([0, 1], images(made), rows, scale=2)
    assert tuple(found) == MEASURES
    wanted = (2 * (images(made) - images(true))).square().mean(dim=(1, 2, 3))
    np.testing.assert_allclose(found["lpips"], wanted, rtol=1e-5)
