"""The page as a widget of Jupyter."""

import sys

import pytest

import envlights as el
from envlights.viewer import widget

LIGHTS = el.Lights([[0, 1, 0], [0.6, 0.8, 0]], [[2, 2, 1], [1, 1, 1]], [0.1, 0])
RIG = el.Rig([0.2, 0.3, 0.4], LIGHTS, 0.0, floor=True)
NAME = "</script><b>"


def test_without_anywidget_a_page_is_a_frame_and_a_widget_is_refused(monkeypatch):
    formatters = pytest.importorskip("IPython.core.formatters", reason="needs IPython")
    monkeypatch.setattr(widget, "is_available", lambda: False)
    page = el.view(RIG, title=NAME)
    html = formatters.HTMLFormatter()(page)
    assert html.startswith("<iframe")
    assert NAME not in html
    with pytest.raises(el.EnvLightsError, match=r"envlights\[widget\]"):
        page.widget  # noqa: B018


pytest.importorskip("anywidget", reason="needs anywidget")


def test_traits_follow_from_the_rig_and_refuse_what_does_not_exist():
    from traitlets import TraitError

    shown = el.view(RIG).widget
    assert (shown.exposure, shown.count, shown.sizes, shown.off, shown.eye) == (
        0,
        1,
        True,
        [],
        None,
    )
    shown.off = [1]
    shown.eye = (1, 2, 3)
    for name, value in {"exposure": 9, "count": 2, "off": [2], "eye": (1, 2)}.items():
        with pytest.raises(TraitError):
            setattr(shown, name, value)


def test_a_view_has_one_widget():
    page = el.view(RIG)
    assert page.widget is page.widget


@pytest.mark.slow
def test_a_notebook_shows_the_widget():
    nbformat = pytest.importorskip("nbformat", reason="needs nbformat")
    nbclient = pytest.importorskip("nbclient", reason="needs nbclient")
    pytest.importorskip("ipykernel", reason="needs ipykernel")
    cells = [
        "import envlights as el\n"
        "rig = el.Rig([0.2, 0.3, 0.4], el.Lights([[0, 1, 0]], [[2, 2, 1]], [0.1]), 0.0)\n"
        f"page = el.view(rig, title={NAME!r})\npage",
        "page.widget.exposure = 1.5\npage.widget.off = [0]",
    ]
    book = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in cells])
    command = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
    client = nbclient.NotebookClient(book, timeout=120)
    client.create_kernel_manager().kernel_spec.argv = command
    client.execute()
    (output,) = book.cells[0].outputs
    assert output.data["application/vnd.jupyter.widget-view+json"]
    states = book.metadata.widgets["application/vnd.jupyter.widget-state+json"]["state"].values()
    (state,) = (each["state"] for each in states if each["model_name"] == "AnyModel")
    assert (state["exposure"], state["off"]) == (1.5, [0])
    assert state["data"]["title"] == NAME
    assert "export default" in state["_esm"]
