import json
from collections.abc import Mapping

import numpy as np
import pytest
from sklearn.metrics import roc_auc_score

from lrsr.camera import Camera
from lrsr.errors import ScoreError
from lrsr.evaluation.scores import Scores
from lrsr.experiments.conditions import Condition
from lrsr.experiments.design import Design
from lrsr.experiments.table import Record, evaluate, with_holm
from lrsr.identities.roster import IdentityRange
from lrsr.pictures.sitting import Sitting
from lrsr.presets import preset
from lrsr.rendering.scene import Film, Quality, Scene
from lrsr.sr import Bicubic, Upscaler

SCENE = Scene(preset("lighting", "frontal"), preset("pose", "down"))
CONDITION = Condition(4, SCENE, "heavy", 8.0)
PEOPLE = [f"test-{index:05d}" for index in range(40)]
METHODS = ("base", "bicubic2", "bicubic4", "srcnn2", "srcnn2x2", "srcnn4")


def design(upscalers: Mapping[str, Upscaler]) -> Design:
    people = IdentityRange(count=40)
    gallery = Sitting(people, SCENE, Film(64), Quality(), "gallery")
    return Design(
        "trial", "?", (CONDITION,), upscalers, people, Quality(), 0, gallery, Camera(), 0.95
    )


def scored(signal: float, seed: int = 0) -> Scores:
    rng = np.random.default_rng(seed)
    matrix = rng.normal(0.0, 0.2, (len(PEOPLE), len(PEOPLE)))
    return Scores(matrix + signal * np.eye(len(PEOPLE)), PEOPLE, PEOPLE)


def row(scores: Scores, errors: tuple[float, ...] = (), **likeness: tuple[float, ...]) -> Record:
    asked = design({"base": Bicubic(1)})
    (found,), _, _ = evaluate(
        asked, CONDITION, {"base": scores}, {"base": likeness}, errors={"base": errors}
    )
    return found


def compared(scores: Mapping[str, Scores]) -> list[Record]:
    asked = design({name: preset("sr", name) for name in scores})
    return evaluate(asked, CONDITION, scores, {name: {} for name in scores})[1]


def test_row_has_the_area_that_scikit_learn_finds() -> None:
    scores = scored(0.3)
    found = row(scores, psnr_y_db=(31.5,))
    truth = np.eye(len(PEOPLE)).ravel()
    assert found["auc"] == pytest.approx(roc_auc_score(truth, scores.matrix.ravel()), abs=1e-12)
    assert (found["n_genuine"], found["n_impostor"]) == (40, 40 * 39)
    assert found["low"] < found["auc"] < found["high"]
    assert found["psnr_y_db"] == 31.5


def test_row_says_how_sure_it_is_when_people_were_sampled() -> None:
    found = row(scored(0.3))
    assert found["subject_std"] is not None
    assert found["subject_std"] == pytest.approx(found["std"], rel=0.3)
    assert found["subject_low"] is not None
    assert found["subject_low"] < found["auc"]


def test_row_names_its_condition() -> None:
    found = row(scored(0.3))
    assert (found["option"], found["ipd_px"], found["pose"]) == (4, 8.0, "down")
    assert (found["lighting"], found["compression"], found["landmarks"]) == (
        "frontal",
        "heavy",
        "shared",
    )


def test_row_goes_to_json_without_nan() -> None:
    assert json.loads(json.dumps(row(scored(9.0)), allow_nan=False))["auc"] == 1.0


def test_perfect_separation_ranks_everyone_first() -> None:
    found = row(scored(9.0))
    assert found["rank_1"] == 1.0
    assert [point["fnmr"] for point in found["fnmr"]] == [0.0, 0.0, 0.0]


def test_probes_without_a_face_are_counted_not_compared() -> None:
    matrix = scored(0.3).matrix.copy()
    matrix[:10] = np.nan
    found = row(Scores(matrix, PEOPLE, PEOPLE))
    assert (found["fta"], found["n_genuine"]) == (0.25, 30)


