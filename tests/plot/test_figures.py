"""Figures for publications: exact colours, shared scales, curves of errors, and the gallery."""

import runpy
import subprocess
import sys
from functools import cache
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.text import Text

import envlights as el
from envlights import plot
from envlights.plot.markers import TINTS, number_colours, sizes_for
from tests.reference import srgb

DOCS = Path(__file__).parents[2] / "docs"
HALL = el.EnvMap(el.synthetic.hall(64).radiance)


@cache
def rigs():
    return [el.fit(HALL, lights=n) for n in (1, 4)]


def test_a_ball_under_one_light_has_the_codes_of_the_standard():
    """Under a grey sky and a rig of a quarter of it: 1 is white, 0.25 has the code 0.5371."""
    sky = np.full((256, 512, 3), 2.0)
    none = el.Lights(np.zeros((0, 3)), np.zeros((0, 3)))
    quarter = el.Rig(np.full(3, 0.5), none, error=0.75)
    for axes, code in zip(plot.probes(sky, quarter).axes, (1.0, 0.537099), strict=True):
        colours = axes.images[0].get_array()
        inside = colours[colours[..., 3] == 1]
        np.testing.assert_allclose(inside[:, :3], code, atol=1e-4)


def test_codes_of_a_strip_are_those_of_the_probe_of_the_rig():
    lamp = el.Lights([[0, 1.0, 0]], [[2.0, 1.0, 0.5]])
    rig = el.Rig([0.2, 0.2, 0.2], lamp, error=0.0)
    _, ball = plot.probes(np.ones((16, 32, 3)), rig).axes
    colours = np.asarray(ball.images[0].get_array())
    # At the top row of the ball in full, the normal is close to +y; white is pi.
    row = 4
    up = 1 - 2 * (row + 0.5) / len(colours)
    middle = colours[row, len(colours) // 2, :3]
    # The eye is 5.4 degrees above the horizon: the row holds the normal up * u + towards * eye.
    tilt = np.pi * (0.5 - 0.47)
    normal_y = up * np.cos(tilt) + np.sqrt(1 - up**2) * np.sin(tilt)
    light = (np.pi * 0.2 + np.array([2.0, 1.0, 0.5]) * normal_y) / np.pi
    np.testing.assert_allclose(middle, srgb.encode(light), atol=2e-3)


def test_the_differences_of_rigs_share_one_scale_and_one_bar():
    axes = plot.rigs_picture(HALL, *rigs()).axes
    differences = [each.images[0] for each in axes if each.get_title() == "rig minus map"]
    assert len({id(image.norm) for image in differences}) == 1
    assert len(axes) == 4 * 2 + 1
    low, high = differences[0].get_clim()
    largest = max(np.nanmax(np.abs(image.get_array())) for image in differences)
    assert -low == high == pytest.approx(largest)
    # The rig of four lights is far more accurate, and still visible.
    best = np.nanmax(np.abs(differences[1].get_array()))
    assert best < high / 5
    assert differences[1].norm(best) > 0.6


def test_rims_and_numbers_of_lights_have_one_tint():
    on_map = plot.picture(HALL, rigs()[1]).axes[0]
    sized = rigs()[1].lights.angular_radius > 0
    wanted = [TINTS[k] if is_sized else "white" for k, is_sized in enumerate(sized)]
    assert [text.get_color() for text in on_map.texts] == wanted
    assert len(set(number_colours(np.ones(8)))) == 8


@pytest.mark.parametrize("count", [1, 8, 141])
def test_a_key_names_shares_that_occur_and_draws_them_to_scale(count):
    towards = np.random.default_rng(2).normal(size=(count, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    strength = np.linspace(2, 1, count)[:, None] * np.ones(3)
    rig = el.Rig([0, 0, 0], el.Lights(towards, strength), error=0.5)
    on_map = plot.picture(HALL, rig).axes[0]
    legend = on_map.get_legend()
    texts = [text.get_text() for text in legend.get_texts()]
    keys = [float(text.split()[-2]) / 100 for text in texts if text.endswith("%")]
    assert keys
    assert max(keys) <= max(rig.lights.fraction.max(), 0.001)
    assert max(keys) > rig.lights.fraction.max() / 3
    sizes = sizes_for(on_map, rig.lights.fraction)
    for share, line in zip(keys, legend.get_lines(), strict=False):
        area = np.pi / 4 * line.get_markersize() ** 2
        assert area == pytest.approx(max(sizes.whole * share, sizes.least))


@cache
def curve():
    return el.error_curve(HALL, lights=[2, 1])


def test_a_curve_has_a_line_for_each_error_in_percent_by_number_of_lights():
    (axes,) = plot.error_curve(curve(), errors=["probe", "shadows", "gloss"]).axes
    for line, name in zip(axes.lines, ("probe", "shadows", "gloss"), strict=True):
        values = [100 * value for value in getattr(curve(), name)]
        np.testing.assert_allclose(line.get_xydata(), [[1, values[1]], [2, values[0]]])
    looks = {(line.get_linestyle(), line.get_marker()) for line in axes.lines}
    assert len(looks) == 3


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"errors": "noise"}, "errors must be 'probe' or 'shadows' or 'gloss' or 'objective'"),
        ({"errors": []}, "errors must hold at least one of probe, shadows"),
        ({"errors": 3}, "errors must be text; got 3"),
    ],
)
def test_other_errors_are_refused(given, told):
    with pytest.raises(el.EnvLightsError, match=told):
        plot.error_curve(curve(), **given)
    with pytest.raises(el.EnvLightsError, match="curve must be ErrorCurve; got Rig"):
        plot.error_curve(rigs()[0])


