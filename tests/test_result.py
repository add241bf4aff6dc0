"""How results show themselves, and when two are equal."""

import copy
import io
import re
import zlib
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest

import envlights as el
from envlights import _html, _thumbnails
from envlights._tables import MOST_ROWS, Table

HALL = el.EnvMap(el.synthetic.hall(64).radiance)
RIG = el.fit(HALL, lights=3)
FOUND = el.detect(HALL)
ROOM = el.synthetic.room(12, width=16)
MODEL = el.TransferModel.fit(ROOM.direct, ROOM.indirect, rank=4)


def many(count):
    """Lights of falling brightness, on a spiral."""
    v = (np.arange(count) + 0.5) / count
    towards = el.kernels.uv_to_direction(np.stack([v * 7 % 1, np.arccos(1 - 2 * v) / np.pi], 1))
    return el.Lights(towards, 0.9 ** np.arange(count)[:, None] * [3.0, 2.0, 1.0])


RESULTS = [
    HALL,
    RIG,
    RIG.report,
    RIG.lights,
    RIG.lights[0],
    many(77),
    many(0),
    el.Lights([[0, 1, 0]], [[0, 0, 0]]),
    FOUND,
    FOUND[:0],
    FOUND[0],
    FOUND.report,
    el.fit(np.zeros((8, 16, 3))),
    el.fit(HALL, lights=1, ambient="sh2"),
    el.fit_paper(HALL, lights=2),
    MODEL,
    MODEL.compressed(),
    el.TransferModel.fit(ROOM.direct, ROOM.indirect, rank=4, notebook=True),
    MODEL.report,
    MODEL.learnt,
    ROOM,
    el.synthetic.plain(0),
    el.synthetic.judge([(el.synthetic.plain(0), np.zeros((0, 3)), np.zeros((0, 3)))]),
]
NAMES = [f"{number}-{type(each).__name__}" for number, each in enumerate(RESULTS)]


class Tags(HTMLParser):
    """Names and attributes of the tags, each closed that must be."""

    def __init__(self):
        super().__init__()
        self.seen, self.open = [], []

    def handle_starttag(self, tag, attrs):
        self.seen.append((tag, dict(attrs)))
        if tag != "img":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


def tags_of(html):
    parser = Tags()
    parser.feed(html)
    assert not parser.open
    return parser.seen


@pytest.mark.parametrize("result", RESULTS, ids=NAMES)
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


@pytest.mark.parametrize("result", RESULTS, ids=NAMES)
def test_a_result_is_equal_to_its_copy_and_to_nothing_of_another_kind(result):
    again = copy.deepcopy(result)
    assert again == result
    assert result != repr(result)
    for other in RESULTS:
        assert (other == result) == (other is result)
    with pytest.raises(TypeError, match="unhashable"):
        hash(result)


def test_times_do_not_count_and_arrays_do():
    assert el.fit(HALL, lights=3) == RIG
    assert replace(RIG, ambient=2 * RIG.ambient) != RIG
    assert replace(RIG, notes=("a remark",)) != RIG
    assert replace(RIG.report, seconds={"fit": 1.0}) == RIG.report
    assert replace(RIG.report, steps=RIG.report.steps + 1) != RIG.report
    turned = el.Lights(FOUND.direction[:, ::-1], FOUND.irradiance)
    assert turned != el.Lights(FOUND.direction, FOUND.irradiance)


@pytest.mark.parametrize("result", [RIG, FOUND, HALL, MODEL], ids=lambda each: type(each).__name__)
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
    assert html == split.lights._repr_html_() + split.rest._repr_html_()
    assert html.index("RemovedLights") < html.index("EnvMap")


def test_long_tables_show_a_dozen_rows_and_say_what_the_rest_hold():
    lights = many(77)
    *rows, rest = str(lights).splitlines()
    assert len(rows) == 1 + MOST_ROWS == 13
    left = 100 * lights.luminance[12:].sum() / lights.luminance.sum()
    assert rest == f"65 more hold {left:.2g} %"
    assert lights._repr_html_().count("<tr>") == 13
    assert rest in lights._repr_html_()
    assert str(many(13)).splitlines()[-1].startswith("1 more holds ")
    assert "more" not in str(many(12))


