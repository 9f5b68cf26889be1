"""Tests of lrsr/experiments/figures.py."""

import base64
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

import matplotlib as mpl
import numpy as np
import pytest
from fakes.measures import trace_roc
from matplotlib.figure import Figure

from lrsr.experiments.report import figures
from lrsr.experiments.report.figures import draw_intervals, draw_roc
from lrsr.pages import COLOURS, line_style


def decode(uri: str) -> Element:
    kind, content = uri.split(",")
    assert kind == "data:image/svg+xml;base64"
    return ElementTree.fromstring(base64.b64decode(content))


def size_pt(picture: Element) -> tuple[float, float]:
    width, height = (float(picture.attrib[name].removesuffix("pt")) for name in ("width", "height"))
    return width, height


def curves(count: int) -> dict[str, object]:
    rng = np.random.default_rng(0)
    return {
        f"method {k}": trace_roc(rng.normal(1 + k / 4, 1, 50), rng.normal(0, 1, 900))
        for k in range(count)
    }


@pytest.mark.parametrize("count", [1, 6, 9])
def test_curves_are_drawn_in_ink_on_white(count: int) -> None:
    picture = decode(draw_roc(curves(count)))  # type: ignore[arg-type] # made above
    assert size_pt(picture)[0] == pytest.approx(7.2 * 72)
    drawn = [
        path.attrib.get("style", "") for path in picture.iter("{http://www.w3.org/2000/svg}path")
    ]
    assert "fill: #ffffff" in drawn[0]
    lines = {
        colour for colour in COLOURS if any(f"stroke: {colour.lower()}" in one for one in drawn)
    }
    assert len(lines) >= min(count, len(COLOURS))


def test_a_drawing_is_the_same_twice_and_small() -> None:
    many = {"a": trace_roc(np.arange(500) % 97, np.arange(249_500) % 89)}
    assert draw_roc(many) == draw_roc(many)
    assert len(draw_roc(many)) < 150_000


def test_a_curve_of_complete_separation_can_be_drawn() -> None:
    assert decode(draw_roc({"perfect": trace_roc([2, 3], [0, 1])})).tag


def test_an_interval_plot_grows_with_its_lines() -> None:
    def height(count: int) -> float:
        area = {"auc": 0.5, "low": 0.4, "high": 0.6}
        return size_pt(decode(draw_intervals(["x"] * count, [area] * count, "AUC")))[1]

    assert height(1) < height(6) < height(36)


@pytest.mark.parametrize("low", [0.2, 0.97, 1.0])
def test_an_interval_plot_shows_no_areas_that_cannot_be(
    low: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Figure] = []
    monkeypatch.setattr(figures, "svg_uri", lambda figure: drawn.append(figure) or "")
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