def test_a_scene_has_the_columns_that_were_asked_for():
    image = plot.scene(HALL, rigs()[0], renderer="closed form", width=48).axes[0].images[0]
    assert image.get_array().shape == (32, 48, 3)
    with pytest.raises(el.EnvLightsError, match="width must be a whole number, 24 or more"):
        plot.scene(HALL, rigs()[0], width=8)


def test_the_figure_of_three_panels_fits_a_column(tmp_path):
    """Every panel lies on the page with its words, no font is tiny, no panel covers another."""
    script = runpy.run_path(str(DOCS / "figures/three_panels.py"))
    with mpl.rc_context(script["STYLE"]):
        figure = script["draw"](HALL)
        figure.draw_without_rendering()
    assert tuple(figure.get_size_inches()) == (3.3, 2.0)
    for axes in figure.axes:
        box = axes.get_tightbbox()
        assert box.x0 >= -1
        assert box.y0 >= -1
        assert box.x1 <= figure.bbox.x1 + 1
        assert box.y1 <= figure.bbox.y1 + 1
    texts = [each for each in figure.findobj(Text) if each.get_text() and each.get_visible()]
    assert min(text.get_fontsize() for text in texts) >= 5
    boxes = [axes.get_window_extent() for axes in figure.axes]
    for number, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:number])


WITHOUT = """
import sys
sys.modules["matplotlib"] = None
import envlights as el
{code}
"""


def without_matplotlib(code, folder):
    return subprocess.run(
        [sys.executable, "-c", WITHOUT.format(code=code)],
        capture_output=True,
        text=True,
        cwd=folder,
        check=False,
    )


def test_without_matplotlib_every_picture_names_the_extra(tmp_path):
    code = """
for name in el.plot.__all__:
    try:
        getattr(el.plot, name)
    except el.EnvLightsError as refusal:
        assert f"plot.{name} needs Matplotlib" in str(refusal), refusal
        assert "pip install 'envlights[plot]'" in str(refusal), refusal
    else:
        raise SystemExit(name)
try:
    el.plot.nothing
except AttributeError:
    print("all refused")
"""
    ended = without_matplotlib(code, tmp_path)
    assert ended.stdout == "all refused\n", ended.stderr


def test_without_matplotlib_the_demo_leaves_the_picture_out_and_says_so(tmp_path):
    ended = without_matplotlib("from envlights.cli import main; main(['demo'])", tmp_path)
    assert ended.returncode == 0, ended.stderr
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hall.exr", "hall.json"]
    assert "no picture: it needs Matplotlib" in ended.stderr
    assert "hall.png" not in ended.stderr


def test_without_matplotlib_a_command_refuses_a_picture_before_it_works(tmp_path):
    HALL.save(tmp_path / "hall.exr")
    code = (
        "from envlights.cli import main; main(['fit', 'hall.exr', '-o', 'rig.json', '-o', 'r.png'])"
    )
    ended = without_matplotlib(code, tmp_path)
    assert ended.returncode != 0
    assert "cannot write r.png: a picture needs Matplotlib" in ended.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["hall.exr"]


def test_the_scale_of_differences_names_its_unit_where_there_is_room():
    labels = [
        plot.picture(HALL, rigs()[0], figsize=size).axes[-1].get_ylabel()
        for size in ((10, 8.6), (2, 1.5))
    ]
    assert labels == ["% of the mean", "%"]
