"""The page as a widget of Jupyter."""

# ruff: noqa: E501, scripts keep their lines
import sys

import numpy as np
import pytest

import envlights as el
from envlights import viewer
from envlights.viewer import widget
from tests.viewer.browser import needs_browser, run

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


#: A page of the widget's module, with a model of Jupyter that holds the traits.
HOST = """<!doctype html><meta charset="utf-8"><style>{style}</style><body><script type="module">
{module}
const traits = {{ data: {data}, exposure: 0, count: 1, sizes: true, off: [], eye: null }}, heard = {{}};
const host = {{ traits, heard, saves: 0, get: (name) => traits[name], set: (name, value) => {{ traits[name] = value; }},
  on: (event, call) => {{ heard[event] = call; }}, off: (event) => {{ delete heard[event]; }}, save_changes: () => {{ host.saves++; }} }};
host.close = await renderWidget({{ model: host, el: document.body }});
window.envlights = host;
</script>"""


@needs_browser
def test_traits_and_controls_of_the_page_follow_each_other(tmp_path):
    shown = el.view(RIG)
    page = tmp_path / "widget.html"
    text = HOST.format(
        style=shown._style(),
        module=shown._script() + viewer.page._compact("widget.js"),
        data=viewer.page._json(shown._content()),
    )
    page.write_text(text, encoding="utf-8")
    script = """() => {
      const { traits, heard } = envlights, find = (what) => document.querySelector(what);
      const { eye } = traits, saves = envlights.saves, exposure = find(".slider input[min='-4']");
      exposure.value = 1.5;
      exposure.dispatchEvent(new Event("input"));
      find(".lamps input").click();
      find("[aria-label='Lights are'] input:not(:checked)").click();
      find("canvas").dispatchEvent(new KeyboardEvent("keydown", { key: "ArrowLeft" }));
      const pushed = { exposure: traits.exposure, off: traits.off, sizes: traits.sizes, eye: traits.eye };
      traits.exposure = -2;
      heard["change:exposure"]();
      const pulled = find(".slider input[min='-4']").value, more = envlights.saves > saves;
      envlights.close();
      return [eye, pushed, pulled, more, Object.keys(heard)];
    }"""
    eye, pushed, pulled, more, heard = run(page, script)["result"]
    assert (pushed["exposure"], pushed["off"], pushed["sizes"]) == (1.5, [0], False)
    assert np.linalg.norm(np.subtract(pushed["eye"], eye)) > 0.1
    assert (float(pulled), more, heard) == (-2, True, [])
    # Python takes what the page sends.
    for name, value in pushed.items():
        setattr(shown.widget, name, value)
        assert np.array_equal(getattr(shown.widget, name), value)


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
