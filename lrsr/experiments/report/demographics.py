"""Who are they? How sex, age, ancestry and skin tone are spread over a set of people."""

import itertools
from collections.abc import Sequence
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

MAINLY = 0.5
"""Share from which on a person counts as mainly of one ancestry; below it for all: mixed."""

_SEXES = ("female", "male")
_SEX_COLOURS = {"female": "#D55E00", "male": "#0072B2"}
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
    mains = [_main_ancestry(person) for person in people]
    counts, _ = np.histogram(ages, DECADES)
    spans = [f"{low} to {high - 1}" for low, high in itertools.pairwise(DECADES)]
    return {
        "people": len(people),
        "sex": {sex: sum(person.sex == sex for person in people) for sex in _SEXES},
        "age_years": {
            "spans": dict(zip(spans, counts.tolist(), strict=True)),
            **({} if not ages else {"mean": float(np.mean(ages))}),
            **({} if not ages else {"youngest": min(ages), "oldest": max(ages)}),
        },
        "ancestry": {
            "mainly": {name: mains.count(name) for name in (*ANCESTRIES, "mixed")},
            "mean_share": {
                race: float(np.mean([person.ancestry.get(race, 0.0) for person in people]))
                for race in (ANCESTRIES if people else ())
            },
        },
        "skin_tone": {
            "classes": {tone: sum(p.skin_tone == tone for p in people) for tone in TONES},
            "ita_deg": {
                f"p{share}": float(np.percentile(angles, share))
                for share in ((5, 25, 50, 75, 95) if angles else ())
            },
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
        ancestries.set(title=f"Main ancestry (share of {MAINLY:.0%} or more)", ylabel="People")
        _draw_bars(tones, counts["skin_tone"]["classes"], _SWATCHES)
        tones.set(title="Skin tone, by class of the ITA", ylabel="People")
        _draw_angles(angles, people)
        for axes in (ages, ancestries, tones, angles):
            axes.yaxis.set_major_locator(MaxNLocator(integer=True))
        return png_bytes(figure)


def _main_ancestry(person: Traits) -> str:
    race = max(person.ancestry, key=lambda name: person.ancestry[name])
    return race if person.ancestry[race] >= MAINLY else "mixed"


def _draw_ages(axes: Axes, people: Sequence[Traits]) -> None:
    by_sex = [[person.age_years for person in people if person.sex == sex] for sex in _SEXES]
    names = [f"{sex} ({len(ages)})" for sex, ages in zip(_SEXES, by_sex, strict=True)]
    colours = [_SEX_COLOURS[sex] for sex in _SEXES]
    bins = np.arange(15, 86, 5)
    axes.hist(by_sex, bins=bins.tolist(), stacked=True, color=colours, label=names, rwidth=0.9)
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
