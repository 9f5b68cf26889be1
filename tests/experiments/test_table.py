import json
from dataclasses import asdict

import numpy as np
import pytest
from sklearn.metrics import roc_auc_score

from lrsr.evaluation.scores import Scores
from lrsr.experiments.settings import Condition
from lrsr.experiments.table import compare_methods, make_row, mean_psnr_db

CONDITION = Condition(4, 8.0, "down", "frontal", "heavy")
PEOPLE = [f"test-{index:05d}" for index in range(40)]


def scored(signal: float, seed: int = 0) -> Scores:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(0.0, 0.2, (len(PEOPLE), len(PEOPLE)))
    return Scores(matrix + signal * np.eye(len(PEOPLE)), PEOPLE, PEOPLE)


def test_row_has_the_area_that_scikit_learn_finds() -> None:
    scores = scored(0.3)
    row = make_row("trial", CONDITION, ("srcnn4", "SR 4"), scores, 31.5, 0.95)
    truth = np.eye(len(PEOPLE)).ravel()
    assert row.auc == pytest.approx(roc_auc_score(truth, scores.matrix.ravel()), abs=1e-12)
    assert (row.n_genuine, row.n_impostor) == (40, 40 * 39)
    assert row.low < row.auc < row.high


def test_row_names_its_condition() -> None:
    row = make_row("trial", CONDITION, ("base", "Base"), scored(0.3), None, 0.95)
    assert (row.option, row.ipd_px, row.pose) == (4, 8.0, "down")
    assert (row.lighting, row.compression, row.landmarks) == ("frontal", "heavy", "shared")


def test_row_goes_to_json_without_nan() -> None:
    row = make_row("trial", CONDITION, ("base", "Base"), scored(9.0), None, 0.95)
    assert json.loads(json.dumps(asdict(row), allow_nan=False))["auc"] == 1.0


def test_perfect_separation_ranks_everyone_first() -> None:
    row = make_row("trial", CONDITION, ("base", "Base"), scored(9.0), None, 0.95)
    assert row.rank_1 == 1.0
    assert [point.fnmr for point in row.fnmr] == [0.0, 0.0, 0.0]


def test_probes_without_a_face_are_counted_not_compared() -> None:
    matrix = scored(0.3).matrix.copy()
    matrix[:10] = np.nan
    row = make_row("t", CONDITION, ("base", "Base"), Scores(matrix, PEOPLE, PEOPLE), None, 0.95)
    assert (row.fta, row.n_genuine) == (0.25, 30)


def test_each_method_meets_base_and_each_network_its_bicubic() -> None:
    names = ("base", "bicubic2", "bicubic4", "srcnn2", "srcnn2x2", "srcnn4")
    scores = {name: scored(0.3, seed) for seed, name in enumerate(names)}
    pairs = [(c.method, c.against) for c in compare_methods(CONDITION, scores, 0.95)]
    assert pairs == [
        ("bicubic2", "base"),
        ("bicubic4", "base"),
        ("srcnn2", "base"),
        ("srcnn2", "bicubic2"),
        ("srcnn2x2", "base"),
        ("srcnn2x2", "bicubic4"),
        ("srcnn4", "base"),
        ("srcnn4", "bicubic4"),
    ]


def test_a_positive_difference_favours_the_method() -> None:
    (comparison,) = compare_methods(CONDITION, {"base": scored(0.1), "srcnn4": scored(0.9)}, 0.95)
    assert comparison.difference > 0.1
    assert comparison.p < 0.01


def test_a_method_equal_to_base_has_p_one() -> None:
    (comparison,) = compare_methods(CONDITION, {"base": scored(0.3), "srcnn4": scored(0.3)}, 0.95)
    assert (comparison.difference, comparison.p, comparison.z) == (0.0, 1.0, 0.0)


def test_psnr_is_the_mean_over_images_and_undefined_for_equal_ones() -> None:
    assert mean_psnr_db(np.array([30.0, 32.0])) == 31.0
    assert mean_psnr_db(np.array([30.0, np.inf])) is None
