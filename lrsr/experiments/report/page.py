"""What does a reader get? One HTML file that holds everything, for the screen and for paper."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lrsr.experiments.report.figures import draw_intervals, draw_roc
from lrsr.experiments.report.lines import (
    across_conditions,
    best_methods,
    condition_of,
    extremes,
    method_labels,
    report_lines,
    several_sources,
)
from lrsr.experiments.report.overview import Overview
from lrsr.experiments.report.panel import Panel
from lrsr.experiments.report.published import beside_published
from lrsr.experiments.seen import WRONG_PLACE_IPDS
from lrsr.pages import encode_face, title_of, write_page

_LIKENESS = (
    ("psnr_y_db", "PSNR&#8209;Y <small>dB</small>", "{:.2f}"),
    ("ssim_y", "SSIM&#8209;Y", "{:.3f}"),
    ("identity_similarity", "Identity", "{:.3f}"),
    ("lpips", "LPIPS", "{:.3f}"),
    ("wrong_place", "Wrong place", "{:.1%}"),
    ("landmark_distance_ipds", "Landmarks off <small>IPD</small>", "{:.3f}"),
    ("false_faces", "False faces <small>a picture</small>", "{:.2f}"),
)
"""Of a method's pictures beside the truth: name in a row, in the table, and format."""


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
    rivals = {test["against"] for test in results["comparisons"] if not across_conditions(test)}
    view = Overview(config)
    others = [(name, label) for name, label in method_labels(rows).items() if name in rivals]
    several = len({line["condition"] for line in lines}) > 1
    measured = [line for line in lines if line["measured"]]
    labels = [
        f"{line['condition']}, {line['label']}" if several else line["label"] for line in measured
    ]
    return write_page(
        folder,
        page,
        question=config["question"],
        heat_maps=view.heat_maps(rows),
        grids=[
            (grid.title, grid.columns, {k: [*map(encode_face, v)] for k, v in grid.rows.items()})
            for grid in view.faces(panels)
        ],
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
        published=beside_published(config["name"], rows),
        across={line["rival"]["label"] for line in lines if line["rival"]},
        panels=[_panel(panel, config["level"]) for panel in panels if config.get("details", True)],
        wrong_place_ipds=f"{WRONG_PLACE_IPDS:g}",
        n_tests=len(results["comparisons"]),
        done=done,
        not_done=not_done,
        versions=results["versions"],
        seed=config["seed"],
        **{
            "title": title_of(config["name"]),
            "answer": list(extremes(lines) or best_methods(lines)),
            **(more or {}),
        },
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
