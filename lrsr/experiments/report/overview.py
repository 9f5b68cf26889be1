"""What do all conditions look like at a glance? Areas as heat maps, and faces side by side."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import torch

from lrsr.experiments.report.heat import draw_heat_maps
from lrsr.experiments.report.panel import Figure, Panel
from lrsr.experiments.report.sheets import draw_contact_sheet

_MANY = 2
"""Axes from which on conditions make a table, of areas and of one person's faces."""


_UNSEEN = ("detector",)
"""Axes that change no picture."""


@dataclass(frozen=True)
class FaceGrid:
    """Faces side by side.

    Attributes:
        title: What they have in common; may be empty.
        columns: Names.
        rows: By name, a face ``(3, h, w)`` srgb a column.
    """

    title: str
    columns: Sequence[str]
    rows: Mapping[str, Sequence[torch.Tensor]]


def draw_conditions(grids: Sequence[FaceGrid]) -> bytes:
    """Draw all grids on one sheet, a column for each of theirs; return a PNG."""
    columns = {}
    for grid in grids:
        for number, name in enumerate(grid.columns):
            faces = torch.stack([row[number] for row in grid.rows.values()])
            columns["\n".join(filter(None, (name, grid.title)))] = faces
    return draw_contact_sheet(columns, [*grids[0].rows])


class Overview:
    """Where each condition stands: its row, its column, and its block of these.

    Args:
        config: As in ``results.json``: the conditions, each with what sets it apart by axis.
    """

    def __init__(self, config: Mapping[str, Any]) -> None:
        self._varied = {
            one["option"]: one.get("varied", {}) for one in config.get("conditions", ())
        }
        self._axes = [*next(iter(self._varied.values()), {})]
        self._seen = [axis for axis in self._axes if axis not in _UNSEEN]

    def heat_maps(self, rows: Sequence[Mapping[str, Any]]) -> list[Figure]:
        """Draw the areas of each method, recogniser and source of landmarks; rows of results."""
        if len(self._axes) < _MANY:
            return []
        found: dict[tuple[str, ...], dict[str, dict[str, dict[str, float | None]]]] = {}
        sized = len({row["ipd_px"] for row in rows}) > 1
        for row in rows:
            name = (row["recogniser"], row["label"], row["landmarks"])
            size = row["ipd_px"] if sized else None
            across, down, block = self._place(row["option"], size, self._axes)
            maps = found.setdefault(name, {}).setdefault(block, {})
            maps.setdefault(down, {})[across] = row["auc"]
        return [
            Figure(
                draw_heat_maps(blocks, f"{label}, {landmarks} landmarks, {recogniser}"),
                f"AUC of {label} under every condition; the numbers are those of the table",
                f"AUC of {label} with {landmarks} landmarks, recogniser {recogniser}, by"
                f" {' and '.join(axis.replace('_', ' ') for axis in self._axes)}. 0.5 is guessing.",
            )
            for (recogniser, label, landmarks), blocks in found.items()
        ]

    def faces(self, panels: Sequence[Panel]) -> list[FaceGrid]:
        """Put probes side by side: one axis, everybody shown; several, the first person."""
        shown = [panel for panel in panels if panel.place and "Probe" in panel.pictures]
        if not self._seen or not shown:
            return []
        sized = len({panel.place[1] for panel in shown if panel.place}) > 1
        blocks: dict[str, dict[str, dict[str, torch.Tensor]]] = {}
        for panel in shown:
            option, ipd_px = panel.place or (0, None)
            size = ipd_px if sized else None
            across, down, block = self._place(option, size, self._seen)
            grid = blocks.setdefault(block, {})
            if len(self._seen) >= _MANY:
                grid.setdefault(down, {})[across] = panel.pictures["Probe"][0]
                continue
            for person, face in zip(panel.people, panel.pictures["Probe"], strict=False):
                grid.setdefault(person, {})[across] = face
        return [
            FaceGrid(
                title, [*next(iter(grid.values()))], {k: [*v.values()] for k, v in grid.items()}
            )
            for title, grid in blocks.items()
        ]

    def _place(
        self, option: int, ipd_px: float | None, axes: Sequence[str]
    ) -> tuple[str, str, str]:
        """Return column, row and block of a condition by name."""
        varied = self._varied[option]
        named = [(axis.replace("_", " "), varied[axis]) for axis in axes]
        words = [f"{axis} {name}" for axis, name in named]
        rest = words[_MANY:] + ([] if ipd_px is None else [f"IPD {ipd_px:g} px"])
        if len(named) < _MANY:
            return named[0][1], "", ", ".join([named[0][0], *rest])
        return words[1], words[0], ", ".join(rest)
