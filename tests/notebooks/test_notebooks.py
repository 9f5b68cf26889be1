"""Every notebook runs from top to bottom, and is stored without outputs."""

from pathlib import Path

import nbformat
import pytest
from matplotlib import pyplot
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
    "03_what_a_network_learns",
    "04_does_super_resolution_help",
    "05_your_own_photographs",
    "06_what_is_a_score_worth",
    "07_a_photograph_becomes_a_probe",
)
NOTEBOOKS = sorted((Path(__file__).parents[2] / "notebooks").glob("*.ipynb"))


def code_of(path: Path) -> list[str]:
    cells = nbformat.read(path, as_version=4).cells
    return [cell.source for cell in cells if cell.cell_type == "code"]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_is_stored_without_outputs(path: Path) -> None:
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert cells
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_defines_no_functions(path: Path) -> None:
    assert "def " not in "".join(code_of(path))


@pytest.mark.filterwarnings("error:__array__ implementation")  # it wants an array, not a tensor
@pytest.mark.filterwarnings("default")  # of other packages, as a kernel shows them
@pytest.mark.parametrize(
    "path",
    [
        pytest.param(path, marks=pytest.mark.slow if path.stem in LONG else (), id=path.stem)
        for path in NOTEBOOKS
    ],
)
def test_notebook_runs(
    path: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """In this process, where Mitsuba and PyTorch are loaded already: a kernel is another test's."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    with pyplot.rc_context({"backend": "agg"}):
        for number, source in enumerate(code_of(path)):
            capsys.readouterr()
            exec(compile(source, f"{path.name}, cell {number}", "exec"), names)
        pyplot.close("all")
    assert ANSWERS[path.stem] in capsys.readouterr().out


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*:DeprecationWarning")  # of the kernel's own machinery
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook_runs_in_jupyters_kernel(
    path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = nbformat.read(path, as_version=4)
    NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
