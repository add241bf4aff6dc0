"""Arguments that all pictures share: axes of the caller, sizes, grounds, styles, fonts."""

import inspect
import io
from functools import cache

import matplotlib
import matplotlib.pyplot as plt
import numpy as np
import pytest
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text

import envlights as el
from envlights import plot
from tests.helpers import pairs_of_room

HALL = el.EnvMap(el.synthetic.hall(32).radiance)


@cache
def rig():
    return el.fit(HALL, lights=2, floor=True)


@cache
def room():
    pairs = pairs_of_room(24, 16)
    return el.TransferModel.fit(pairs.direct, pairs.indirect, rank=6), pairs


@cache
def in_cards():
    return el.split(HALL, shapes=True)


def clipped():
    lamp = el.synthetic.Disc((1, 0.5, 0), 20.0, (9, 9, 9))
    made = el.synthetic.scene(64, background=[0.1] * 3, shapes=[lamp])
    env = el.EnvMap(np.minimum(made.radiance, 1), clip_level=1.0)
    return env, el.detect(env)


def night():
    image = np.full((60, 80, 3), 0.01)
    image[20:24, 30:50] = 1.0
    return image


def noon():
    return el.sun.Sun("sun", direction=[0.6, 0.8, 0], irradiance=[4, 4, 4])


def overlay():
    three = el.Lights([[0.6, 0.8, 0], [-0.6, 0.8, 0], [0, 0.8, 0.6]], [[3] * 3, [2] * 3, [1] * 3])
    sky = el.Rig([1, 1, 1], three, error=0.0, floor=True)
    return el.scene.shadow_overlay(sky, el.scene.Ball((0, 0.5, 0), 0.5), columns=48)


def frame(pairs):
    return pairs.direct[0], pairs.indirect[0]


#: Each public picture with its data and options, and its number of panels.
PICTURES = {
    "loghin_picture": (lambda: ((HALL,), {}), 4),
    "axes_picture": (lambda: ((), {}), len(el.export.AXES) - 1),
    "basis_picture": (lambda: ((room()[0],), {"directions": 4}), 4),
    "card_balls": (lambda: ((HALL, in_cards()), {}), 3),
    "card_textures": (lambda: ((in_cards().cards[:2],), {}), 2),
    "cards": (lambda: ((HALL, in_cards().cards), {}), 1),
    "detection_picture": (lambda: ((HALL, el.detect(HALL)), {}), 1),
    "error_curve": (lambda: ((el.error_curve(HALL, [1, 2]),), {}), 1),
    "error_picture": (lambda: ((rig(),), {}), 1),
    "map_picture": (lambda: ((HALL,), {"stops": True}), 1),
    "overlay_picture": (lambda: ((overlay(),), {}), 10),
    "photograph": (lambda: ((night(),), {"fov": 60}), 1),
    "picture": (lambda: ((HALL, rig()), {}), 4),
    "plateau_picture": (lambda: (clipped(), {}), 2),
    "probes": (lambda: ((HALL, rig(), rig()), {}), 3),
    "rigs_picture": (lambda: ((HALL, rig(), rig()), {}), 8),
    "room_picture": (lambda: (frame(room()[1]), {}), 3),
    "scene": (lambda: ((HALL, rig(), rig()), {"renderer": "closed form", "width": 24}), 2),
    "spectrum_picture": (lambda: ((room()[0],), {}), 1),
    "sphere_picture": (lambda: ((HALL, rig().lights), {}), 2),
    "split_picture": (lambda: ((HALL, el.split(HALL)), {}), 3),
    "sun": (lambda: ((HALL, noon()), {}), 3),
    "transfer_picture": (lambda: ((room()[0], *frame(room()[1])), {}), 5),
}
SHARED = ["ax", "figsize", "dpi", "transparent"]


@pytest.fixture(autouse=True)
def no_figure_of_other_tests():
    """Figures of pyplot that a page of the documentation left open are not ours."""
    plt.close("all")


every_picture = pytest.mark.parametrize("name", PICTURES)


@cache
def data_of(name):
    return PICTURES[name][0]()


def draw(name, **shared):
    data, options = data_of(name)
    return getattr(plot, name)(*data, **options, **shared)


def pixels_of(figure, **options):
    file = io.BytesIO()
    figure.savefig(file, format="png", **options)
    return imread(io.BytesIO(file.getvalue()))


def visible_texts(figure):
    figure.draw_without_rendering()
    return [text for text in figure.findobj(Text) if text.get_text() and text.get_visible()]


def test_the_table_holds_every_picture():
    assert set(PICTURES) == set(plot.__all__) - {"Picture", "save"}


@every_picture
def test_all_pictures_share_the_last_arguments(name):
    parameters = inspect.signature(getattr(plot, name)).parameters
    named = [each.name for each in parameters.values() if each.kind is each.KEYWORD_ONLY]
    assert named[-4:] == SHARED
    assert all(parameters[each].default is None for each in SHARED)


