"""Notebooks run from top to bottom, and are kept without what they print."""

import re
from pathlib import Path

import pytest

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
pytest.importorskip("mitsuba")

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = pytest.mark.parametrize(
    "path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem
)


def printed(cell):
    return "".join(output.get("text", "") for output in cell.get("outputs", ()))


@NOTEBOOKS
def test_nothing_that_was_printed_is_kept(path):
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    for cell in notebook.cells:
        if cell.cell_type == "code":
            assert (cell.outputs, cell.execution_count) == ([], None), cell.source


def test_the_courtyard_goes_from_a_map_to_a_lightmap_within_the_stated_error():
    notebook = nbformat.read(FOLDER / "courtyard.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=600).execute()
    (said,) = re.findall(
        r"error ([\d.]+)%; stated ([\d.]+)%; noise of the render ([\d.]+)%",
        "".join(map(printed, notebook.cells)),
    )
    error, stated, noise = map(float, said)
    assert error < stated + noise
    assert "image/png" in notebook.cells[-1].outputs[-1].data
