"""What does a reader get? One HTML file that holds everything, for the screen and for paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import torch

from lrsr.evaluation.roc import RocCurve
from lrsr.experiments.report.figures import draw_intervals, draw_roc
from lrsr.experiments.report.lines import (
    best_methods,
    condition_of,
    method_labels,
    report_lines,
    several_sources,
)
from lrsr.experiments.table import WRONG_PLACE_IPDS
from lrsr.pages import encode_face, write_page

_LIKENESS = (
    ("psnr_y_db", "PSNR&#8209;Y <small>dB</small>", "{:.2f}"),
    ("ssim_y", "SSIM&#8209;Y", "{:.3f}"),
    ("identity_similarity", "Identity", "{:.3f}"),
    ("lpips", "LPIPS", "{:.3f}"),
    ("wrong_place", "Wrong place", "{:.1%}"),
    ("landmark_distance_ipds", "Landmarks off <small>IPD</small>", "{:.3f}"),
)
"""Of a method's pictures beside the truth: name in a row, in the table, and format."""


@dataclass(frozen=True)
class Figure:
    """A picture of a report.

    Attributes:
        png: As a data URI.
        alt: What it shows, for who cannot see it.
        caption: What a reader must know.
    """

    png: str
    alt: str
    caption: str


@dataclass(frozen=True)
class Panel:
    """What one condition looks like.

    Attributes:
        title: Names the condition.
        curves: ROC curves by the source of the landmarks and by method label, in the order of the
            legend; may be empty.
        pictures: Columns of the contact sheet in order, e.g. Gallery, Probe, each method,
            Reference; each ``(n, 3, h, w)`` srgb in [0, 1], any size; may be empty.
        people: Names of the n people shown.
        figures: Shown below the ROC curves.
    """

    title: str
    curves: Mapping[str, Mapping[str, RocCurve]] = field(default_factory=dict)
    pictures: Mapping[str, torch.Tensor] = field(default_factory=dict)
    people: Sequence[str] = ()
    figures: Sequence[Figure] = ()


def write_report(
    folder: Path,
    results: Mapping[str, Any],
    panels: Sequence[Panel],
    *,
    done: Sequence[str],
    not_done: Sequence[str],
    page: str = "report",
    more: Mapping[str, Any] | None = None,
) -> Path:
    """Write ``report.html``: self-contained, with every picture inside.

    Args:
        folder: Is made if need be.
        results: What ``results.json`` holds: rows, comparisons, config, recognition, versions;
            likelihood_ratios, groups and discards, if there are any.
        panels: Curves and contact sheet of each condition.
        done: What was done, a sentence each.
        not_done: What was not, and what the numbers do not show.
        page: Name of the template.
        more: What that template prints besides, or in place of what reports print.

    Returns:
        Path of the file.

    Raises:
        InputError: The folder cannot be written.
        ImageContractError: A picture is not ``(3, h, w)`` or holds a NaN.
    """
    rows, config = results["rows"], results["config"]
    lines = report_lines(rows, results["comparisons"])
    rivals = {test["against"] for test in results["comparisons"]}
    others = [(name, label) for name, label in method_labels(rows).items() if name in rivals]
    several = len({line["condition"] for line in lines}) > 1
    measured = [line for line in lines if line["measured"]]
    labels = [
        f"{line['condition']}, {line['label']}" if several else line["label"] for line in measured
    ]
    return write_page(
        folder,
        page,
        title=config["name"].replace("_", " ").capitalize(),
        question=config["question"],
        settings={**config, "recognition": results["recognition"]},
        likelihoods=_told(results, "likelihood_ratios"),
        groups=_by_group(_told(results, "groups")),
        tables=_tables(lines),
        several_options=several,
        level=f"{100 * config['level']:g} %",
        against=[dict(some) for some in (others[:1], others[1:]) if some],  # the first is Base
        likeness=[one for one in _LIKENESS if any(row.get(one[0]) is not None for row in rows)],
        boot=any(row.get("bootstrap_low") is not None for row in rows),
        partial=next((p["max_fmr"] for row in rows for p in row.get("partial_auc", ())), None),
        target_fmrs=[f"{p['target_fmr']:g}" for p in max((row["fnmr"] for row in rows), key=len)],
        intervals=(
            draw_intervals(labels, measured, "Area under the ROC curve") if measured else None
        ),
        panels=[_panel(panel, config["level"]) for panel in panels],
        wrong_place_ipds=f"{WRONG_PLACE_IPDS:g}",
        n_tests=len(results["comparisons"]),
        done=done,
        not_done=not_done,
        versions=results["versions"],
        seed=config["seed"],
        **{"answer": list(best_methods(lines)), **(more or {})},
    )


def _tables(lines: Sequence[Mapping[str, Any]]) -> dict[str, list[Mapping[str, Any]]]:
    """Return the lines of each recogniser."""
    tables: dict[str, list[Mapping[str, Any]]] = {}
    for line in lines:
        tables.setdefault(line["recogniser"], []).append(line)
    return tables


def _told(results: Mapping[str, Any], name: str) -> list[dict[str, Any]]:
    """Return further records with the words that their table has for the condition."""
    several = several_sources(results["rows"])
    return [{**one, "condition": condition_of(one, several)} for one in results.get(name, ())]


def _by_group(records: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a line a condition and group, with a cell for each method."""
    lines: dict[tuple[str, str], dict[str, Any]] = {}
    for record in records:
        name = f"{record['trait']}: {record['group']}"
        told = {key: record[key] for key in ("condition", "people", "target_fmr")}
        line = lines.setdefault((record["condition"], name), {"name": name, "cells": {}, **told})
        line["cells"][record["label"]] = record
    return list(lines.values())


def _panel(panel: Panel, level: float) -> dict[str, Any]:
    columns = {
        label: [encode_face(face) for face in np.asarray(faces)]
        for label, faces in panel.pictures.items()
    }
    return {
        "title": panel.title,
        "rocs": [
            (landmarks, draw_roc(curves, level))
            for landmarks, curves in panel.curves.items()
            if curves
        ],
        "figures": panel.figures,
        "columns": [(label, *np.shape(faces)[-2:]) for label, faces in panel.pictures.items()],
        "people": list(zip(panel.people, zip(*columns.values(), strict=True), strict=False)),
    }
