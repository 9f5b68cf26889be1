"""What do the numbers look like? Curves, intervals and faces as vector graphics for one page."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator
from numpy.typing import ArrayLike, NDArray

from lrsr.evaluation.roc import RocCurve, band
from lrsr.pages import DPI, STYLE, line_style, png_bytes, svg_uri


def draw_roc(curves: Mapping[str, RocCurve], level: float = 0.95) -> str:
    """Draw ROC curves with their pointwise bands, on a plain and on a logarithmic FMR axis.

    The corners are joined as they are; the logarithmic axis begins at one false match.

    Args:
        curves: By label, at least one; the first eight have colours of their own.
        level: Of the bands, in (0, 1).

    Returns:
        An SVG as a data URI.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.5), layout="constrained")
        plain, logarithmic = figure.subplots(1, 2)
        least = 1 / max(curve.n_impostor for curve in curves.values())
        logarithmic.set(xscale="log", xlim=(least, 1), title="Few false matches (logarithmic FMR)")
        for number, (label, curve) in enumerate(curves.items()):
            for axes in (plain, logarithmic):
                _draw_curve(axes, curve, f"{label}  {curve.auc:.3f}", number, level)
        for axes in (plain, logarithmic):
            axes.set(xlabel="False-match rate (FMR)", ylabel="True-match rate", ylim=(0, 1.01))
            axes.grid(visible=True)
        plain.plot([0, 1], [0, 1], color="#999999", linewidth=0.6, linestyle=":", zorder=1)
        plain.set(xlim=(-0.01, 1), title="All thresholds")
        plain.legend(title="Method, AUC", loc="lower right", handlelength=3)
        return svg_uri(figure)


def draw_intervals(labels: Sequence[str], areas: Sequence[Mapping[str, Any]], quantity: str) -> str:
    """Draw values with their intervals, one under the other, the first on top.

    Args:
        labels: At least one.
        areas: auc, low and high of each.
        quantity: What the axis says.

    Returns:
        An SVG as a data URI.
    """
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 0.55 + 0.24 * len(areas)), layout="constrained")
        axes = figure.subplots()
        places = np.arange(len(areas))[::-1]
        for place, area in zip(places, areas, strict=True):
            axes.plot([area["low"], area["high"]], [place, place], color="#0072B2", linewidth=2.2)
            axes.plot(area["auc"], place, "o", color="black", markersize=4)
        axes.set_yticks(places, labels)
        left, right = axes.get_xlim()  # no area lies outside 0 to 1; a margin for half a dot
        axes.set(xlim=(max(left, -0.01), min(right, 1 + 0.1 * (1 - left))))
        axes.set(xlabel=quantity, ylim=(-0.6, len(areas) - 0.4))
        axes.tick_params(axis="y", length=0)
        axes.grid(visible=True, axis="x")
        axes.spines["left"].set_visible(False)
        return svg_uri(figure)


def draw_angles(angles_deg: ArrayLike, smallest_angle_deg: float, encoder: str) -> bytes:
    """Draw the histogram of the angles between people.

    Args:
        angles_deg: At least one, degrees.
        smallest_angle_deg: Marked, unless it is 0.
        encoder: What measured them.

    Returns:
        A PNG.
    """
    angles = np.asarray(angles_deg, dtype=np.float64)
    last = np.ceil(angles.max() / 5) * 5 + 5
    step = 1.0 if angles.size > 300 else 2.0
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 3.0), dpi=DPI, layout="constrained")
        axes = figure.subplots()
        axes.hist(angles, bins=np.arange(0, last + step, step).tolist(), color="#0072B2")
        for value, label, dashes in (
            (float(angles.min()), "smallest", "--"),
            (float(np.median(angles)), "median", "-"),
        ):
            axes.axvline(value, color="black", linestyle=dashes, label=f"{label} {value:.1f}°")
        if smallest_angle_deg > 0:
            label = f"nearer is one person: {smallest_angle_deg:g}°"
            axes.axvspan(0, smallest_angle_deg, color="#D55E00", alpha=0.2, lw=0, label=label)
        axes.set(xlabel=f"Angle between two people, degrees ({encoder} encoder)", ylabel="Pairs")
        axes.set(xlim=(0, last))
        axes.grid(visible=True, axis="y")
        axes.set_axisbelow(True)
        axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)  # over no bar
        return png_bytes(figure)


def _draw_curve(axes: Axes, curve: RocCurve, label: str, number: int, level: float) -> None:
    style = line_style(number)
    limits = band(curve, level)
    # Low holds up to the next FMR, high down to the one before: draw both as steps.
    kept = _seen(limits.fmr, limits.low, axes)
    fmr = np.repeat(limits.fmr[kept], 2)[1:-1]
    low, high = np.repeat(limits.low[kept], 2)[:-2], np.repeat(limits.high[kept], 2)[2:]
    axes.fill_between(fmr, low, high, color=style["color"], alpha=0.10, linewidth=0, zorder=2)
    axes.plot(curve.fmr, curve.tmr, label=label, zorder=3 + number, **style)


def _seen(fmr: NDArray[np.float64], low: NDArray[np.float64], axes: Axes) -> NDArray[np.intp]:
    """Return which places of a band are a hundred-and-fiftieth of the picture apart."""
    across = fmr
    if axes.get_xscale() == "log":
        least, most = axes.get_xlim()
        across = np.log(np.maximum(fmr, least) / least) / np.log(most / least)
    way = np.abs(np.diff(across, prepend=0.0)) + np.abs(np.diff(low, prepend=0.0))
    return np.unique(np.floor(150 * np.cumsum(way)), return_index=True)[1]
