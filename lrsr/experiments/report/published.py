"""What has the paper printed where a report has a figure of its own? Only what is known."""

import tomllib
from collections.abc import Mapping, Sequence
from typing import Any

from lrsr.paths import asset

_Rows = Sequence[Mapping[str, Any]]


def beside_published(experiment: str, rows: _Rows) -> dict[str, Any] | None:
    """Put the paper's areas beside those of rows of the same experiment, option, size and method.

    Args:
        experiment: Its name.
        rows: As in ``results.json``.

    Returns:
        ``lines`` (option, method's label, the paper's area, and ours by recogniser and landmarks,
        as text), the ``columns`` of ours, ``source`` and what is ``missing``; None where nothing
        matches. Where the paper's method is not known, ours go from the lowest to the highest.
    """
    told = tomllib.loads(asset("published.toml").read_text(encoding="utf-8"))
    measured = [row for row in rows if row["auc"] is not None]
    columns = list(dict.fromkeys(_column(row) for row in measured))
    lines = []
    for figure in told["figure"]:
        same = [row for row in measured if _matches(figure, row, experiment)]
        if same:
            label = same[0]["label"] if figure["method"] else "method not told"
            ours = [_span([row["auc"] for row in same if _column(row) == one]) for one in columns]
            lines.append({**figure, "label": label, "ours": ours})
    if not lines:
        return None
    return {
        "lines": lines,
        "columns": columns,
        "source": told["source"],
        "missing": told["missing"],
    }


def _matches(figure: Mapping[str, Any], row: Mapping[str, Any], experiment: str) -> bool:
    place = (experiment, row["option"], row["ipd_px"])
    here = place == (figure["experiment"], figure["option"], figure["ipd_px"])
    return here and figure["method"] in ("", row["method"])


def _column(row: Mapping[str, Any]) -> str:
    return f"{row['recogniser']}, {row['landmarks']} landmarks"


def _span(areas: Sequence[float]) -> str:
    if not areas:
        return "–"
    low, high = f"{min(areas):.3f}", f"{max(areas):.3f}"
    return low if low == high else f"{low} to {high}"
