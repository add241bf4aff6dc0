"""Text, tables and equality of results."""

import copy
import importlib
import inspect
import io
import pkgutil
import re
import zlib
from dataclasses import replace
from functools import cache, partial
from html.parser import HTMLParser

import numpy as np
import pytest

import envlights as el
from envlights._common import html
from envlights._common.result import Result
from envlights._common.tables import MOST_ROWS, Table
from envlights._common.words import percent
from envlights.kernels import thumbnails
from tests.helpers import pairs_of_room

room = partial(pairs_of_room, 12, 16)


@cache
def hall():
    return el.EnvMap(el.synthetic.hall(64).radiance)


@cache
def rig():
    return el.fit(hall(), lights=3)


@cache
def detected_lights():
    return el.detect(hall())


@cache
def model():
    return el.TransferModel.fit(room().direct, room().indirect, rank=4)


def many(count):
    """Lights of falling brightness, on a spiral."""
    v = (np.arange(count) + 0.5) / count
    towards = el.kernels.uv_to_direction(np.stack([v * 7 % 1, np.arccos(1 - 2 * v) / np.pi], 1))
    return el.Lights(towards, 0.9 ** np.arange(count)[:, None] * [3.0, 2.0, 1.0])


@cache
def results():
    """One result of each kind, by the name of its class and what is special about it."""
    scene = el.synthetic.plain(0)
    nothing = np.zeros((0, 3))
    return {
        "EnvMap": hall(),
        "Rig": rig(),
        "FitReport": rig().report,
        "Lights": rig().lights,
        "Light": rig().lights[0],
        "Lights, many": many(77),
        "Lights, none": many(0),
        "Lights, black": el.Lights([[0, 1, 0]], [[0, 0, 0]]),
        "DetectedLights": detected_lights(),
        "DetectedLights, none": detected_lights()[:0],
        "DetectedLight": detected_lights()[0],
        "DetectionReport": detected_lights().report,
        "Rig, black": el.fit(np.zeros((8, 16, 3))),
        "Rig, harmonics": el.fit(hall(), lights=1, ambient="sh2"),
        "Rig, article": el.papers.madsen.fit(hall(), lights=2),
        "TransferModel": model(),
        "TransferModel, compressed": model().compressed(),
        "TransferModel, notebook": el.TransferModel.fit(
            room().direct, room().indirect, rank=4, notebook=True
        ),
        "TransferReport": model().report,
        "Learnt": model().learnt,
        "Room": room(),
        "Scene": scene,
        "Score": el.synthetic.evaluate([(scene, nothing, nothing)]),
    }


NAMES = [
    "EnvMap",
    "Rig",
    "FitReport",
    "Lights",
    "Light",
    "Lights, many",
    "Lights, none",
    "Lights, black",
    "DetectedLights",
    "DetectedLights, none",
    "DetectedLight",
    "DetectionReport",
    "Rig, black",
    "Rig, harmonics",
    "Rig, article",
    "TransferModel",
    "TransferModel, compressed",
    "TransferModel, notebook",
    "TransferReport",
    "Learnt",
    "Room",
    "Scene",
    "Score",
]


@pytest.fixture
def result(request):
    return results()[request.param]


EVERY_RESULT = pytest.mark.parametrize("result", NAMES, indirect=True)


class Tags(HTMLParser):
    """Names and attributes of the tags, each closed that must be."""

    def __init__(self):
        super().__init__()
        self.coverage, self.open = [], []

    def handle_starttag(self, tag, attrs):
        self.coverage.append((tag, dict(attrs)))
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def tags_of(html):
    parser = Tags()
    parser.feed(html)
    assert not parser.open
    return parser.coverage


@EVERY_RESULT
def test_a_notebook_shows_every_result_without_scripts_and_in_the_colours_of_its_page(result):
    html = result._repr_html_()
    tags = tags_of(html)
    assert type(result).__name__ in html
    assert {tag for tag, _ in tags} <= {
        *("div", "strong", "span", "img"),
        *("table", "thead", "tbody", "tr", "th", "td"),
    }
    for tag, attributes in tags:
        assert set(attributes) <= {"style", "src", "alt", "width", "height"}
        # The only ground with a colour is a swatch, which shows no text.
        assert tag == "span" or "style" not in attributes
        assert attributes.get("src", "data:image/png;base64,").startswith("data:image/png;base64,")
        assert tag != "img" or attributes["alt"]
    assert len(html) < 150_000
    assert not re.search(r"\bnan\b", html)


