"""Holds the order of the making of people: shape, face, skin, hair, gate; no part looks ahead."""

import ast
from collections.abc import Mapping
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import lrsr.identities

ROOT = Path(lrsr.identities.__file__).parent
PREFIX = "lrsr.identities."
FOLDERS = ("shape", "face", "skin", "hair", "gate")


def imported(file: Path) -> set[str]:
    """Folders and loose modules of identities that a file imports, within functions too."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name.removeprefix(PREFIX).split(".")[0] for name in names if name.startswith(PREFIX)}


def graph() -> Mapping[str, set[str]]:
    """What each part imports; the lazy package itself stands above all of them."""
    parts: dict[str, set[str]] = {}
    for file in sorted(ROOT.rglob("*.py")):
        part = file.relative_to(ROOT).with_suffix("").parts[0]
        if part != "__init__":
            parts[part] = parts.get(part, set()) | (imported(file) - {part})
    return parts


def test_no_part_of_identities_imports_itself_by_a_detour() -> None:
    assert set(TopologicalSorter(graph()).static_order()) >= set(FOLDERS)


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_imports_only_folders_before_it(folder: str) -> None:
    allowed = set(FOLDERS[: FOLDERS.index(folder)])
    assert graph()[folder] & set(FOLDERS) <= allowed


@pytest.mark.parametrize("folder", FOLDERS)
def test_a_folder_does_not_know_who_puts_heads_together(folder: str) -> None:
    assert not graph()[folder] & {"appearance", "morphable", "person", "roster"}
