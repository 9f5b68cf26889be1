"""Tests of lrsr/experiments/figures.py."""

import base64
import io

import matplotlib as mpl
import numpy as np
import pytest
from fakes.measures import trace_roc
from matplotlib.figure import Figure
from matplotlib.image import imread

from lrsr.experiments.report import figures
from lrsr.experiments.report.figures import draw_intervals, draw_roc
from lrsr.pages import line_style


def decode(uri: str) -> np.ndarray:
    kind, content = uri.split(",")
    assert kind == "data:image/png;base64"
    return np.asarray(imread(io.BytesIO(base64.b64decode(content))))


def curves(count: int) -> dict[str, object]:
    rng = np.random.default_rng(0)
    return {
        f"method {k}": trace_roc(rng.normal(1 + k / 4, 1, 50), rng.normal(0, 1, 900))
        for k in range(count)
    }


@pytest.mark.parametrize("count", [1, 6, 9])
def test_curves_are_drawn_in_ink_on_white(count: int) -> None:
    picture = decode(draw_roc(curves(count)))  # type: ignore[arg-type] # made above
    assert picture.shape[1] == pytest.approx(1440, abs=2)
    assert picture[0, 0, :3].tolist() == [1, 1, 1]
    assert picture.min() < 0.5


def test_a_curve_of_complete_separation_can_be_drawn() -> None:
    assert decode(draw_roc({"perfect": trace_roc([2, 3], [0, 1])})).size > 0


def test_an_interval_plot_grows_with_its_lines() -> None:
    def height(count: int) -> int:
        area = {"auc": 0.5, "low": 0.4, "high": 0.6}
        return decode(draw_intervals(["x"] * count, [area] * count, "AUC")).shape[0]

    assert height(1) < height(6) < height(36)


@pytest.mark.parametrize("low", [0.2, 0.97, 1.0])
def test_an_interval_plot_shows_no_areas_that_cannot_be(
    low: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "png_bytes", lambda figure: drawn.append(figure) or b"")
    draw_intervals(["x"], [{"auc": 1.0, "low": low, "high": 1.0}], "AUC")
    left, right = drawn[0].axes[0].get_xlim()
    assert left < low
    assert 1 < right <= 1 + 0.1 * (1 - left) + 0.01


def test_every_line_differs_in_colour_or_dashes() -> None:
    styles = [line_style(number) for number in range(48)]
    assert len({(style["color"], style["linestyle"]) for style in styles}) == 48
    assert len({style["color"] for style in styles[:8]}) == 8


def test_drawing_leaves_the_users_plot_settings_alone() -> None:
    before = dict(mpl.rcParams)
    draw_roc(curves(1))  # type: ignore[arg-type] # made above
    assert dict(mpl.rcParams) == before
