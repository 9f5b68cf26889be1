import pytest

from lrsr.experiments.report.published import beside_published


def row(option: int, method: str, auc: float | None, ipd_px: float = 8.0) -> dict[str, object]:
    named = {"option": option, "method": method, "label": method.upper(), "ipd_px": ipd_px}
    return {**named, "auc": auc, "recogniser": "dlib", "landmarks": "own"}


def test_the_papers_area_stands_beside_ours_of_the_same_method() -> None:
    found = beside_published("super_resolution", [row(1, "srcnn2x2", 0.9868), row(1, "edsr4", 0.5)])
    assert found is not None
    assert found["columns"] == ["dlib, own landmarks"]
    (line,) = found["lines"]  # "The paper (DeepFace): .786 -> .831 -> .925"
    assert (line["label"], line["auc"], line["ours"]) == ("SRCNN2X2", 0.925, ["0.987"])


def test_where_the_papers_method_is_not_told_ours_are_a_span() -> None:
    found = beside_published("super_resolution", [row(6, "base", 0.5256), row(6, "srcnn4", 0.6)])
    assert found is not None
    (line,) = found["lines"]
    assert (line["label"], line["auc"]) == ("method not told", 0.525)
    assert line["ours"] == ["0.526 to 0.600"]


@pytest.mark.parametrize(
    ("experiment", "rows"),
    [
        ("sweep", [row(1, "base", 0.9)]),
        ("super_resolution", [row(1, "base", 0.9, ipd_px=11.0)]),
        ("super_resolution", [row(2, "base", 0.9)]),
        ("super_resolution", [row(1, "base", None)]),
        ("super_resolution", []),
    ],
    ids=["another experiment", "another size", "an option not known", "not measured", "nothing"],
)
def test_nothing_is_compared_that_does_not_match(
    experiment: str, rows: list[dict[str, object]]
) -> None:
    assert beside_published(experiment, rows) is None
