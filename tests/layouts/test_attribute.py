"""Pictures that we save open again without arguments, in the layout in which they were saved."""

import contextlib
import json
import math

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import envlights as el
from envlights.environment.decoders.description import LAYOUT
from envlights.environment.files.hints import Hints
from envlights.environment.files.image_output import write_exr
from envlights.environment.layouts import Layout, recognise
from envlights.environment.layouts import picture_layout as layouts
from envlights.environment.layouts.attribute import line_of
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.faces import ARRANGEMENTS
from envlights.environment.layouts.projections import ARGUMENTS
from envlights.environment.picture_files import read_picture
from tests.layouts.worlds import smooth

ENV = el.EnvMap(smooth(np.moveaxis(np.mgrid[-1:1:64j, -1:1:128j, 1:1:1j][..., 0], 0, -1)) / 8)
#: Relative and absolute error of a sample in each format: 9 bits with a common exponent, 16 bits.
ERRORS = {".exr": (0, 0), ".tif": (0, 0), ".hdr": (0.01, 0.005), ".png": (1e-4, 1e-4)}
REQUESTS = {
    "panorama": ("equirectangular", {}),
    "opengl": ("cube", {"faces": "opengl"}),
    "openexr": ("cube", {"faces": "openexr"}),
    "border": ("cube", {"faces": "directxtex", "registration": "border-sampled"}),
    "octahedral": ("octahedral", {}),
    "turned": ("octahedral", {"forward": [0.3, -0.4, 0.1]}),
    "pbrt": ("octahedral-equal-area", {}),
    "probe": ("angular", {}),
    "turned probe": ("angular", {"forward": [1, 0.2, 0.3]}),
    "ball": ("mirror-ball", {}),
    "half": ("fisheye", {"mapping": "equisolid", "fov": 180}),
    "narrow": ("fisheye", {"mapping": "orthographic", "fov": 133.7, "forward": [0, 1, 0]}),
    "whole": ("fisheye", {"mapping": "equisolid", "fov": 360}),
    "cylinder": ("cylinder", {"fov": 200}),
    "photograph": ("planar", {"fov": 71.123456789, "forward": [-1, -0.2, 0.3]}),
}


def save(folder, suffix, projection, options, arrangement="stack"):
    picture = ENV.to(Layout(projection, **options), width=24)
    (file,) = picture.save(folder / f"a{suffix}", arrangement=arrangement)
    return picture, file


@pytest.mark.parametrize("suffix", ERRORS)
@pytest.mark.parametrize("name", REQUESTS)
def test_a_saved_picture_opens_in_its_layout(tmp_path, name, suffix):
    picture, file = save(tmp_path, suffix, *REQUESTS[name])
    env = el.EnvMap.open(file)
    assert env.source.layout == picture.layout
    assert env.source.recognised_by == "attribute"
    assert env.source.faces == picture.faces
    relative, absolute = ERRORS[suffix]
    image = read_picture(file)
    arranged = recognise(image.pixels, image.hints)
    np.testing.assert_allclose(image.pixels, picture.array, rtol=relative, atol=absolute)
    # The pixels that are seen show the world that was saved.
    assert arranged.layout == picture.layout
    seen = np.ones(env.radiance.shape[:2]) if env.coverage is None else env.coverage
    inside = seen > 0.999
    truth = ENV.resized(env.width).radiance
    assert np.median(np.abs(env.radiance - truth)[inside]) < 0.1 * np.median(truth)


@pytest.mark.parametrize("order", sorted(CONVENTIONS))
@pytest.mark.parametrize("arrangement", ARRANGEMENTS)
@pytest.mark.parametrize("suffix", [".hdr", ".tif"])
def test_every_arrangement_of_a_cube_opens_again(tmp_path, order, arrangement, suffix):
    picture, file = save(tmp_path, suffix, "cube", {"faces": order}, arrangement)
    env = el.EnvMap.open(file)
    assert env.source.layout == picture.layout
    assert env.source.faces == (arrangement if arrangement in CROSSES else order)