def test_columns_are_aligned_and_text_is_escaped():
    table = Table(["n", "share", ""], [["1", "<b>", "one & all"], ["10", "5 %", ""]], "so & so")
    assert str(table).splitlines() == [" n  share", " 1    <b>  one & all", "10    5 %", "so & so"]
    assert "<b>" not in table.html()
    assert "&lt;b&gt;" in table.html()
    assert "<strong>" not in _html.block("<strong", "</div>")[20:]


def test_a_png_is_what_an_image_library_reads():
    image = pytest.importorskip("matplotlib.image")
    codes = np.random.default_rng(0).integers(0, 256, (5, 7, 3)).astype(np.uint8)
    seen = image.imread(io.BytesIO(_html.png(codes)))[..., :3]
    np.testing.assert_array_equal(np.round(255 * seen), codes)
    smooth = np.full((120, 240, 3), 17, np.uint8)
    assert len(_html.png(smooth)) < 1000 < len(zlib.compress(codes.tobytes())) * 20


def test_lights_are_drawn_where_they_are_in_their_colour():
    lights = el.Lights([[1, 0, 0], [0, 0, 1]], [[4, 0, 0], [0, 0, 1]])
    drawn = _thumbnails.of_lights(lights.direction, lights.irradiance, lights.angular_radius)
    assert drawn[58, 60].tolist() == [255, 0, 0]
    assert drawn[58, 120].tolist() == [0, 0, 255]
    assert drawn[30, 200].max() < 90


def test_a_sky_is_not_white_where_a_lamp_shines():
    """A sun over an even sky: the sky keeps its colour, the sun is white."""
    sun = el.synthetic.Disc((0, 0.6, 0.8), 3, (1e4,) * 3)
    world = el.synthetic.scene(64, background=[0.2, 0.3, 0.5], shapes=[sun])
    codes = _thumbnails.of_map(world.radiance)
    assert codes.min(axis=(0, 1)).max() < 256
    assert (codes == 255).all(axis=2).mean() < 0.02
    assert codes[0, 0, 0] < codes[0, 0, 2]
    assert not _thumbnails.of_map(np.zeros((8, 16, 3))).any()


def test_directions_of_a_basis_are_orthonormal():
    for model in (MODEL, replace(MODEL)):
        rows = model.directions(3).reshape(3, -1)
        np.testing.assert_allclose(rows @ rows.T, np.eye(3), atol=1e-5)
    assert len(MODEL.directions(99)) == 4
    with pytest.raises(el.EnvLightsError, match="most must be a whole number"):
        MODEL.directions(-1)


def test_one_light_holds_a_row_of_each_array():
    for lights in (RIG.lights, FOUND):
        for row, light in enumerate(lights):
            for name in ("direction", "irradiance", "angular_radius", "share"):
                np.testing.assert_array_equal(getattr(light, name), getattr(lights, name)[row])
            np.testing.assert_allclose(light.luminance, lights.luminance[row])
            np.testing.assert_allclose(light.azimuth, lights.azimuth[row])
            np.testing.assert_allclose(light.elevation, lights.elevation[row])
            assert light == lights[row]
            assert light in lights
    assert FOUND[-1] == FOUND[len(FOUND) - 1]
    assert [each.is_clipped for each in FOUND] == FOUND.is_clipped.tolist()
    assert FOUND[0].peak_luminance == FOUND.peak_luminance[0]
    assert FOUND.share is FOUND.flux_share


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
        with pytest.raises(el.EnvLightsError, match=r"a number, such as .* or a list"):
            lights[other]


def test_a_data_frame_has_a_row_for_each_light():
    pytest.importorskip("pandas")
    frame = FOUND.to_frame()
    assert len(frame) == len(FOUND)
    np.testing.assert_allclose(np.deg2rad(frame["azimuth_deg"]), FOUND.azimuth)
    np.testing.assert_allclose(frame[["x", "y", "z"]], FOUND.direction)
    np.testing.assert_allclose(frame[["red", "green", "blue"]], FOUND.irradiance)
    assert frame["is_clipped"].tolist() == FOUND.is_clipped.tolist()
    assert {"share", "luminance", "radius_deg"} <= set(many(5).to_frame().columns)
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
    members = FOUND[[1]].members
    assert len(members.pixel) + len(members.others) == len(FOUND.members.pixel)
    with pytest.raises(IndexError):
        lights[[5]]
