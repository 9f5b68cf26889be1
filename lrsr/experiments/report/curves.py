"""What do rates, ratios and qualities look like? Curves, as vector graphics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator
from numpy.typing import NDArray
from scipy.special import ndtr, ndtri

from lrsr.evaluation.discard import DiscardCurve
from lrsr.evaluation.likelihood import ECE_ODDS, TIPPETT_LLRS, Curve, Evidence
from lrsr.evaluation.rates import CmcCurve
from lrsr.evaluation.roc import RocCurve
from lrsr.pages import STYLE, line_style, svg_uri

_RATES = (1e-5, 1e-4, 1e-3, 1e-2, 0.05, 0.1, 0.2, 0.4, 0.6, 0.8, 0.9, 0.95, 0.99)
_GENUINE, _IMPOSTOR, _BEST = "#0072B2", "#D55E00", "#009E73"
_ACROSS = 3
"""Small pictures in a row."""


def draw_det_and_cmc(curves: Mapping[str, RocCurve], ranks: Mapping[str, CmcCurve]) -> str:
    """Draw the two errors against each other on normal-deviate axes, and the hits by rank.

    Args:
        curves: By label, at least one.
        ranks: By label; empty where nobody was looked for in a gallery.

    Returns:
        An SVG as a data URI.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.5), layout="constrained")
        left, right = figure.subplots(1, 2)
        _draw_det(left, curves)
        if ranks:
            _draw_cmc(right, ranks)
        right.set_visible(bool(ranks))  # alone, the first would fill the page
        return svg_uri(figure)


def draw_tippett(found: Mapping[str, Evidence]) -> str:
    """Draw which share of the pairs of each kind has at least a ratio, a picture a method.

    Returns:
        An SVG as a data URI.
    """

    def draw(axes: Axes, evidence: Evidence) -> None:
        for found, colour, dashes, label in (
            (evidence.tippett_genuine, _GENUINE, "-", "genuine pairs"),
            (evidence.tippett_impostor, _IMPOSTOR, (0, (4, 1)), "impostor pairs"),
        ):
            _draw_band(axes, TIPPETT_LLRS, found, colour)
            axes.plot(TIPPETT_LLRS, found.values, color=colour, linestyle=dashes, label=label)
        axes.axvline(0, color="#999999", linewidth=0.6, linestyle=":")
        reach = max(1.0, math.ceil(max(-evidence.bound_low, evidence.bound_high) + 0.25))
        axes.set(xlim=(-reach, reach), ylim=(0, 1.01))

    return _small(found, draw, "log$_{10}$ LR at least", "Share of pairs")


def draw_ece(found: Mapping[str, Evidence]) -> str:
    """Draw the cross-entropy against the prior odds, a picture a method.

    Returns:
        An SVG as a data URI.
    """

    def draw(axes: Axes, evidence: Evidence) -> None:
        ece = evidence.ece
        _draw_band(axes, ECE_ODDS, ece, _IMPOSTOR)
        axes.plot(ECE_ODDS, evidence.ece_none, color="#555555", linestyle=":", label="no evidence")
        axes.plot(ECE_ODDS, ece.values, color=_IMPOSTOR, label="these ratios")
        axes.plot(
            ECE_ODDS,
            evidence.ece_min.values,
            color=_BEST,
            linestyle=(0, (4, 1)),
            label="best rising calibration",
        )
        axes.set(xlim=(ECE_ODDS[0], ECE_ODDS[-1]), ylim=(0, 1.05))

    return _small(found, draw, "Prior log$_{10}$ odds", "Cross-entropy, bits")


def draw_discard(found: Mapping[str, Mapping[str, DiscardCurve]]) -> str:
    """Draw the FNMR against the share that was discarded, a picture a measure of quality.

    Args:
        found: By measure, then by method's label.

    Returns:
        An SVG as a data URI.
    """

    def draw(axes: Axes, curves: Mapping[str, DiscardCurve]) -> None:
        for number, (label, curve) in enumerate(curves.items()):
            style = line_style(number)
            places = np.append(curve.discarded, curve.discarded[-1])
            axes.step(places[:-1], curve.fnmr, where="post", label=label, **style)
            if len(curves) == 1:
                axes.fill_between(
                    curve.discarded, curve.low, curve.high, step="post", alpha=0.12, lw=0
                )
        axes.set(xlim=(0, 0.5), ylim=(0, None))

    return _small(found, draw, "Share discarded", "FNMR of the rest")


