"""What does a reader get? One HTML file that holds everything, for the screen and for paper."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from numpy.typing import ArrayLike

from lrsr.errors import InputError
from lrsr.evaluation.multiplicity import holm_adjusted
from lrsr.evaluation.roc import RocCurve
from lrsr.experiments.figures import Interval, draw_intervals, draw_roc, encode_face
from lrsr.files import write_text

FILE = "report.html"
_TEMPLATES = Path(__file__).resolve().parent / "templates"
_ROW_KEYS = ("option", "label", "auc", "std", "low", "high", "n_genuine", "n_impostor")
_RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
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
            :class:`~lrsr.evaluation.biometrics.OperatingPoint` or dicts of its fields).
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
    lines = _lines(report)
    return template("report.html.j2").render(
        report=report,
        answer=report.answer or list(_best(lines)),
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


def template(name: str) -> Template:
    """Return one of the pages' templates; whatever is put into it is escaped."""
    environment = Environment(
        loader=FileSystemLoader(_TEMPLATES),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)


def format_p(p: float, log10_p: float | None = None) -> str:
    r"""Write a p value with two digits, as a power of ten where it is small.

    Args:
        p: [0, 1].
        log10_p: Its decimal logarithm, where p itself underflows.

    Example:
        >>> [format_p(p).replace("\u00a0", " ") for p in (0.43, 0.043, 0.00012, 0.0)]
        ['0.43', '0.043', '1.2 × 10⁻⁴', '0']
        >>> format_p(0.0, log10_p=-400.5).replace("\u00a0", " ")
        '3.2 × 10⁻⁴⁰¹'
    """
    if p >= 0.00095:
        return f"{p:.2f}" if p >= 0.095 else f"{p:.2g}"
    if p > 0:
        log10_p = math.log10(p)
    if log10_p is None or not math.isfinite(log10_p):
        return "0"
    exponent = math.floor(log10_p)
    mantissa = f"{10 ** (log10_p - exponent):.1f}"
    if mantissa == "10.0":
        mantissa, exponent = "1.0", exponent + 1
    return f"{mantissa}\u00a0×\u00a010{str(exponent).translate(_RAISED)}"


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


def _lines(report: Report) -> list[dict[str, Any]]:
    """Turn rows into what the template prints."""
    adjusted = holm_adjusted([comparison["p"] for comparison in report.comparisons])
    labels = _labels(report)
    tests: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for comparison, p_holm in zip(report.comparisons, adjusted, strict=True):
        place = (comparison["option"], comparison.get("ipd_px"), comparison["method"])
        tests.setdefault(place, []).append(
            {
                "against": comparison["against"],
                "against_label": labels[comparison["against"]],
                "difference": _signed(comparison["difference"]),
                "p": format_p(comparison["p"], comparison.get("log10_p")),
                "remains": p_holm < 0.05,
            }
        )
    return [
        _line(
            row, tests.get((row["option"], row.get("ipd_px"), row.get("method", row["label"])), [])
        )
        for row in report.rows
    ]


def _line(row: Mapping[str, Any], tests: list[dict[str, Any]]) -> dict[str, Any]:
    low, high = row["low"], row["high"]
    degenerate = row["std"] == 0
    cut = not degenerate and (low <= 0 or high >= 1) and row.get("logit_low") is not None
    if cut:
        low, high = row["logit_low"], row["logit_high"]
    return {
        "option": row["option"],
        "condition": _condition(row),
        "label": row["label"],
        "value": row["auc"],
        "auc": f"{row['auc']:.3f}",
        "low": low,
        "high": high,
        "interval": "no interval" if degenerate else f"{low:.3f} – {high:.3f}",
        "cut": cut,
        "degenerate": degenerate,
        "std": f"{row['std']:.4f}",
        "psnr": _optional(row.get("psnr_y_db"), ".2f"),
        "fta": _optional(row.get("fta"), ".1%"),
        "n_genuine": f"{row['n_genuine']:,}",
        "n_impostor": f"{row['n_impostor']:,}",
        "eer": _optional(row.get("eer"), ".3f"),
        "d_prime": _optional(row.get("d_prime"), ".2f"),
        "rank_1": _optional(row.get("rank_1"), ".1%"),
        "fnmr": [_point(point) for point in row.get("fnmr") or ()],
        "tests": {test["against"]: test for test in tests},
    }


def _point(point: Any) -> dict[str, Any]:
    fields = point if isinstance(point, Mapping) else vars(point)
    return {
        "fnmr": f"{fields['fnmr']:.3f}",
        "interval": f"{fields['fnmr_low']:.3f} – {fields['fnmr_high']:.3f}",
        "fmr": f"{fields['fmr']:.2g}",
        "few": bool(fields["few_false_matches"]),
    }


def _best(lines: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Name the highest AUC of each condition, and what it is worth."""
    for condition in dict.fromkeys(line["condition"] for line in lines):
        here = [line for line in lines if line["condition"] == condition]
        top = max(line["value"] for line in here)
        best = [line for line in here if line["value"] == top]
        if len(best) > 1:
            names = ", ".join(line["label"] for line in best)
            yield f"{condition}: {names} share the highest AUC, {best[0]['auc']}."
        else:
            yield f"{condition}: {_praise(best[0])}."


def _praise(line: Mapping[str, Any]) -> str:
    interval = "" if line["degenerate"] else f" [{line['interval']}]"
    clauses = [f"the highest AUC is that of {line['label']}, {line['auc']}{interval}"]
    for test in line["tests"].values():
        verdict = "" if test["remains"] else ", no difference shown"
        clauses.append(
            f"against {test['against_label']} {test['difference']}"
            f" (p\u00a0=\u00a0{test['p']}{verdict})"
        )
    return "; ".join(clauses)


def _against(report: Report) -> list[list[dict[str, str]]]:
    """Group the methods that others are tested against into at most two columns of the table.

    The first of them in the order of the rows, usually Base, has its own column.
    """
    tested = {comparison["against"] for comparison in report.comparisons}
    methods = [
        {"method": method, "label": label}
        for method, label in _labels(report).items()
        if method in tested
    ]
    return [column for column in (methods[:1], methods[1:]) if column]


def _labels(report: Report) -> dict[str, str]:
    return {row.get("method", row["label"]): row["label"] for row in report.rows}


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


def _condition(row: Mapping[str, Any]) -> str:
    words = [f"Option {row['option']}"]
    if row.get("ipd_px") is not None:
        words.append(f"IPD {row['ipd_px']:g} px")
    return ", ".join(words)


def flat(settings: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, str]]:
    """Yield the dotted name and the text of every value of nested settings."""
    for key, value in settings.items():
        if isinstance(value, Mapping):
            yield from flat(value, f"{prefix}{key}.")
        elif isinstance(value, list | tuple):
            yield f"{prefix}{key}", ", ".join(map(str, value))
        else:
            yield f"{prefix}{key}", str(value)


def _optional(value: float | None, form: str) -> str:
    return "–" if value is None else format(value, form)


def _signed(value: float) -> str:
    return f"{value:+.3f}".replace("-", "−")


def _percent(level: float) -> str:
    return f"{100 * level:g} %"
