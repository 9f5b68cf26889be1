"""Holds the architecture: imports run one way, and each heavy library has one home."""

import ast
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import lrsr

PACKAGE = Path(lrsr.__file__).parent
ORDER = (
    "evaluation",
    "identities",
    "rendering",
    "camera",
    "pictures",
    "sr",
    "recognition",
    "calibration",
    "training",
    "experiments",
)
FORBIDDEN = {
    "rendering": {"evaluation"},
    "camera": {"evaluation", "identities", "rendering"},
    "sr": {"identities", "rendering", "camera", "pictures"},
    "recognition": {"identities", "rendering", "camera", "pictures", "sr"},
}
"""What a folder does without, though it stands to its left."""
TOP = ("tasks", "cli", "__main__")
"""Modules above all folders; every other module of the top is below them."""
HOMES = {
    "mitsuba": {"rendering"},
    "drjit": {"rendering"},
    "kornia": {"camera"},
    "av": {"camera"},
    "onnxruntime": {"onnx.py"},
    "lightning": {"training"},
    "anny": {"identities"},
    "dlib": {"recognition"},
    "spandrel": {"sr"},
    "skimage": {"recognition"},
    "requests": {"download.py"},
    "trimesh": {"pictures"},
}


@cache
def statements_of(file: Path) -> list[ast.Import | ast.ImportFrom]:
    """Every import of a file, wherever in it; read once, for a dozen tests ask."""
    nodes = ast.walk(ast.parse(file.read_text()))
    return [node for node in nodes if isinstance(node, ast.Import | ast.ImportFrom)]


def imports_of(file: Path) -> Iterator[str]:
    for node in statements_of(file):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        else:
            yield node.module or ""


def sources() -> list[Path]:
    return sorted(PACKAGE.rglob("*.py"))


@pytest.mark.parametrize("folder", ORDER)
def test_a_folder_imports_only_folders_on_its_left(folder: str) -> None:
    allowed = set(ORDER[: ORDER.index(folder) + 1]) - FORBIDDEN.get(folder, set())
    for file in sorted((PACKAGE / folder).rglob("*.py")):
        for name in imports_of(file):
            if name.startswith("lrsr.") and name.split(".")[1] in (*ORDER, *TOP):
                assert name.split(".")[1] in allowed, f"{file.name} imports {name}"


def test_the_ground_floor_imports_no_folder() -> None:
    for file in PACKAGE.glob("*.py"):
        used = {name.split(".")[1] for name in imports_of(file) if name.startswith("lrsr.")}
        if file.stem not in TOP:
            assert not used & {*ORDER, *TOP}, file.name


def modules() -> dict[str, Path]:
    """Every module by its name; a folder's __init__ has the folder's."""
    return {
        ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts).removesuffix(
            ".__init__"
        ): file
        for file in sources()
    }


def used_modules(file: Path, known: dict[str, Path]) -> set[str]:
    """Which modules a file imports, wherever in it the import stands."""
    used = set()
    for node in statements_of(file):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            used |= {name if name in known else node.module for name in names}
        elif isinstance(node, ast.Import):
            used |= {alias.name for alias in node.names}
    return used & known.keys()


def check_order(graph: dict[str, set[str]]) -> None:
    """Raise CycleError, which names the ring, if parts import one another in a ring."""
    TopologicalSorter({name: used - {name} for name, used in graph.items()}).prepare()


def test_no_module_imports_itself_through_others() -> None:
    known = modules()
    check_order({name: used_modules(file, known) for name, file in known.items()})


@pytest.mark.parametrize("folder", ["", *ORDER])
def test_no_sub_folder_imports_itself_through_others(folder: str) -> None:
    known, root = modules(), ".".join(filter(None, ["lrsr", folder]))
    inside = {name: file for name, file in known.items() if name.startswith(f"{root}.")}

    def room(name: str) -> str:
        return name.removeprefix(f"{root}.").split(".")[0]

    graph: dict[str, set[str]] = {}
    for name, file in inside.items():
        rooms = {room(used) for used in used_modules(file, known) if used in inside}
        graph.setdefault(room(name), set()).update(rooms)
    check_order(graph)


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