def _small(
    found: Mapping[str, Any], draw: Callable[[Axes, Any], None], xlabel: str, ylabel: str
) -> str:
    """Draw one small picture for each, with one legend for all."""
    across = 2 if len(found) == 4 else min(_ACROSS, len(found))
    down = math.ceil(len(found) / across)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 2.1 * down + 0.3), layout="constrained")
        grid = figure.subplots(down, across, squeeze=False, sharey=True)
        for axes, (title, what) in zip(grid.flat, found.items(), strict=False):
            draw(axes, what)
            axes.set(title=title)
            axes.grid(visible=True)
        for axes in list(grid.flat)[len(found) :]:
            axes.set_visible(False)
        figure.supxlabel(xlabel, fontsize=8)
        figure.supylabel(ylabel, fontsize=8)
        handles, labels = grid[0, 0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper center", ncols=min(4, len(labels)))
        return svg_uri(figure)


def _draw_det(axes: Axes, curves: Mapping[str, RocCurve]) -> None:
    least = min(1 / curve.n_impostor for curve in curves.values())
    lowest = min(1 / curve.n_genuine for curve in curves.values())
    for number, (label, curve) in enumerate(curves.items()):
        # An error of 0 has no place on such an axis: half an error stands for it.
        fmr = np.clip(curve.fmr, 0.5 / curve.n_impostor, 1 - 0.5 / curve.n_impostor)
        fnmr = np.clip(curve.fnmr, 0.5 / curve.n_genuine, 1 - 0.5 / curve.n_genuine)
        axes.plot(ndtri(fmr), ndtri(fnmr), label=label, zorder=3 + number, **line_style(number))
    axes.plot([-5, 5], [-5, 5], color="#999999", linewidth=0.6, linestyle=":", zorder=1)
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_major_locator(FixedLocator(list(ndtri(_RATES))))
        axis.set_major_formatter(FuncFormatter(lambda place, _: _percent(place)))
        axis.set_minor_locator(NullLocator())
    axes.tick_params(axis="x", rotation=45)
    left, bottom = ndtri(max(0.5 * least, 1e-6)), ndtri(max(0.5 * lowest, 1e-4))
    axes.set(xlabel="False-match rate (FMR)", ylabel="False-non-match rate (FNMR)")
    axes.set(xlim=(left, ndtri(0.6)), ylim=(bottom, ndtri(0.99)), title="DET")
    axes.grid(visible=True)
    axes.legend(loc="upper right", handlelength=3)


def _draw_cmc(axes: Axes, ranks: Mapping[str, CmcCurve]) -> None:
    last = max(curve.hit_rate.size for curve in ranks.values())
    for number, (label, curve) in enumerate(ranks.items()):
        places = np.arange(1, curve.hit_rate.size + 1)
        named = f"{label}  {100 * curve.rank_1:.1f} %"
        axes.step(places, curve.hit_rate, where="post", label=named, **line_style(number))
    if last > 20:
        axes.set(xscale="log")
    axes.xaxis.set_major_formatter(FuncFormatter(lambda place, _: f"{place:g}"))
    lowest = min(curve.rank_1 for curve in ranks.values())
    axes.set(xlabel="Rank", ylabel="Share of probes found by then", title="CMC")
    axes.set(xlim=(1, max(last, 2)), ylim=(max(0.0, lowest - 0.1), 1.01))
    axes.grid(visible=True)
    axes.legend(title="Method, rank 1", loc="lower right", handlelength=3)


def _draw_band(axes: Axes, places: NDArray[np.float64], curve: Curve, colour: str) -> None:
    if curve.low is not None and curve.high is not None:
        axes.fill_between(places, curve.low, curve.high, color=colour, alpha=0.15, linewidth=0)


def _percent(place: float) -> str:
    return f"{100 * ndtr(place):.3g} %"
