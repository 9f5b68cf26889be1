import re
from collections.abc import Mapping
from dataclasses import asdict
from html.parser import HTMLParser
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import torch
from fakes.measures import fnmr_at_fmr, trace_roc

from lrsr.errors import ImageContractError, InputError
from lrsr.evaluation.delong import compare_aucs, estimate_auc
from lrsr.experiments.report.lines import _format_p, report_lines
from lrsr.experiments.report.overview import Overview
from lrsr.experiments.report.page import write_report
from lrsr.experiments.report.panel import Panel

METHODS = {"base": "Base", "bicubic4": "Bicubic 4", "srcnn4": "SR 4"}


def draw(shift: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    return rng.normal(shift, 1, 40), rng.normal(0, 1, 1560)


def make_row(
    option: int,
    method: str,
    scores: tuple[np.ndarray, np.ndarray],
    landmarks: str = "shared",
) -> dict[str, Any]:
    return {
        "recogniser": "shipped",
        "option": option,
        "setting": "",
        "ipd_px": 8.0,
        "method": method,
        "label": METHODS[method],
        "landmarks": landmarks,
        "wrong_place": None if landmarks == "shared" else 0.125,
        "landmark_distance_ipds": None if landmarks == "shared" else 0.0625,
        "ssim_y": None if method == "base" else 0.8125,
        "identity_similarity": None if method == "base" else 0.4375,
        "lpips": None,
        **asdict(estimate_auc(*scores)),
        "psnr_y_db": None if method == "base" else 27.125,
        "fta": 0.025,
        "eer": 0.25,
        "d_prime": 1.5,
        "rank_1": 0.5,
        "fnmr": [asdict(fnmr_at_fmr(*scores, target)) for target in (0.1, 0.001)],
    }


def make_results(options: tuple[int, ...] = (1,), **changes: Any) -> dict[str, Any]:
    rows, comparisons = [], []
    for option in options:
        scores = make_scores(option)
        rows += [make_row(option, method, own) for method, own in scores.items()]
        for method, against in (("srcnn4", "base"), ("bicubic4", "base"), ("srcnn4", "bicubic4")):
            test = asdict(compare_aucs(*scores[method], *scores[against]))
            names = {
                "recogniser": "shipped",
                "option": option,
                "ipd_px": 8.0,
                "landmarks": "shared",
                "method": method,
            }
            here = {"against_option": option, "against_ipd_px": names["ipd_px"]}
            comparisons.append({**names, "against": against, **here, **test})
    config = {
        "name": "does_it_help",
        "question": "Is SR better than bicubic?",
        "level": 0.95,
        "seed": 7,
        "identities": {"count": 40},
        "options": [1],
    }
    return {
        "rows": rows,
        "comparisons": comparisons,
        "config": config,
        "recognition": {"model": "shipped"},
        "versions": {"git": "abc1234", "numpy": "2.0"},
        **changes,
    }


def make_scores(option: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    return {method: draw(1.0 + k, 10 * option + k) for k, method in enumerate(METHODS)}


def make_panel(option: int) -> Panel:
    faces = torch.from_numpy(np.random.default_rng(0).random((2, 3, 4, 4)).astype(np.float32))
    curves = {METHODS[m]: trace_roc(*own) for m, own in make_scores(option).items()}
    pictures = {"Gallery": faces, "Probe": faces[..., :2, :2]}
    return Panel(f"Option {option}", {"shared": curves}, pictures, ["test-00000", "test-00001"])


def write(folder: Path, results: dict[str, Any], *panels: Panel) -> Path:
    notes = {"done": ["Rendered."], "not_done": ["No real faces."]}
    return write_report(folder, results, panels, **notes)


def render_html(results: dict[str, Any], *panels: Panel) -> str:
    with TemporaryDirectory() as folder:
        return write(Path(folder), results, *panels).read_text(encoding="utf-8")


class Page(HTMLParser):
    """Collects what a browser would load and what a reader would read."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.sources: list[str] = []
        self.open_tags: list[str] = []
        self.alts: list[str | None] = []
        self.words: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        fields: Mapping[str, str | None] = dict(attrs)
        self.sources += [fields[key] or "" for key in ("src", "href") if key in fields]
        if tag == "img":
            self.alts.append(fields.get("alt"))
        if tag not in {"img", "meta", "br", "link"}:
            self.open_tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open_tags.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open_tags and self.open_tags[-1] != "style":
            self.words.append(data)

    @property
    def text(self) -> str:
        return re.sub(r"\s+", " ", " ".join(self.words))


@pytest.fixture(scope="module")
def html() -> str:
    return render_html(make_results((1, 4)), make_panel(1), make_panel(4))


@pytest.fixture(scope="module")
def page(html: str) -> Page:
    return Page(html)


def test_report_loads_nothing_from_outside(html: str, page: Page) -> None:
    assert page.sources
    assert all(re.match("data:image/(webp|svg[+]xml);base64,", source) for source in page.sources)
    assert not re.search(r"https?://|@import|url\(|<script .|<link", html)


def test_every_tag_is_closed_and_every_picture_described(page: Page) -> None:
    assert page.open_tags == []
    assert all(page.alts)


def test_report_prints_the_area_and_its_interval_of_every_row(page: Page) -> None:
    for row in make_results((1, 4))["rows"]:
        assert f"{row['auc']:.3f}" in page.text
        if row["high"] < 1:
            assert f"[{row['low']:.3f} – {row['high']:.3f}]" in page.text


def test_report_prints_quality_failures_and_numbers_of_scores(page: Page) -> None:
    for words in ("27.12", "2.5%", "40 / 1,560"):
        assert words in page.text


def test_report_prints_settings_seed_commit_versions_and_notes(page: Page) -> None:
    for words in (
        "identities.count",
        "Seed 7",
        "abc1234",
        "numpy 2.0",
        "Rendered.",
        "No real faces.",
    ):
        assert words in page.text


def test_report_prints_every_paired_test(page: Page) -> None:
    for comparison in make_results((1, 4))["comparisons"]:
        difference = f"{comparison['difference']:+.3f}".replace("-", "−")
        assert difference in page.text
        shown = _format_p(comparison["p"], comparison["log10_p"]).replace("\u00a0", " ")
        assert shown in page.text


def test_answer_names_the_best_method_of_each_option(page: Page) -> None:
    for option in (1, 4):
        assert f"Option {option}, IPD 8 px: the highest AUC is that of SR 4" in page.text


@pytest.mark.parametrize("fta", [0.0, 0.2])
def test_answer_says_where_a_test_is_of_faces_that_both_methods_found(fta: float) -> None:
    told = {"base": fta, "bicubic4": 0.0, "srcnn4": 0.0}
    rows = [row | {"fta": told[row["method"]]} for row in make_results()["rows"]]
    text = Page(render_html(make_results(rows=rows))).text
    assert ("against Base, where both found the face, +" in text) == (fta > 0)


def test_methods_that_share_the_highest_area_are_all_named() -> None:
    scores = np.array([2.0, 3.0]), np.array([0.0, 1.0])
    rows = [make_row(1, method, scores) for method in METHODS]
    text = Page(render_html(make_results(rows=rows, comparisons=[]))).text
    assert "Base, Bicubic 4, SR 4 share the highest AUC, 1.000" in text


def test_the_only_method_of_a_condition_is_not_called_the_best() -> None:
    scores = np.array([0.4, 0.6, 0.9]), np.array([0.1, 0.2, 0.5, 0.5])
    rows = [make_row(option, "base", scores) for option in (1, 2)]
    text = Page(render_html(make_results(rows=rows, comparisons=[]))).text
    assert "highest" not in text
    for option, row in zip((1, 2), rows, strict=True):
        assert f"Option {option}, IPD 8 px: the AUC of Base is {row['auc']:.3f} [" in text


def test_complete_separation_has_no_interval_and_a_note() -> None:
    rows = [make_row(1, "base", (np.array([2.0, 3.0]), np.array([0.0, 1.0])))]
    text = Page(render_html(make_results(rows=rows, comparisons=[]))).text
    assert "no interval" in text
    assert "separated completely" in text
    assert "the AUC of Base is 1.000." in text


def test_an_interval_cut_at_one_gives_way_to_the_logit_interval() -> None:
    row = make_row(1, "base", (np.array([0.4, 0.6, 0.9]), np.array([0.1, 0.2, 0.4, 0.5])))
    text = Page(render_html(make_results(rows=[row], comparisons=[]))).text
    assert f"[{row['logit_low']:.3f} – {row['logit_high']:.3f}]" in text
    assert "logit scale" in text


def test_few_expected_false_matches_are_noted(page: Page) -> None:
    assert "Fewer than ten false matches" in page.text


def test_a_difference_that_holms_correction_removes_is_not_called_shown() -> None:
    results = make_results()
    comparisons = [{**test, "p": 0.04, "log10_p": -1.4} for test in results["comparisons"]]
    text = Page(render_html(results | {"comparisons": comparisons})).text
    assert "no difference shown" in text


def test_a_photograph_of_unknown_size_and_unmeasured_quality_has_a_line() -> None:
    row = make_results()["rows"][0] | {"ipd_px": None, "subject_low": None, "subject_high": None}
    text = Page(render_html(make_results(rows=[row], comparisons=[]))).text
    assert f"Option 1: the AUC of Base is {row['auc']:.3f} [" in text
    assert "IPD" not in text


def both_sources() -> dict[str, Any]:
    rows = [
        make_row(1, method, own, landmarks)
        for landmarks in ("shared", "own")
        for method, own in make_scores(1).items()
    ]
    of_both = [
        {**test, "landmarks": landmarks}
        for landmarks in ("shared", "own")
        for test in make_results()["comparisons"]
    ]
    return make_results(rows=rows, comparisons=of_both)


def test_landmarks_of_two_sources_have_a_table_part_a_sentence_and_a_figure_each() -> None:
    curves = next(iter(make_panel(1).curves.values()))
    panel = Panel("Option 1", {"shared": curves, "own": curves})
    text = Page(render_html(both_sources(), panel)).text
    for landmarks in ("shared", "own"):
        assert text.count(f"Option 1, IPD 8 px, {landmarks} landmarks") == 4
        assert f"{landmarks} landmarks: the highest AUC is that of SR 4" in text
        assert f"ROC curves with {landmarks} landmarks" in text
    assert "12.5%" in text  # in a wrong place


def test_a_line_has_the_tests_of_its_own_landmarks() -> None:
    results = both_sources()
    for test in results["comparisons"]:
        test["difference"] = 0.111 if test["landmarks"] == "own" else -0.222
    lines = report_lines(results["rows"], results["comparisons"])
    for line in lines:
        wanted = "+0.111" if line["landmarks"] == "own" else "−0.222"
        assert all(test["difference"] == wanted for test in line["tests"].values())


def test_a_method_by_which_too_few_faces_are_found_has_a_line_without_numbers() -> None:
    unmeasured = dict.fromkeys(
        ("auc", "std", "low", "high", "logit_low", "logit_high", "subject_low", "subject_high")
    )
    unmeasured |= dict.fromkeys(("eer", "d_prime", "rank_1"))
    first, second, third = make_results()["rows"]
    rows = [first | unmeasured | {"fnmr": [], "fta": 1.0}, second, third]
    text = Page(render_html(make_results(rows=rows, comparisons=[]))).text
    assert "too few faces" in text
    assert "100.0%" in text
    assert "the highest AUC is that of" in text


def test_where_no_face_is_found_at_all_a_report_says_so() -> None:
    (row, *_) = make_results()["rows"]
    unmeasured = {name: None for name in row if isinstance(row[name], float) and name != "fta"}
    nothing = row | unmeasured | {"fnmr": [], "ipd_px": 8.0, "logit_low": None, "logit_high": None}
    text = Page(render_html(make_results(rows=[nothing], comparisons=[]))).text
    assert "Option 1, IPD 8 px: too few faces were found to measure anything." in text


def test_text_is_escaped() -> None:
    config = make_results()["config"] | {"name": "<b>&", "a<b": "<script id=x>"}
    html = render_html(make_results(config=config))
    assert "<script id" not in html
    assert "&lt;b&gt;&amp;" in html


def test_the_same_report_is_the_same_file() -> None:
    results, panel = make_results(), make_panel(1)
    assert render_html(results, panel) == render_html(results, panel)


def test_write_report_makes_the_folder_and_returns_the_file(tmp_path: Path) -> None:
    path = write(tmp_path / "new" / "run", make_results())
    assert path == tmp_path / "new" / "run" / "report.html"
    assert path.read_text(encoding="utf-8").startswith("<!DOCTYPE html>")


@pytest.mark.parametrize(
    ("p", "log10_p", "words"),
    [
        (1.0, 0.0, "1.00"),
        (0.5, None, "0.50"),
        (0.04321, None, "0.043"),
        (0.001, None, "0.001"),
        (0.0009, None, "9.0 × 10⁻⁴"),
        (9.99e-5, None, "1.0 × 10⁻⁴"),
        (0.0, -1234.25, "5.6 × 10⁻¹²³⁵"),
        (0.0, None, "0"),
        (0.0, float("-inf"), "0"),
    ],
)
def test_p_values_have_two_digits(p: float, log10_p: float | None, words: str) -> None:
    assert _format_p(p, log10_p).replace("\u00a0", " ") == words


def test_a_sheet_with_uneven_columns_is_refused(tmp_path: Path) -> None:
    uneven = {"a": torch.zeros(1, 3, 2, 2), "b": torch.zeros(2, 3, 2, 2)}
    with pytest.raises(ValueError, match=r"shorter|longer"):
        write(tmp_path, make_results(), Panel("P", {}, uneven, ["one", "two"]))
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(InputError, match="cannot write"):
        write(tmp_path / "file", make_results())


def test_a_broken_picture_is_refused(tmp_path: Path) -> None:
    panel = Panel("P", {}, {"Probe": torch.full((1, 3, 2, 2), torch.nan)}, ["one"])
    with pytest.raises(ImageContractError, match="NaN"):
        write(tmp_path, make_results(), panel)


def make_crossed(lights: tuple[str, ...] = ("frontal", "side")) -> dict[str, Any]:
    """Two poses by some lights, each tested against the first pose in the same light."""
    varied = [{"pose": pose, "lighting": light} for pose in ("up", "left") for light in lights]
    settings = [f"pose {one['pose']}, lighting {one['lighting']}" for one in varied]
    rows, tests = [], []
    for option, setting in enumerate(settings, start=1):
        row = make_row(option, "base", draw(1.0 + option, option)) | {"setting": setting}
        rows.append(row)
        if option > len(lights):
            other = option - len(lights)
            scores = [draw(1.0 + one, one) for one in (option, other)]
            names = {key: row[key] for key in ("recogniser", "option", "ipd_px", "landmarks")}
            against = {"method": "base", "against": "base", "against_option": other}
            against |= {"against_ipd_px": row["ipd_px"]}
            tests.append({**names, **against, **asdict(compare_aucs(*scores[0], *scores[1]))})
    conditions = [{"option": k, "varied": one} for k, one in enumerate(varied, start=1)]
    config = make_results()["config"] | {"conditions": conditions}
    return make_results(rows=rows, comparisons=tests, config=config)


def test_combinations_have_a_heat_map_a_sheet_and_one_sentence() -> None:
    faces = torch.rand(2, 3, 4, 4, generator=torch.Generator().manual_seed(0))
    panels = [
        Panel(f"Option {k}", pictures={"Probe": faces}, people=["anna"], place=(k, 8.0))
        for k in (1, 2, 3, 4)
    ]
    told = render_html(make_crossed(), *panels)
    assert told.count('alt="AUC of Base under every condition') == 1
    assert told.count('alt="Probe, pose left, lighting side"') == 1
    text = Page(told).text
    assert "The AUC is highest with pose left, lighting side" in text
    assert "; lowest with pose up, lighting frontal" in text
    assert "of 2 differences to pose up 2 remain after Holm's correction" in text


def test_where_every_size_has_one_setting_the_best_method_is_named() -> None:
    results = make_crossed()
    rows = [row | {"ipd_px": 8.0 + k} for k, row in enumerate(results["rows"])]
    text = Page(render_html(results | {"rows": rows, "comparisons": []})).text
    assert "is highest with" not in text
    assert "Pose left, lighting side, IPD 11 px: the AUC of Base is" in text


def test_sizes_are_compared_in_words() -> None:
    row = make_row(1, "base", draw(1.0, 1))
    larger = make_row(1, "base", draw(2.0, 1)) | {"ipd_px": 14.0}
    names = {key: larger[key] for key in ("recogniser", "option", "ipd_px", "landmarks")}
    against = {"method": "base", "against": "base", "against_option": 1, "against_ipd_px": 8.0}
    test = {**names, **against, **asdict(compare_aucs(*draw(2.0, 1), *draw(1.0, 1)))}
    told = Page(render_html(make_results(rows=[row, larger], comparisons=[test]))).text
    assert re.search(
        r"IPD 14 px: the AUC of Base is 0\.\d+ \[.*\]; against 8 px \+0\.\d+ \(p", told
    )
    assert "Against 8 px difference, p" in told


def test_areas_near_one_have_more_digits() -> None:
    row = make_row(1, "base", draw(6.0, 1))
    line = report_lines([row | {"auc": 0.99968, "std": 0.0001, "low": 0.9995, "high": 0.9999}], [])[
        0
    ]
    assert (line["area"], line["interval"]) == ("0.9997", "0.9995 – 0.9999")


def test_a_line_names_in_what_its_rival_differs() -> None:
    results = make_crossed()
    lines = report_lines(results["rows"], results["comparisons"])
    assert [line["rival"] and line["rival"]["label"] for line in lines] == [
        None,
        None,
        *["pose up"] * 2,
    ]
    (alone,) = report_lines(*(make_crossed(("frontal",))[key] for key in ("rows", "comparisons")))[
        1:
    ]
    assert alone["rival"]["label"] == "pose up, lighting frontal"


def test_what_changes_no_picture_is_not_shown_twice() -> None:
    config = {"conditions": [{"option": k, "varied": {"detector": str(k)}} for k in (1, 2)]}
    panels = [
        Panel("", pictures={"Probe": torch.zeros(1, 3, 4, 4)}, place=(k, 8.0)) for k in (1, 2)
    ]
    assert Overview(config).faces(panels) == []


def test_a_name_stays_as_it_is_at_the_beginning_of_a_sentence() -> None:
    results = make_crossed()
    config = results["config"] | {"name": "mine_of_VIS"}
    rows = [row | {"recogniser": name} for name in ("w600k_mbf", "dlib") for row in results["rows"]]
    told = render_html(results | {"rows": rows, "comparisons": [], "config": config})
    text = Page(told).text
    assert "w600k_mbf: the AUC is highest with" in text
    assert "w600k_mbf. Pose left, lighting side" in text
    assert "W600k" not in text
    assert "<h1>Mine of VIS</h1>" in told