@given(
    st.sampled_from(["equidistant", "equisolid", "stereographic", "orthographic"]),
    st.floats(1, 180),
    st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda v: math.hypot(*v) > 1e-3),
    st.none() | st.tuples(st.floats(0, 30), st.floats(0, 30), st.floats(1, 30)),
)
@settings(max_examples=150, suppress_health_check=[HealthCheck.too_slow], deadline=None)
def test_the_statement_of_a_fisheye_keeps_its_layout(mapping, fov, towards, circle):
    made = layouts.fisheye(
        (20, 30), mapping, math.radians(fov), circle=circle, axes=layouts.looking(towards)
    )
    again = layout_of(line_of(made, (20, 30)), np.ones((20, 30, 3)))
    assert again.reach == pytest.approx(made.reach, rel=1e-15)
    assert again._replace(reach=0) == made._replace(reach=0)


@pytest.mark.parametrize("axes", [layouts.FRONT, layouts.UP, layouts.PBRT, layouts.MIRRORED])
def test_the_statement_keeps_any_axes(axes):
    for made in (
        layouts.octahedral(24, axes=axes),
        layouts.octahedral(24, equal_area=True, axes=axes),
        layouts.angular_map(24, axes=axes),
        layouts.planar(24, 24, field_of_view=1.0, axes=axes),
        layouts.fisheye(24, "equisolid", 2 * math.pi, axes=axes),
    ):
        again = layout_of(line_of(made, (24, 24)), np.ones((24, 24, 3)))
        assert again._replace(field_of_view=1.0) == made._replace(field_of_view=1.0)


@given(st.floats(1, 178), st.floats(-50, 50) | st.none(), st.sampled_from(["planar", "cylinder"]))
@settings(max_examples=100, deadline=None)
def test_the_statement_of_a_photograph_or_cylinder_keeps_its_layout(fov, horizon, kind):
    if kind == "planar":
        made = layouts.planar(20, 30, field_of_view=math.radians(fov))
    else:
        made = layouts.cylinder(20, 30, field_of_view=math.radians(fov), horizon=horizon)
    arranged = layout_of(line_of(made, (20, 30)), np.ones((20, 30, 3)))
    assert arranged.field_of_view == pytest.approx(made.field_of_view, rel=1e-15)
    assert arranged._replace(field_of_view=0) == made._replace(field_of_view=0)


def layout_of(line, picture, **arguments):
    """Layout that a statement gives a picture."""
    hints = Hints(layout=line[0].removeprefix(LAYOUT))
    return recognise(picture, hints, Layout(**arguments)).layout


def test_a_picture_that_was_resized_in_proportion_opens(tmp_path):
    made = layouts.fisheye((20, 30), "equidistant", 2.0, circle=(14.0, 9.0, 8.0))
    half = layout_of(line_of(made, (20, 30)), np.ones((10, 15, 3)))
    assert half == made._replace(height=10, width=15, circle=(7.0, 4.5, 4.0))
    made = layouts.cylinder(20, 30, field_of_view=2.0, horizon=3.0)
    assert layout_of(line_of(made, (20, 30)), np.ones((40, 60, 3))).horizon == 6.0
    # Other programs keep the description.
    picture, file = save(tmp_path, ".exr", "octahedral", {})
    small = oiio.ImageBufAlgo.resize(oiio.ImageBuf(str(file)), roi=oiio.ROI(0, 12, 0, 12))
    assert small.write(str(tmp_path / "small.exr"))
    env = el.EnvMap.open(tmp_path / "small.exr")
    assert env.source.layout == picture.layout._replace(height=12, width=12)
    assert oiio.ImageBuf(str(file)).write(str(tmp_path / "a.jpg"))
    assert el.EnvMap.open(tmp_path / "a.jpg").source.layout == picture.layout


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda each: st.lists(each, max_size=3) | st.dictionaries(st.text(max_size=5), each),
    max_leaves=9,
)
PARTS = {
    "version": st.just(1) | JSON,
    "projection": st.sampled_from(sorted({name for name, _ in REQUESTS.values()})) | JSON,
    "size": st.just([24, 24]) | JSON,
}
ENTRIES = dict.fromkeys((*ARGUMENTS[1:], "axes"), JSON)


