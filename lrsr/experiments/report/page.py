"""What does a reader get? One HTML file that holds everything, for the screen and for paper."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from lrsr.errors import InputError
from lrsr.evaluation.roc import RocCurve
from lrsr.experiments.report.figures import Interval, draw_intervals, draw_roc
from lrsr.experiments.report.lines import best_methods, method_labels, report_lines
from lrsr.files import write_text
from lrsr.pages import FILE, encode_face, template

_ROW_KEYS = ("option", "label", "auc", "std", "low", "high", "n_genuine", "n_impostor")
_COMPARISON_KEYS = ("option", "method", "against", "difference", "p")


@dataclass(frozen=True)
class Panel:
    """What one condition looks like.

    Attributes:
        title: Names the condition.
        curves: ROC curves by method label, in the order of the legend; may be empty.
        pictures: Columns of the contact sheet in order, e.g. Gallery, Probe, each method,
            Reference; each ``(n, 3, h, w)`` srgb in [0, 1], any size; may be empty.
        people: Names of the n people shown; numbers if empty.
    """

    title: str
    curves: Mapping[str, RocCurve] = field(default_factory=dict)
    pictures: Mapping[str, ArrayLike] = field(default_factory=dict)
    people: Sequence[str] = ()


@dataclass(frozen=True)
class Report:
    """Everything that a report says.

    Attributes:
        title: Of the experiment.
        question: That its table answers.
        settings: What was asked for; mappings inside are flattened to dotted names.
        rows: Lines of the table, as in ``results.json``: option, method, label, auc, std, low,
            high, n_genuine, n_impostor and, where known, level, logit_low, logit_high, psnr_y_db,
            fta, eer, d_prime, rank_1, ipd_px, fnmr (of
            :class:`~lrsr.evaluation.rates.OperatingPoint` or dicts of its fields).
        comparisons: Paired tests: option, method, against, difference, p and, where known, log10_p,
            low, high, ipd_px.
        panels: Curves and contact sheet of each condition.
        answer: Sentences for the head of the page; the best method of each condition if empty.
        done: What was done, a sentence each.
        not_done: What was not, and what the numbers do not show.
        versions: Of the packages and assets, by name.
        commit: Git hash of the code; None outside a checkout.
        seed: All randomness follows from it.
    """

    title: str
    question: str
    settings: Mapping[str, Any]
    rows: Sequence[Mapping[str, Any]]
    comparisons: Sequence[Mapping[str, Any]] = ()
    panels: Sequence[Panel] = ()
    answer: Sequence[str] = ()
    done: Sequence[str] = ()
    not_done: Sequence[str] = ()
    versions: Mapping[str, str] = field(default_factory=dict)
    commit: str | None = None
    seed: int = 0


def write_report(folder: Path, report: Report) -> Path:
    """Write ``report.html``: self-contained, with every picture inside.

    Args:
        folder: Is made if need be.
        report: What it says.

    Returns:
        Path of the file.

    Raises:
        InputError: A row or a comparison lacks a field, a comparison names an unknown method, a
            contact sheet's columns differ in length, or the folder cannot be written.
        ImageContractError: A picture is not ``(3, h, w)`` or holds a NaN.
    """
    path = Path(folder) / FILE
    write_text(path, render_html(report))
    return path


def render_html(report: Report) -> str:
    """Return the page; see :func:`write_report`.

    Raises:
        InputError: As :func:`write_report`, but for the writing.
    """
    _check(report)
    lines = report_lines(report.rows, report.comparisons)
    return template("report.html.j2").render(
        report=report,
        answer=report.answer or list(best_methods(lines)),
        settings=list(flat(report.settings)),
        lines=lines,
        several_options=len({line["condition"] for line in lines}) > 1,
        levels=sorted({_percent(row.get("level", 0.95)) for row in report.rows}),
        cut=any(line["cut"] for line in lines),
        degenerate=any(line["degenerate"] for line in lines),
        against=_against(report),
        target_fmrs=_target_fmrs(report),
        few=any(point["few"] for line in lines for point in line["fnmr"]),
        intervals=_draw_intervals(lines),
        panels=[_panel(panel, report) for panel in report.panels],
        n_tests=len(report.comparisons),
    )


def _check(report: Report) -> None:
    if not report.rows:
        raise InputError("the report has no row: give at least one method's result")
    for name, entries, keys in (
        ("row", report.rows, _ROW_KEYS),
        ("comparison", report.comparisons, _COMPARISON_KEYS),
    ):
        for index, entry in enumerate(entries):
            missing = [key for key in keys if key not in entry]
            if missing:
                raise InputError(f"{name} {index} of the report lacks {', '.join(missing)}")
    methods = {row.get("method", row["label"]) for row in report.rows}
    for comparison in report.comparisons:
        for method in (comparison["method"], comparison["against"]):
            if method not in methods:
                raise InputError(f"a comparison names {method!r}; the rows have {sorted(methods)}")
    for panel in report.panels:
        lengths = {label: len(np.asarray(faces)) for label, faces in panel.pictures.items()}
        if len(set(lengths.values())) > 1:
            raise InputError(f"contact sheet {panel.title!r} has columns of {lengths} pictures")


def _against(report: Report) -> list[list[dict[str, str]]]:
    """Group the methods that others are tested against into at most two columns of the table.

    The first of them in the order of the rows, usually Base, has its own column.
    """
    tested = {comparison["against"] for comparison in report.comparisons}
    methods = [
        {"method": method, "label": label}
        for method, label in method_labels(report.rows).items()
        if method in tested
    ]
    return [column for column in (methods[:1], methods[1:]) if column]


def _target_fmrs(report: Report) -> list[str]:
    first = report.rows[0].get("fnmr") or ()
    fields = [point if isinstance(point, Mapping) else vars(point) for point in first]
    return [f"{point['target_fmr']:g}" for point in fields]


def _draw_intervals(lines: Sequence[Mapping[str, Any]]) -> str:
    several = len({line["condition"] for line in lines}) > 1
    return draw_intervals(
        [
            Interval(
                f"{line['condition']}, {line['label']}" if several else line["label"],
                line["value"],
                line["low"],
                line["high"],
            )
            for line in lines
        ],
        "Area under the ROC curve",
    )


def _panel(panel: Panel, report: Report) -> dict[str, Any]:
    columns = {label: np.asarray(faces) for label, faces in panel.pictures.items()}
    count = min((len(faces) for faces in columns.values()), default=0)
    level = float(report.rows[0].get("level", 0.95))
    return {
        "title": panel.title,
        "roc": draw_roc(panel.curves, level) if panel.curves else None,
        "columns": [
            {"label": label, "size": f"{faces.shape[-1]} × {faces.shape[-2]}"}
            for label, faces in columns.items()
        ],
        "people": [
            {
                "name": panel.people[index] if index < len(panel.people) else str(index + 1),
                "faces": [encode_face(faces[index]) for faces in columns.values()],
            }
            for index in range(count)
        ],
    }


def flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield the dotted name and the text of every value of nested settings."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            yield f"{prefix}{key}", ", ".join(map(str, value))
        else:
            yield f"{prefix}{key}", str(value)


def _percent(level: float) -> str:
    return f"{100 * level:g} %"