def test_each_method_meets_base_and_each_network_its_bicubic() -> None:
    scores = {name: scored(0.3, seed) for seed, name in enumerate(METHODS)}
    assert [(c["method"], c["against"]) for c in compared(scores)] == [
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
    (comparison,) = compared({"base": scored(0.1), "srcnn4": scored(0.9)})
    assert comparison["difference"] > 0.1
    assert comparison["p"] < 0.01


def test_a_method_equal_to_base_has_p_one() -> None:
    (comparison,) = compared({"base": scored(0.3), "srcnn4": scored(0.3)})
    assert (comparison["difference"], comparison["p"], comparison["z"]) == (0.0, 1.0, 0.0)


def test_psnr_is_the_mean_over_images_and_undefined_for_equal_ones() -> None:
    assert row(scored(0.3), psnr_y_db=(30.0, 32.0))["psnr_y_db"] == 31.0
    assert row(scored(0.3), psnr_y_db=(30.0, float("inf")))["psnr_y_db"] is None
    assert row(scored(0.3))["psnr_y_db"] is None


def test_likeness_is_the_mean_over_the_images_where_it_is_known() -> None:
    found = row(scored(0.3), ssim_y=(0.5, 0.75), identity_similarity=(0.25, float("nan")))
    assert (found["ssim_y"], found["identity_similarity"]) == (0.625, 0.25)
    assert found["lpips"] is None
    assert row(scored(0.3), ssim_y=(float("nan"),))["ssim_y"] is None


def test_landmarks_are_off_by_the_mean_of_those_found() -> None:
    found = row(scored(0.3), (0.1, 0.5, float("nan")))
    assert found["landmark_distance_ipds"] == pytest.approx(0.3)
    assert found["wrong_place"] == 0.5
    assert row(scored(0.3))["landmark_distance_ipds"] is None


def test_rows_and_comparisons_have_the_fields_of_the_results_file() -> None:
    assert list(row(scored(0.3))) == [
        "experiment", "option", "setting", "ipd_px", "pose", "lighting", "compression", "camera",
        "skin", "detector", "method", "label", "frames", "landmarks", "auc", "std", "low", "high",
        "n_genuine", "n_impostor", "level",
        "logit_low", "logit_high", "subject_std", "subject_low", "subject_high", "bootstrap_low",
        "bootstrap_high", "psnr_y_db", "fta", "eer", "d_prime", "rank_1", "fnmr", "partial_auc",
        "wrong_place", "landmark_distance_ipds", "ssim_y", "identity_similarity", "lpips",
        "false_faces",
    ]  # fmt: skip
    (comparison,) = compared({"base": scored(0.1), "srcnn4": scored(0.9)})
    assert list(comparison) == [
        "option", "setting", "ipd_px", "landmarks", "method", "against", "against_option",
        "against_ipd_px",
        "difference", "low", "high", "subject_low", "subject_high", "bootstrap_low",
        "bootstrap_high", "z", "p", "log10_p", "bootstrap_p",
    ]  # fmt: skip


def test_an_infinite_z_is_none() -> None:
    """Two methods that rank without fail, one of them upside down: the variance is 0."""
    (comparison,) = compared({"base": scored(-9.0), "srcnn4": scored(9.0)})
    assert (comparison["difference"], comparison["p"]) == (1.0, 0.0)
    assert comparison["z"] is comparison["log10_p"] is None


def test_tests_are_adjusted_for_all_of_them() -> None:
    found = with_holm([{"p": 0.01}, {"p": 0.04}, {"p": 0.03}])
    assert [round(test["p_holm"], 6) for test in found] == [0.03, 0.06, 0.06]


def own(
    scores: Mapping[str, Scores], errors: Mapping[str, object]
) -> tuple[list[Record], list[Record]]:
    asked = design({name: preset("sr", name) for name in scores})
    return evaluate(asked, CONDITION, scores, {name: {} for name in scores}, "own", errors)[:2]


def test_faces_in_a_wrong_place_are_counted_among_those_found() -> None:
    errors = {"base": [0.1, 0.24, 0.26, np.nan, np.nan]}  # distances of the eyes
    ((found,), _) = own({"base": scored(0.3)}, errors)
    assert (found["landmarks"], found["wrong_place"]) == ("own", pytest.approx(1 / 3))
    ((unknown,), _) = own({"base": scored(0.3)}, {"base": [np.nan, np.nan]})
    assert unknown["wrong_place"] is None


def missed(found: int) -> Scores:
    matrix = scored(0.3).matrix.copy()
    matrix[found:] = np.nan
    return Scores(matrix, PEOPLE, PEOPLE)


def test_a_method_by_which_too_few_are_found_has_a_row_and_no_test() -> None:
    scores = {"base": scored(0.3), "bicubic4": scored(0.4), "srcnn4": missed(1)}
    rows, tests = own(scores, {})
    assert [row["auc"] is None for row in rows] == [False, False, True]
    assert [(one["method"], one["against"]) for one in tests] == [("bicubic4", "base")]
    assert (rows[2]["fta"], rows[2]["n_genuine"], rows[2]["n_impostor"]) == (39 / 40, 1, 39)
    assert rows[2]["fnmr"] == []
    assert list(rows[2]) == list(rows[0])
    assert {name: rows[0][name] for name in ("auc", "std")} == {
        name: row(scored(0.3))[name] for name in ("auc", "std")
    }
    json.dumps(rows, allow_nan=False)


def test_two_methods_that_found_nothing_in_common_are_not_compared() -> None:
    matrix = scored(0.3).matrix.copy()
    matrix[:20] = np.nan
    rows, tests = own({"base": missed(20), "srcnn4": Scores(matrix, PEOPLE, PEOPLE)}, {})
    assert [one["auc"] is None for one in rows] == [False, False]
    assert tests == []


def test_too_few_scores_although_nothing_failed_is_the_users_to_mend() -> None:
    strangers = Scores(scored(0.3).matrix, PEOPLE, [f"other-{name}" for name in PEOPLE])
    with pytest.raises(ScoreError, match="base: "):
        own({"base": strangers}, {})
