"""Notebooks run from top to bottom, and draw the pictures that are stored in them."""

import base64
import io
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

nbclient = pytest.importorskip("nbclient")
nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")

FOLDER = Path(__file__).parent.parent / "notebooks"
NOTEBOOKS = pytest.mark.parametrize(
    "path", sorted(FOLDER.glob("*.ipynb")), ids=lambda path: path.stem
)


def printed_text(cell):
    return "".join(output.get("text", "") for output in cell.get("outputs", ()))


@NOTEBOOKS
def test_what_is_stored_is_small_and_whole(path):
    """Every cell has run, from the top down; a picture has at most 60 kB, a notebook 400 kB."""
    notebook = nbformat.read(path, as_version=4)
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    assert all(len(picture) <= 60_000 for picture in pictures_in(cells))
    assert path.stat().st_size <= 400_000
    assert any(cell.outputs for cell in cells)
    assert "widgets" not in notebook.metadata
    for output in (each for cell in cells for each in cell.outputs):
        assert output.output_type != "error"
        assert output.get("name") != "stderr"


def pictures_in(cells):
    """Files of all pictures that cells show by themselves, in order."""
    return [
        base64.b64decode(code)
        for cell in cells
        for output in cell.get("outputs", ())
        for kind, code in output.get("data", {}).items()
        if kind.startswith("image/")
    ]


def thumbnail(file):
    """Grey values of a picture in 64x32 pixels, from 0 to 1."""
    picture = Image.open(io.BytesIO(file)).convert("L")
    return np.asarray(picture.resize((64, 32), Image.Resampling.BOX)) / 255


def run_notebook(name):
    """The cells of a notebook, after a run that draws what is stored."""
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, timeout=600).execute()
    assert_stored_pictures_look_like(name, notebook.cells)
    return notebook.cells


def assert_stored_pictures_look_like(name, cells):
    """The stored pictures are those of a new run, but for their size and noise."""
    stored = pictures_in(nbformat.read(FOLDER / f"{name}.ipynb", as_version=4).cells)
    new = pictures_in(cells)
    assert len(stored) == len(new)
    for one, other in zip(stored, new, strict=True):
        difference = np.abs(thumbnail(one) - thumbnail(other))
        assert np.sqrt((difference**2).mean()) < 0.03, (
            f"store the new pictures: python notebooks/store_outputs.py {name}"
        )


@pytest.mark.slow
def test_a_map_becomes_a_rig_and_every_result_shows_itself():
    cells = run_notebook("rig")
    shown = [
        output.data for cell in cells for output in cell.get("outputs", ()) if "data" in output
    ]
    assert sum("text/html" in data for data in shown) == 3
    assert sum("image/png" in data for data in shown) == 4
    assert all("text/plain" in data for data in shown)


@pytest.mark.slow
def test_the_sun_of_a_picture_lights_a_ball_better_than_a_repair_without_it():
    cells = run_notebook("sun")
    told = "".join(map(printed_text, cells))
    picture, repaired, with_sun = (float(each) for each in re.findall(r": ([\d.]+) %", told))
    assert with_sun < repaired < picture
    assert "no sun was added, because the answer is 'no'" in told
    (times,) = re.findall(r"is ([\d.]+) times too bright", told)
    assert float(times) > 2
    assert any("image/png" in o.get("data", {}) for cell in cells for o in cell.get("outputs", ()))


@pytest.mark.slow
def test_a_sequence_becomes_keyframes_of_lights_that_move_as_the_sun_does():
    told = "".join(map(printed_text, run_notebook("follow")))
    error, motion, flicker = (float(each) for each in re.findall(r": ([\d.]+) ", told))
    assert error < 0.5
    assert motion < 1.3
    assert flicker < 0.5
    assert "lights.gltf lights.jsonl lights.py lights.usda" in told


@pytest.mark.slow
def test_the_article_and_the_tree_find_the_windows():
    told = "".join(map(printed_text, run_notebook("article")))
    article, tree = (float(off) for off in re.findall(r"is ([\d.]+) degrees off", told))
    assert tree < 1 < article < 10


@pytest.mark.slow
def test_the_error_on_new_lights_falls_with_more_pairs():
    told = "".join(map(printed_text, run_notebook("transfer")))
    errors = [float(error) for error in re.findall(r"pairs: ([\d.]+) %", told)]
    assert len(errors) == 3
    assert errors == sorted(errors, reverse=True)
    assert errors[-1] < 12


@pytest.mark.slow
def test_each_choice_is_worth_what_the_notebook_says():
    told = "".join(map(printed_text, run_notebook("choice")))
    rates = re.findall(r"precision ([\d.]+) %, recall ([\d.]+) %", told)
    tree, article = ([float(rate) for rate in each] for each in rates)
    assert min(tree) > 90 > max(article)
    sized = re.findall(
        r"^ +\d+ +([\d.]+) % +([\d.]+) % +([\d.]+) % +([\d.]+) %$", told, re.MULTILINE
    )
    assert len(sized) == 4
    for points, with_shadows, discs, with_soft_shadows in sized:
        assert float(discs) < float(points)
        assert float(with_soft_shadows) < float(with_shadows)
    needed = {
        name: int(count) for name, count in re.findall(r"^(\w+): .*? \+ (\d+) light", told, re.M)
    }
    assert needed.pop("auto") == min(needed.values()) < needed["none"]
    timed = re.findall(r"fit \d+ ms, ([\d.]+) %; fit_probe \d+ ms, ([\d.]+) %", told)
    assert len(timed) == 4
    assert all(float(whole) <= float(measured) for whole, measured in timed)


@pytest.mark.slow
def test_mitsuba_agrees_with_a_rig_within_its_noise():
    pytest.importorskip("mitsuba")
    cells = run_notebook("against_mitsuba")
    told = "".join(map(printed_text, cells))
    apart, noise, error = (float(each) for each in re.findall(r"([\d.]+)%", told))
    assert apart < max(1.2 * noise, error)
    assert noise < 2
    assert "image/png" in cells[-1].outputs[-1].data


@pytest.mark.slow
def test_the_courtyard_goes_from_a_map_to_a_lightmap_within_the_stated_error():
    pytest.importorskip("mitsuba")
    cells = run_notebook("courtyard")
    told = "".join(map(printed_text, cells))
    (said,) = re.findall(r"error ([\d.]+)%; stated ([\d.]+)%; noise of the render ([\d.]+)%", told)
    error, stated, noise = map(float, said)
    assert error < stated + noise
    assert pictures_in(cells)
    pairs = re.findall(r"pairs: ([\d.]+)% without, ([\d.]+)% with", told)
    assert len(pairs) == 4
    assert all(float(informed) < float(plain) for plain, informed in pairs)


@pytest.mark.slow
def test_a_window_of_an_interior_is_dimmed():
    pytest.importorskip("mitsuba")
    cells = run_notebook("cards")
    told = "".join(map(printed_text, cells))
    (error,) = re.findall(r"rest and cards: ([\d.]+) %", told)
    (fraction,) = re.findall(r"dimmed: ([\d.]+) %", told)
    assert float(error) < 0.1
    # The brightest of three windows and a wall; nine tenths of its light are gone.
    assert 40 < float(fraction) < 80
    pictures = ["image/png" in o.get("data", {}) for cell in cells for o in cell.get("outputs", ())]
    assert sum(pictures) == 4
    assert "room.card_2.blender.exr" in told
