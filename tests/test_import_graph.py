"""Holds the architecture: imports run one way, and each heavy library has one home."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import lrsr

PACKAGE = Path(lrsr.__file__).parent
ORDER = (
    "identities",
    "rendering",
    "camera",
    "data",
    "sr",
    "recognition",
    "calibration",
    "evaluation",
    "experiments",
)
FORBIDDEN = {
    "camera": {"rendering", "identities"},
    "evaluation": {"rendering", "sr"},
    "recognition": {"rendering", "sr"},
}
HOMES = {
    "mitsuba": {"rendering"},
    "drjit": {"rendering"},
    "kornia": {"camera"},
    "av": {"camera"},
    "onnxruntime": {"recognition", "sr"},
    "lightning": {"data", "sr", "recognition"},
    "anny": {"identities"},
    "dlib": {"recognition"},
}


def imports_of(file: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(file.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""


def sources() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


@pytest.mark.parametrize("folder", ORDER)
def test_a_folder_imports_only_folders_on_its_left(folder: str) -> None:
    allowed = set(ORDER[: ORDER.index(folder) + 1]) - FORBIDDEN.get(folder, set())
    for file in sorted((PACKAGE / folder).rglob("*.py")):
        for name in imports_of(file):
            if name.startswith("lrsr.") and name.split(".")[1] in ORDER:
                assert name.split(".")[1] in allowed, f"{file.name} imports {name}"


@pytest.mark.parametrize("library", HOMES)
def test_a_heavy_library_has_one_home(library: str) -> None:
    users = {
        file.relative_to(PACKAGE).parts[0]
        for file in sources()
        if library in {name.split(".")[0] for name in imports_of(file)}
    }
    assert users <= HOMES[library]


@pytest.mark.parametrize("module", ["lrsr", "lrsr.cli", "lrsr.identities", "lrsr.rendering"])
def test_importing_loads_no_heavy_library(module: str) -> None:
    script = f"import sys, {module}; print(*sys.modules)"
    loaded = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    ).stdout.split()
    assert not {*HOMES, "torch", "hydra"} & set(loaded)