@given(st.fixed_dictionaries(PARTS, optional=ENTRIES))
@settings(max_examples=300, deadline=None)
def test_any_statement_gives_a_layout_or_a_refusal(data):
    line = (LAYOUT + json.dumps(data),)
    with contextlib.suppress(el.EnvLightsError):
        assert layout_of(line, np.ones((24, 24, 3))).width <= 24


def test_arguments_of_the_user_go_before_the_statement(tmp_path):
    _, file = save(tmp_path, ".exr", "octahedral", {})
    env = el.EnvMap.open(file, layout="angular")
    assert env.source[:1] + env.source[4:5] == ("angular", "argument")
    fisheye = el.EnvMap.open(file, layout=el.io.Layout.fisheye(mapping="equidistant", fov=180))
    assert fisheye.source.projection == "fisheye"
    # A single argument replaces that of the statement.
    turned = el.EnvMap.open(file, layout=el.io.Layout(forward=[1, 0, 0]))
    assert turned.source.layout.axes == layouts.looking([1, 0, 0])
    assert turned.source.projection == "octahedral"
    with pytest.raises(el.EnvLightsError, match="circle is no argument of an octahedral map"):
        el.EnvMap.open(file, layout=el.io.Layout(circle=[1, 2, 3]))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda text: text[:-2], "is no JSON"),
        (lambda text: "[1]", "names no projection"),
        (lambda text: text.replace("octahedral", "mars"), "projection must be 'equirectangular'"),
        (lambda text: text.replace('"version": 1', '"version": 2'), "of another version"),
        (lambda text: text.replace('"size"', '"sizes"'), "unknown entries"),
        (lambda text: text.replace("[24, 24]", "[24, 25]"), "was cropped or stretched"),
        (lambda text: text.replace("[24, 24]", "[0, 0]"), "was cropped or stretched"),
        (lambda text: text.replace("[24, 24]", "24"), "of another type"),
        (lambda text: text.replace("[24, 24]", "[24, null]"), "of another type"),
        (lambda text: text.replace("}", ', "fov": "wide"}'), "fov must be a finite number"),
        (lambda text: text.replace("}", ', "fov": 90}'), "fov is no argument"),
        (lambda text: text.replace("}", ', "axes": [[0, 0, 1]]}'), "axes must be three"),
        (lambda text: text.replace("}", ', "axes": "up"}'), "axes must"),
        (lambda text: text.replace("}", ', "circle": [1, 2]}'), "circle"),
    ],
)
def test_a_damaged_statement_is_refused_with_the_way_out(tmp_path, change, words):
    (line,) = line_of(layouts.octahedral(24, axes=layouts.UP), (24, 24))
    text = change(line.removeprefix(LAYOUT))
    write_exr(tmp_path / "a.exr", np.ones((24, 24, 3), np.float32), comments=(LAYOUT + text,))
    with pytest.raises(el.EnvLightsError, match=words) as refusal:
        el.EnvMap.open(tmp_path / "a.exr")
    assert "a.exr" in str(refusal.value)
    with pytest.raises(el.EnvLightsError, match=words):
        el.fit(tmp_path / "a.exr")
    assert el.EnvMap.open(tmp_path / "a.exr", layout="octahedral").width == 42


def test_a_statement_is_short_and_readable():
    made = layouts.fisheye((20, 30), "equisolid", math.radians(133.7))
    (line,) = line_of(made, (20, 30))
    assert json.loads(line.removeprefix(LAYOUT)) == {
        "version": 1,
        "projection": "fisheye",
        "mapping": "equisolid",
        "fov": 133.7,
        "size": [20, 30],
    }
    part = layouts.crop(20, 30, field_of_view=2.0)
    assert line_of(part, (20, 30)) == ()


def test_other_readers_know_that_it_is_no_panorama(tmp_path):
    _, file = save(tmp_path, ".png", "octahedral", {})
    with pytest.raises(el.EnvLightsError, match="its metadata name the projection octahedral"):
        el.io.read_image(file)


def test_a_png_file_holds_radiance_up_to_1(tmp_path):
    with pytest.raises(el.EnvLightsError, match=r"its largest sample is 3, above the 1 of PNG"):
        el.EnvMap(np.full((4, 8, 3), 3.0)).to("cube", width=4).save(tmp_path / "a.png")
    assert not [*tmp_path.iterdir()]
