"""The notebooks run from their first cell to their last."""

from __future__ import annotations

import pathlib
from importlib import import_module

import pytest
from conftest import REPOSITORY

NOTEBOOKS = sorted((REPOSITORY / "python" / "notebooks").glob("*.ipynb"))


def test_there_are_notebooks() -> None:
    """Otherwise the next test would test nothing."""
    assert [path.stem for path in NOTEBOOKS] == ["cohort", "first_fit", "own_masks"]


@pytest.mark.filterwarnings("default")
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs_and_shows_something(path: pathlib.Path, tmp_path: pathlib.Path) -> None:
    """In a folder that holds the sample recording; it is committed without outputs."""
    pytest.importorskip("ipykernel")
    nbclient, nbformat = import_module("nbclient"), import_module("nbformat")
    notebook = nbformat.read(path, as_version=4)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert all(cell.outputs == [] and cell.execution_count is None for cell in cells)

    (tmp_path / "data").symlink_to(REPOSITORY / "data")
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": tmp_path}}).execute()
    shown = [output for cell in cells for output in cell.outputs]
    assert any("image/png" in output.get("data", {}) for output in shown)
    assert any("<td>thigh</td>" in output.get("data", {}).get("text/html", "") for output in shown)
    assert not [output for output in shown if output.get("name") == "stderr"]