@every_picture
def test_a_picture_is_drawn_in_axes_of_the_caller_and_makes_no_figure(name, monkeypatch):
    panels = PICTURES[name][1]
    figure = Figure(layout="constrained")
    part, other = figure.subfigures(1, 2)
    axes = part.subplots(1, panels)
    beside = other.subplots()
    monkeypatch.setattr(plot.Picture, "__init__", lambda *_, **__: pytest.fail("a new figure"))
    assert draw(name, ax=axes) is figure
    assert all(each.has_data() or each.texts for each in np.ravel(axes))
    assert not beside.has_data()
    assert figure.get_suptitle() == part.get_suptitle() == ""
    # Colour bars alone come in addition.
    assert len(figure.axes) - panels - 1 <= 1
    assert not plt.get_fignums()


@every_picture
def test_size_and_resolution_are_those_of_the_file(name, tmp_path):
    figure = draw(name, figsize=(9, 8), dpi=40)
    assert tuple(figure.get_size_inches()) == (9, 8)
    plot.save(figure, tmp_path / "picture.png")
    assert imread(tmp_path / "picture.png").shape[:2] == (320, 360)
    plot.save(figure, tmp_path / "picture.png", dpi=20)
    assert imread(tmp_path / "picture.png").shape[:2] == (160, 180)


@every_picture
def test_the_ground_is_white_or_clear(name):
    assert to_rgb(draw(name).get_facecolor()) == (1, 1, 1)
    pixels = pixels_of(draw(name, transparent=True), dpi=30)
    assert pixels[0, 0, 3] == 0
    assert pixels[..., 3].max() == 1


@every_picture
def test_texts_of_a_dark_style_stay_visible_when_the_style_is_over(name):
    with plt.style.context("dark_background"):
        figure = draw(name)
    assert to_rgb(figure.get_facecolor()) == (0, 0, 0)
    on_page = [text for text in visible_texts(figure) if not text.get_path_effects()]
    assert on_page
    assert all(max(to_rgb(text.get_color())) > 0.5 for text in on_page)


@every_picture
def test_fonts_grow_with_those_of_the_style(name):
    sizes = []
    for size in (6, 12):
        with matplotlib.rc_context({"font.size": size}):
            sizes.append([text.get_fontsize() for text in visible_texts(draw(name))])
    assert max(sizes[1]) == pytest.approx(2 * max(sizes[0]))
    assert min(sizes[1]) == pytest.approx(2 * min(sizes[0]))


@every_picture
def test_nothing_global_changes(name):
    matplotlib.get_backend()  # is chosen by its first use
    before = matplotlib.rcParams.copy()
    draw(name, dpi=30)._repr_png_()
    assert matplotlib.rcParams == before
    assert not plt.get_fignums()


@pytest.mark.parametrize("write", ["save", "savefig", "save on axes of the caller"])
def test_a_pdf_holds_fonts_of_type_42(write, tmp_path):
    path = tmp_path / "map.pdf"
    if write == "savefig":
        plot.map_picture(HALL).savefig(path)
    elif write == "save":
        plot.save(plot.map_picture(HALL), path)
    else:
        figure = Figure()
        plot.map_picture(HALL, ax=figure.subplots())
        plot.save(figure, path)
    written = path.read_bytes()
    assert b"/FontFile2" in written
    assert b"/Type3" not in written


@every_picture
@pytest.mark.parametrize(
    ("page", "told"),
    [
        ({"ax": 7}, "ax must hold axes of Matplotlib; got int"),
        ({"ax": []}, r"ax must hold .* axes.*; got 0"),
        ({"figsize": 3}, r"figsize must be \(width, height\) in inches; got 3"),
        ({"figsize": (3, 0)}, "a side of figsize must be a finite number, from 0.5 to 100; got 0"),
        ({"figsize": (3, float("nan"))}, "a side of figsize must be .*; got nan"),
        ({"dpi": 0}, "dpi must be a finite number, from 10 to 2400; got 0"),
        ({"figsize": (90, 90), "dpi": 2000}, "reduce figsize or dpi"),
        ({"transparent": 1}, "transparent must be True or False; got 1"),
    ],
)
def test_a_bad_page_is_refused(name, page, told):
    with pytest.raises(el.EnvLightsError, match=told):
        draw(name, **page)


def test_axes_of_the_caller_have_their_own_size():
    axes = Figure().subplots()
    with pytest.raises(el.EnvLightsError, match="figsize is for a new figure; with ax"):
        plot.map_picture(HALL, ax=axes, figsize=(3, 2))
    with pytest.raises(el.EnvLightsError, match="ax must hold 4 axes, one for each panel; got 1"):
        plot.picture(HALL, rig(), ax=axes)
    with pytest.raises(el.EnvLightsError, match="axes of one figure; got those of several"):
        plot.sphere_picture(HALL, rig().lights, ax=[axes, Figure().subplots()])
