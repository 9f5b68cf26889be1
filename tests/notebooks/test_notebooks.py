"""Every notebook runs from top to bottom, and is stored without outputs."""

from pathlib import Path

import nbformat
import pytest
from nbclient import NotebookClient

ANSWERS = {  # words of what the last cell prints
    "01_a_face_at_a_distance": "rank",
    "02_through_the_camera": "dB from three sensors",
    "03_what_a_network_learns": "shipped, clean",
    "04_does_super_resolution_help": "paired test p =",
    "05_your_own_photographs": "have the right person first",
    "06_what_is_a_score_worth": "this case",
    "07_a_photograph_becomes_a_probe": "the photograph and the picture score",
}
LONG = (
    "04_does_super_resolution_help",
    "06_what_is_a_score_worth",
    "07_a_photograph_becomes_a_probe",
)
NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_stored_without_outputs(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_defines_no_functions(path: Path) -> None:
    source = "".join(cell.source for cell in nbformat.read(path, as_version=4).cells)
    assert "def " not in source


@pytest.mark.filterwarnings("ignore:.*:DeprecationWarning")  # of the kernel's own machinery
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow if path.stem in LONG else (), id=path.stem)
        for path in NOTEBOOKS
    ],
)
def test_notebook_runs(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    last = [cell for cell in notebook.cells if cell.cell_type == "code"][-1]
    assert ANSWERS[path.stem] in "".join(output.get("text", "") for output in last.outputs)
