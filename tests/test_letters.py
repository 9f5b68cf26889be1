"""Names of every script are in the figures: by a font that has them, else as codes."""

import logging
import warnings

import pytest
from matplotlib.figure import Figure
from matplotlib.font_manager import FontEntry, fontManager

from lrsr import letters
from lrsr.letters import _coded, _usual_font, write_any_script
from lrsr.pages import png_bytes, svg_uri

IN_STIX = "\u2a0b"  # no letter of Matplotlib's usual font, but of another that comes with it


def figure_of(name: str) -> Figure:
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0, 1], [0, 1], label=name)
    axes.set(title=name)
    axes.set_yticks([0, 1], [name, "Müller"])
    axes.legend(title=name)
    return figure


@pytest.fixture(autouse=True)
def _searched_anew() -> None:
    letters._fonts_with.cache_clear()


def test_what_the_usual_font_has_is_left_alone() -> None:
    figure = figure_of("Ångström Ω Жук")
    before = figure.axes[0].title.get_fontfamily()
    write_any_script(figure)
    assert figure.axes[0].title.get_text() == "Ångström Ω Жук"
    assert figure.axes[0].title.get_fontfamily() == before


def test_another_font_that_is_installed_writes_the_rest(caplog: pytest.LogCaptureFixture) -> None:
    assert IN_STIX not in letters._letters(_usual_font())
    figure = figure_of(f"a{IN_STIX}")
    with warnings.catch_warnings(action="error"):  # Matplotlib's, of missing glyphs
        assert svg_uri(figure).startswith("data:image/svg+xml")
    assert figure.axes[0].title.get_text() == f"a{IN_STIX}"
    assert figure.axes[0].yaxis.get_ticklabels()[0].get_text() == f"a{IN_STIX}"
    assert len(figure.axes[0].title.get_fontfamily()) > 1
    assert caplog.messages == []


def test_what_no_font_has_is_told_by_its_code_and_once(
    caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fontManager, "ttflist", [])
    with caplog.at_level(logging.WARNING), warnings.catch_warnings(action="error"):
        figures = [figure_of("王 芳 / Müller") for _ in range(2)]
        for figure in figures:
            assert png_bytes(figure)[:4] == b"\x89PNG"
    shown = r"\u738b \u82b3 / Müller"
    axes = figures[0].axes[0]
    assert (axes.title.get_text(), axes.yaxis.get_ticklabels()[0].get_text()) == (shown, shown)
    (told,) = caplog.messages
    assert r"no installed font has 王 芳: figures show codes such as \u738b" in told


def test_fonts_of_boxes_and_broken_ones_write_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    usual = _usual_font()
    fonts = [
        FontEntry(fname=usual, name=".LastResort", weight=400),
        FontEntry(fname=usual, name="Noto Color Emoji", weight=400),
        FontEntry(fname=usual, name="Bold Sans", weight=700),
        FontEntry(fname="/no/such.ttf", name="Gone Sans", weight=400),
    ]
    monkeypatch.setattr(fontManager, "ttflist", fonts)
    assert letters._fonts_with(frozenset("a")) == ([], frozenset("a"))


def test_a_letter_of_another_plane_and_a_lone_byte_have_codes() -> None:
    assert _coded("𠀀\udcff", "𠀀\udcff") == r"\U00020000\udcff"
