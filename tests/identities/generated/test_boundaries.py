from pathlib import Path
from typing import Any

import numpy as np
import pytest

from lrsr.errors import InputError
from lrsr.identities.generated.boundaries import (
    Boundaries,
    learn_boundaries,
    read_boundaries,
    write_boundaries,
)

RNG = np.random.default_rng(1)
FACES = (RNG.standard_normal((600, 8)) * 0.4 + 2).astype(np.float32)
FIRST, SECOND = (row / np.linalg.norm(row) for row in RNG.standard_normal((2, 8)))
OBLIQUE = (FIRST + SECOND) / np.linalg.norm(FIRST + SECOND)


def learned(scores: dict[str, Any], **neutral: float | None) -> Boundaries:
    return learn_boundaries(FACES, scores, neutral, 0.15, {"seed": 1})


A = float(np.quantile(FACES @ FIRST, 0.7))
BOTH = learned({"a": FACES @ FIRST, "b": FACES @ OBLIQUE}, a=A, b=None)


def test_the_normal_is_the_direction_that_the_attribute_follows() -> None:
    assert BOTH.normals[0] @ FIRST > 0.98
    assert BOTH.normals[1] @ OBLIQUE > 0.98
    assert np.linalg.norm(BOTH.normals, axis=1) == pytest.approx([1, 1])


def test_noise_in_the_scores_is_averaged_out() -> None:
    noisy = FACES @ FIRST + 0.2 * np.random.default_rng(2).standard_normal(600)
    found = learned({"a": noisy}, a=None)
    assert found.normals[0] @ FIRST > 0.9
    assert 0.7 < found.record["attributes"]["a"]["held_out_right"] <= 1


def test_neutral_faces_have_the_neutral_value() -> None:
    moved = BOTH.moved(FACES[:50])
    assert (FACES[:50] @ FIRST).std() > 0.3
    assert np.abs(moved @ FIRST - A).max() < 0.25
    assert np.abs(moved @ OBLIQUE - np.median(FACES @ OBLIQUE)).max() < 0.25


def test_an_attribute_that_most_lack_is_neutral_where_they_are() -> None:
    shown = np.maximum(FACES @ FIRST - np.quantile(FACES @ FIRST, 0.6), 0)
    found = learned({"smile": shown}, smile=0)
    least = np.quantile(FACES @ FIRST, 0.6)
    assert (found.moved(FACES) @ FIRST < least).mean() > 0.95
    assert found.record["attributes"]["smile"]["least"] == [0.0, 0.0]


def test_a_move_meets_all_planes_at_once_and_is_the_shortest() -> None:
    assert abs(BOTH.normals[0] @ BOTH.normals[1]) > 0.3
    moved = BOTH.moved(FACES)
    assert BOTH.distances(moved) == pytest.approx(np.tile(BOTH.neutral, (600, 1)), abs=1e-5)
    step = (moved - FACES).astype(np.float64)
    across = step - step @ np.linalg.pinv(BOTH.normals) @ BOTH.normals
    assert np.abs(across).max() < 1e-5


def test_an_increment_changes_one_attribute_by_standard_deviations() -> None:
    spread = BOTH.distances(FACES).std(axis=0)
    step = BOTH.distances(BOTH.moved(FACES[:3], {"b": -2})) - BOTH.neutral
    assert step == pytest.approx(np.tile([0, -2 * spread[1]], (3, 1)), abs=1e-4)


def test_faces_without_a_score_are_left_out() -> None:
    scores = FACES @ FIRST
    some = np.where(np.arange(600) % 3 == 0, np.nan, scores)
    assert learned({"a": some}, a=None).record["attributes"]["a"]["faces"] == 400


def test_the_scale_of_the_latents_does_not_matter() -> None:
    small = learn_boundaries(FACES / 1000, {"a": FACES @ FIRST}, {"a": A}, 0.15, {})
    assert small.normals[0] == pytest.approx(BOTH.normals[0], abs=1e-3)
    assert small.neutral[0] * 1000 == pytest.approx(BOTH.neutral[0], rel=0.01, abs=0.01)


def test_a_file_gives_the_same_back_and_equal_means_equal_bytes(tmp_path: Path) -> None:
    for name in ("one", "two"):
        write_boundaries(tmp_path / name, BOTH)
    assert (tmp_path / "one").read_bytes() == (tmp_path / "two").read_bytes()
    back = read_boundaries(tmp_path / "one", 8)
    assert back.names == ("a", "b")
    assert back.record == BOTH.record
    assert (back.moved(FACES) == BOTH.moved(FACES)).all()


@pytest.mark.parametrize(
    ("scores", "says"),
    [
        (np.where(np.arange(600) < 60, FACES @ FIRST, np.nan), "9 faces with the most of it"),
        (np.zeros(600), "0 among the least and among the most"),
    ],
    ids=["few", "alike"],
)
def test_scores_that_part_nothing_are_refused(scores: Any, says: str) -> None:
    with pytest.raises(InputError, match=f"attributes.a: {says}"):
        learned({"a": scores}, a=0)


def test_files_of_others_are_refused(tmp_path: Path) -> None:
    write_boundaries(tmp_path / "ours", BOTH)
    with pytest.raises(InputError, match="8 numbers a latent, the generator has 9"):
        read_boundaries(tmp_path / "ours", 9)
    (tmp_path / "theirs").write_text("no tensors")
    for name in ("theirs", "nowhere"):
        with pytest.raises(InputError, match=f"boundaries={tmp_path / name}: cannot be read"):
            read_boundaries(tmp_path / name, 8)