@EVERY_RESULT
def test_a_result_is_equal_to_its_copy_and_to_nothing_of_another_kind(result):
    again = copy.deepcopy(result)
    assert again == result
    assert result != repr(result)
    for other in results().values():
        assert (other == result) == (other is result)
    with pytest.raises(TypeError, match="unhashable"):
        hash(result)


def test_times_do_not_count_and_arrays_do():
    assert el.fit(hall(), lights=3) == rig()
    assert replace(rig(), ambient=2 * rig().ambient) != rig()
    assert replace(rig(), notes=("a remark",)) != rig()
    assert replace(rig().report, seconds={"fit": 1.0}) == rig().report
    assert replace(rig().report, steps=rig().report.steps + 1) != rig().report
    turned = el.Lights(detected_lights().direction[:, ::-1], detected_lights().irradiance)
    assert turned != el.Lights(detected_lights().direction, detected_lights().irradiance)


@pytest.mark.parametrize(
    "result", ["Rig", "DetectedLights", "EnvMap", "TransferModel"], indirect=True
)
def test_alone_it_is_shown_in_full_and_in_a_list_as_a_line(result):
    formatters = pytest.importorskip("IPython.core.formatters")
    shown = formatters.PlainTextFormatter()
    assert shown(result) == str(result)
    assert shown([result]) == f"[{result!r}]"
    assert "\n" not in repr(result)


def test_a_split_shows_its_lights_and_the_rest():
    split = el.split(el.synthetic.hard(0, height=128).radiance, lights=1)
    html = split._repr_html_()
    tags_of(html)
    assert html == split.lights._repr_html_() + split.remainder._repr_html_()
    assert html.index("RemovedLights") < html.index("EnvMap")


def test_long_tables_show_a_dozen_rows_and_say_what_the_rest_hold():
    lights = many(77)
    *rows, rest = str(lights).splitlines()
    assert len(rows) == 1 + MOST_ROWS == 13
    left = 100 * lights.luminance[12:].sum() / lights.luminance.sum()
    assert rest == f"65 more lights, {left:.2g} % together"
    assert lights._repr_html_().count("<tr>") == 13
    assert rest in lights._repr_html_()
    assert str(many(13)).splitlines()[-1].startswith("1 more light, ")
    assert "more" not in str(many(12))


def test_columns_are_aligned_and_text_is_escaped():
    table = Table(["n", "share", ""], [["1", "<b>", "one & all"], ["10", "5 %", ""]], "so & so")
    assert str(table).splitlines() == [" n  share", " 1    <b>  one & all", "10    5 %", "so & so"]
    assert "<b>" not in table.html()
    assert "&lt;b&gt;" in table.html()
    assert "<strong>" not in html.block("<strong", "</div>")[20:]


def test_a_png_is_what_an_image_library_reads():
    image = pytest.importorskip("matplotlib.image")
    codes = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    seen = image.imread(io.BytesIO(html.png(codes)))[..., :3]
    np.testing.assert_array_equal(np.round(255 * seen), codes)
    smooth = np.full((120, 240, 3), 17, np.uint8)
    assert len(html.png(smooth)) < 1000 < len(zlib.compress(codes.tobytes())) * 20


def test_lights_are_drawn_where_they_are_in_their_colour():
    lights = el.Lights([[1, 0, 0], [0, 0, 1]], [[4, 0, 0], [0, 0, 1]])
    drawn = thumbnails.of_lights(lights.direction, lights.irradiance, lights.angular_radius)
    assert drawn[58, 60].tolist() == [255, 0, 0]
    assert drawn[58, 120].tolist() == [0, 0, 255]
    assert drawn[30, 200].max() < 90


def test_a_sky_is_not_white_where_a_lamp_shines():
    """A sun over an even sky: the sky keeps its colour, the sun is white."""
    sun = el.synthetic.Disc((0, 0.6, 0.8), 3, (1e4,) * 3)
    world = el.synthetic.scene(64, background=[0.2, 0.3, 0.5], shapes=[sun])
    codes = thumbnails.of_map(world.radiance)
    assert codes.min(axis=(0, 1)).max() < 256
    assert (codes == 255).all(axis=2).mean() < 0.02
    assert codes[0, 0, 0] < codes[0, 0, 2]
    assert not thumbnails.of_map(np.zeros((8, 16, 3))).any()


def test_directions_of_a_basis_are_orthonormal():
    for each in (model(), replace(model())):
        rows = each.directions(3).reshape(3, -1)
        np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-5)
    assert len(model().directions(99)) == 4
    with pytest.raises(el.EnvLightsError, match="most must be a whole number"):
        model().directions(-1)


