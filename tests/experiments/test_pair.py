"""Two pictures: what was found on them, their score, and what that is worth by whose scores."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import skimage.data
import torch
from fakes.configurations import composed

from lrsr.errors import InputError
from lrsr.evaluation.ratio import ratio_of
from lrsr.evaluation.scores import Scores
from lrsr.experiments.pair import PairComparison, lines_of
from lrsr.pictures.image_files import write_png


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An astronaut whom scikit-image carries, twice, and nobody."""
    folder = tmp_path_factory.mktemp("pair")
    astronaut = torch.from_numpy(skimage.data.astronaut()).permute(2, 0, 1).float() / 255
    write_png(folder / "a.png", astronaut)
    write_png(folder / "b.png", (astronaut[:, 20:212, 130:322] * 0.8).contiguous())
    write_png(folder / "nobody.png", torch.full((3, 48, 48), 0.5))
    return folder


@pytest.fixture
def scores(tmp_path: Path) -> Path:
    """Scores of 20 people by two methods."""
    matrix = np.random.default_rng(0).normal(0, 0.2, (20, 20)) + 0.6 * np.eye(20)
    path = tmp_path / "scores.csv"
    with path.open("w") as file:
        writer = csv.writer(file)
        writer.writerow(["probe", "gallery", "mated", "method", "landmarks", "recogniser", "score"])
        for method in ("base", "srcnn4"):
            for (i, j), score in np.ndenumerate(matrix + (method == "srcnn4")):
                said = [f"p{i}", f"g{j}", int(i == j), method, "own", "tones", score]
                writer.writerow(said)
    return path


def asked(tone_model: Path, *words: str, method: str = "base") -> PairComparison:
    given = [f"recognition.recognisers=[{tone_model}]", "bootstrap=20", *words]
    return PairComparison.from_config(composed("compare", *given), method)


def files(pictures: Path, *names: str) -> str:
    return f"files=[{','.join(str(pictures / name) for name in names)}]"


def test_without_scores_of_known_people_there_is_a_score_and_no_ratio(
    tone_model: Path, pictures: Path
) -> None:
    result = asked(tone_model, files(pictures, "a.png", "b.png")).run()
    (one,) = result["comparisons"]
    assert one["score"] > 0.8  # one photograph, cut in two ways
    assert (one["ratio"], one["basis"]) == (None, None)
    assert "nobody said how known people score" in one["why_not"]
    assert [p["detector_score"] > 0.9 for p in result["pictures"]] == [True, True]
    assert result["pictures"][0]["ipd_px"] == pytest.approx(42.6, abs=3)
    told = [*lines_of(result)]
    assert "a.png: 512 x 512 px, face found" in told[0]
    assert told[3].startswith("  no likelihood ratio: nobody said")


def test_the_ratio_is_that_of_the_scores_of_the_same_system(
    tone_model: Path, pictures: Path, scores: Path, tmp_path: Path
) -> None:
    out = tmp_path / "pair.json"
    pair = files(pictures, "a.png", "b.png")
    result = asked(tone_model, pair, f"scores={scores}", f"out={out}").run()
    (one,) = result["comparisons"]
    matrix = np.random.default_rng(0).normal(0, 0.2, (20, 20)) + 0.6 * np.eye(20)
    people = [f"p{k}" for k in range(20)]
    wanted = ratio_of(one["score"], Scores(matrix, people, people))
    assert one["ratio"]["llr"] == pytest.approx(wanted.llr, abs=1e-9)
    assert one["ratio"]["low"] <= one["ratio"]["llr"] <= one["ratio"]["high"]
    assert (one["basis"]["method"], one["ratio"]["n_people"]) == ("base", 20)
    assert json.loads(out.read_text())["comparisons"] == result["comparisons"]
    told = [*lines_of(result)]
    assert told[3].startswith("  likelihood ratio ")
    assert "20 people, 20 genuine and 380 impostor scores of " in told[4]


def test_the_method_of_the_scores_is_that_of_the_pair_unless_it_is_told(
    tone_model: Path, pictures: Path, scores: Path
) -> None:
    pair = [files(pictures, "a.png", "b.png"), f"scores={scores}"]
    for words, method in (([], "srcnn4"), (["method=srcnn4"], "base")):
        result = asked(tone_model, *pair, *words, method=method).run()
        assert result["comparisons"][0]["basis"]["method"] == "srcnn4"
    with pytest.raises(InputError, match="no scores of method=edsr2, but of base, srcnn4"):
        asked(tone_model, *pair, method="edsr2").run()


def test_a_picture_without_a_face_has_no_score(
    tone_model: Path, pictures: Path, scores: Path
) -> None:
    pair = [files(pictures, "nobody.png", "b.png"), f"scores={scores}"]
    result = asked(tone_model, *pair).run()
    (one,) = result["comparisons"]
    assert (one["score"], one["ratio"]) == (None, None)
    assert "no face was found on both pictures" in one["why_not"]
    assert "nobody.png: 48 x 48 px, no face found" in next(lines_of(result))


def test_scores_of_too_few_people_are_no_basis(
    tone_model: Path, pictures: Path, tmp_path: Path
) -> None:
    path = tmp_path / "few.csv"
    rows = [f"p{i},g{j},{int(i == j)},{i + j}" for i in range(4) for j in range(4)]
    path.write_text("\n".join(["probe,gallery,mated,score", *rows]))
    pair = [files(pictures, "a.png", "b.png"), f"scores={path}"]
    (one,) = asked(tone_model, *pair).run()["comparisons"]
    assert one["ratio"] is None
    assert "no likelihood ratio: 4 people with a genuine score" in one["why_not"]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["files=[a.png]"], r"files=\['a.png'\]: wanted two: lrsr compare PROBE ENROLLED"),
        (["files=[a,b]", "out=folder"], r"out=.*folder: wanted a file, such as out=pair\.json"),
        (["files=[a,b]", "option=1"], r"option=1: wanted scores=FILE besides"),
        (["files=[a,b]", "recognition.landmarks=both"], "landmarks=both: wanted own"),
        (["files=[a,b]", "recognition.landmarks=shared"], "landmarks=shared: wanted own"),
        (["files=[a,b]", "calibration=guess"], "calibration=guess: wanted one of"),
        (["files=[a,b]", "level=1"], "level=1.0: wanted between"),
        (["files=[a,b]", "+cut.side=1"], "cut=side: wanted one of ipds, longest_px"),
    ],
)
def test_wrong_settings_are_refused(words: list[str], says: str, tone_model: Path) -> None:
    with pytest.raises(InputError, match=says):
        asked(tone_model, *words)


def test_a_file_that_is_no_picture_is_named(tone_model: Path, tmp_path: Path) -> None:
    (tmp_path / "x.png").write_bytes(b"x")
    with pytest.raises(InputError, match=r"x\.png is no picture"):
        asked(tone_model, files(tmp_path, "x.png", "x.png")).run()


def test_several_recognisers_are_told_one_by_one(tone_model: Path, pictures: Path) -> None:
    words: list[Any] = [files(pictures, "a.png", "b.png")]
    config = composed("compare", *words, f"recognition.recognisers=[{tone_model},shipped]")
    result = PairComparison.from_config(config).run()
    assert [one["recogniser"] for one in result["comparisons"]] == ["tones", "shipped"]
