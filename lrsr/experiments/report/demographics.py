"""Who are they? How sex, age, ancestry and skin tone are spread over a set of people."""

import itertools
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from lrsr.identities.person import TONES, Traits
from lrsr.identities.population import ANCESTRIES
from lrsr.pages import DPI, STYLE, png_bytes

DECADES = (18, 30, 40, 50, 60, 70, 81)
"""Ages are counted from one to the next, the last not included."""

_MAINLY = 0.5
"""Share from which on a person counts as mainly of one ancestry; below it for all: mixed."""

_SEXES = {"female": "#D55E00", "male": "#0072B2"}
_SWATCHES = ("#f3d9c6", "#e6bd9f", "#cf9c77", "#ab7450", "#7c4d31", "#432a1f")
"""About what skin of each tone looks like; for the eye only."""


def spread(people: Sequence[Traits]) -> dict[str, Any]:
    """Count people by sex, age, main ancestry and skin tone.

    Args:
        people: Any number.

    Returns:
        JSON-serialisable: ``people``, ``sex``, ``age_years`` (counts by span, and mean, youngest
        and oldest), ``ancestry`` (counts by main one, and mean shares), ``skin_tone`` (counts, and
        percentiles of the ITA).
    """
    ages = [person.age_years for person in people]
    angles = [person.ita_deg for person in people]
    mains = Counter(main_ancestry(person.ancestry) for person in people)
    sexes = Counter(person.sex for person in people)
    tones = Counter(person.skin_tone for person in people)
    counts, _ = np.histogram(ages, DECADES)
    spans = [f"{low} to {high - 1}" for low, high in itertools.pairwise(DECADES)]
    years: dict[str, Any] = {"spans": dict(zip(spans, counts.tolist(), strict=True))}
    if people:
        years |= {"mean": float(np.mean(ages)), "youngest": min(ages), "oldest": max(ages)}
    races, percentiles = (ANCESTRIES, (5, 25, 50, 75, 95)) if people else ((), ())
    shares = {race: [one.ancestry.get(race, 0.0) for one in people] for race in races}
    return {
        "people": len(people),
        "sex": {sex: sexes[sex] for sex in _SEXES},
        "age_years": years,
        "ancestry": {
            "mainly": {name: mains[name] for name in (*ANCESTRIES, "mixed")},
            "mean_share": {race: float(np.mean(share)) for race, share in shares.items()},
        },
        "skin_tone": {
            "classes": {tone: tones[tone] for tone in TONES},
            "ita_deg": {f"p{k}": float(np.percentile(angles, k)) for k in percentiles},
        },
    }


def draw_spread(people: Sequence[Traits]) -> bytes:
    """Draw ages by sex, main ancestries, and skin tones with the ITA.

    Args:
        people: At least one.

    Returns:
        A PNG.
    """
    counts = spread(people)
    with rc_context(STYLE):
        figure = Figure(figsize=(7.2, 4.6), dpi=DPI, layout="constrained")
        (ages, ancestries), (tones, angles) = figure.subplots(2, 2)
        _draw_ages(ages, people)
        _draw_bars(ancestries, counts["ancestry"]["mainly"], "#0072B2")
        ancestries.set(title=f"Main ancestry (share of {_MAINLY:.0%} or more)", ylabel="People")
        _draw_bars(tones, counts["skin_tone"]["classes"], _SWATCHES)
        tones.set(title="Skin tone, by class of the ITA", ylabel="People")
        _draw_angles(angles, people)
        for axes in (ages, ancestries, tones, angles):
            axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        return png_bytes(figure)


def main_ancestry(shares: Mapping[str, float]) -> str:
    """Return the ancestry of half or more of a person, else "mixed"."""
    race = max(shares, key=lambda name: shares[name])
    return race if shares[race] >= _MAINLY else "mixed"


def _draw_ages(axes: Axes, people: Sequence[Traits]) -> None:
    by_sex = [[person.age_years for person in people if person.sex == sex] for sex in _SEXES]
    names = [f"{sex} ({len(ages)})" for sex, ages in zip(_SEXES, by_sex, strict=True)]
    bins, colours = list(range(15, 86, 5)), list(_SEXES.values())
    axes.hist(by_sex, bins=bins, stacked=True, color=colours, label=names, rwidth=0.9)
    axes.set(title="Age and sex", xlabel="Years", ylabel="People", xlim=(15, 85))
    axes.legend()


def _draw_bars(axes: Axes, counts: dict[str, int], colour: str | Sequence[str]) -> None:
    bars = axes.bar(list(counts), list(counts.values()), color=colour, edgecolor="#555555")
    axes.bar_label(bars, fontsize=7)
    axes.tick_params(axis="x", length=0, labelsize=6.5)
    axes.margins(y=0.15)


def _draw_angles(axes: Axes, people: Sequence[Traits]) -> None:
    angles = [person.ita_deg for person in people]
    low, high = min(-60.0, *angles), max(70.0, *angles)
    edges = [high, *list(TONES.values())[:-1], low]
    for upper, lower, colour in zip(edges, edges[1:], _SWATCHES, strict=False):
        axes.axvspan(lower, upper, color=colour, alpha=0.55, linewidth=0)
    axes.hist(angles, bins=np.linspace(low, high, 27).tolist(), color="#222222", rwidth=0.85)
    axes.set(xlabel="Individual typology angle of the cheeks, degrees", ylabel="People")
    axes.set(title="Lightness of the skin", xlim=(low, high))