def test_one_light_holds_a_row_of_each_array():
    for lights in (rig().lights, detected_lights()):
        for row, light in enumerate(lights):
            for name in ("direction", "irradiance", "angular_radius", "fraction"):
                np.testing.assert_array_equal(getattr(light, name), getattr(lights, name)[row])
            np.testing.assert_allclose(light.luminance, lights.luminance[row])
            np.testing.assert_allclose(light.azimuth, lights.azimuth[row])
            np.testing.assert_allclose(light.elevation, lights.elevation[row])
            assert light == lights[row]
            assert light in lights
    assert detected_lights()[-1] == detected_lights()[len(detected_lights()) - 1]
    assert [each.is_clipped for each in detected_lights()] == detected_lights().is_clipped.tolist()
    assert detected_lights()[0].peak_luminance == detected_lights().peak_luminance[0]
    assert detected_lights().fraction is detected_lights().flux_fraction


def test_azimuth_and_elevation_lead_back_to_the_direction():
    lights = many(50)
    azimuth, elevation = lights.azimuth, lights.elevation
    level = np.cos(elevation)
    back = [np.sin(azimuth) * level, np.sin(elevation), -np.cos(azimuth) * level]
    np.testing.assert_allclose(np.transpose(back), lights.direction, atol=1e-12)


def test_indices_beyond_the_lights_and_other_kinds_are_refused():
    lights = many(3)
    for beyond in (3, -4):
        with pytest.raises(IndexError, match=rf"there are 3 lights; got the index {beyond}"):
            lights[beyond]
    for other in ("0", 1.0, None, (0, 1)):
        with pytest.raises(el.EnvLightsError, match=r"a number, as in .* or a list"):
            lights[other]


def test_a_data_frame_has_a_row_for_each_light():
    pytest.importorskip("pandas")
    frame = detected_lights().to_frame()
    assert len(frame) == len(detected_lights())
    np.testing.assert_allclose(np.deg2rad(frame["azimuth_deg"]), detected_lights().azimuth)
    np.testing.assert_allclose(frame[["x", "y", "z"]], detected_lights().direction)
    np.testing.assert_allclose(frame[["red", "green", "blue"]], detected_lights().irradiance)
    assert frame["is_clipped"].tolist() == detected_lights().is_clipped.tolist()
    assert {"fraction", "luminance", "radius_deg"} <= set(many(5).to_frame().columns)
    assert re.fullmatch(r"\d+", str(len(many(0).to_frame())))


def test_without_pandas_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pandas", None)
    with pytest.raises(el.EnvLightsError, match=r"needs pandas: pip install 'envlights\[frame\]'"):
        many(2).to_frame()


def test_lights_are_taken_by_numbers_and_by_masks():
    lights = many(5)
    for chosen in ([0, 3], np.array([0, 3]), np.array([True, False, False, True, False])):
        assert lights[chosen] == el.Lights(lights.direction[[0, 3]], lights.irradiance[[0, 3]])
    assert len(lights[[]]) == 0
    members = detected_lights()[[1]].members
    assert len(members.pixel) + len(members.others) == len(detected_lights().members.pixel)
    with pytest.raises(IndexError):
        lights[[5]]


def classes_of_results(base=Result):
    for each in base.__subclasses__():
        if each.__module__.startswith("envlights.") and not inspect.isabstract(each):
            yield each
        yield from classes_of_results(each)


def test_every_class_of_results_is_frozen_and_has_the_text_and_the_equality_of_results():
    for each in pkgutil.walk_packages(el.__path__, "envlights."):
        # Pictures need Matplotlib, an extra, and hold no results.
        if not each.name.startswith(("envlights.plot.", "envlights.__main__")):
            importlib.import_module(each.name)
    found = set(classes_of_results())
    assert {
        el.Lights,
        el.detection.DetectedLights,
        el.cards.Card,
        el.Rig,
        el.rigs.FitReport,
    } <= found
    for each in found:
        assert each.__repr__ is Result.__repr__, each
        assert each.__eq__ is Result.__eq__, each
        assert each.__hash__ is None, each
        assert each.__dataclass_params__.frozen, each


@pytest.mark.parametrize(
    ("fraction", "digits", "text"),
    [(0.9949, 2, "99 %"), (0.9951, 2, "100 %"), (12.34, 2, "1234 %"), (0.9951, 3, "99.5 %")],
)
def test_numbers_in_percent_have_no_exponent(fraction, digits, text):
    assert percent(fraction, digits) == text
