"""Sentences that a user meets first: wrong arguments, a missing extra, a picture for `export`."""

import os
import subprocess
import sys

import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.colors import to_rgb

import envlights as el
from envlights.cli import main

GREY = np.full((16, 32, 3), 0.5, np.float32)


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: el.fit(GREY, light=3), r"fit\(\) .* 'light' \(did you mean lights=\?\)"),
        (lambda: el.fit(GREY, max_lights=3), r"fit\(\) .* \(did you mean lights=\?\)"),
        (lambda: el.detect(GREY, light=3), r"detect\(\) .* \(did you mean lights=\?\)"),
        (lambda: el.split(GREY, max_light=3), r"split\(\) .* \(did you mean max_lights=\?\)"),
        (lambda: el.split(GREY, lamps=3), r"split\(\) .* 'lamps'; it has env, lights, fraction"),
        (lambda: el.follow([GREY], light=3), r"follow\(\) .* \(did you mean lights=\?\)"),
        (lambda: el.compare(GREY, GREY, protocoll=3), r"compare\(\) .*mean protocol=\?"),
        (lambda: el.detect_photograph(GREY, fovv=3), r"detect_photograph\(\) .*mean fov=\?"),
        (lambda: el.error_curve(GREY, light=3), r"error_curve\(\) .*mean lights=\?"),
        (lambda: el.limit(GREY, maximun=3), r"limit\(\) .*mean maximum=\?"),
        (lambda: el.batches.label_arrays([], light=3), r"label_arrays\(\) .*mean lights=\?"),
        (lambda: el.view(GREY, rigs=3), r"view\(\) .*mean rig=\?"),
    ],
)
def test_a_wrong_keyword_names_the_function_and_the_right_argument(call, words):
    with pytest.raises(TypeError, match=words):
        call()


def test_a_wrong_option_of_a_batch_names_the_right_one():
    with pytest.raises(el.EnvLightsError, match=r"split refuses .*did you mean max_lights=\?"):
        el.batch([GREY], what="split", max_light=3)


@pytest.mark.parametrize("missing", ["PIL", "PIL.Image"])
def test_a_page_without_pillow_says_which_extra(missing, monkeypatch):
    monkeypatch.setitem(sys.modules, missing, None)
    monkeypatch.setitem(sys.modules, "PIL", None)
    for call in (lambda: el.view(GREY, title="x"), lambda: el.view(GREY, el.fit(GREY, 0))):
        with pytest.raises(el.EnvLightsError, match=r"needs Pillow .*'envlights\[models\]'"):
            call()


@pytest.mark.parametrize("name", ["map.exr", "map.hdr", "MAP.JPG", "map.png"])
@pytest.mark.parametrize("target", ["blender", "out.usda"])
def test_export_of_a_picture_names_fit(name, target, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / name).write_bytes(b"")
    done = CliRunner().invoke(main, ["export", name, target])
    assert done.exit_code == 1
    assert done.output == (
        f"envlights: {name} is a picture, not a rig: `envlights fit` or `el.fit` makes a rig of it,"
        " which can then be exported\n"
    )


def test_the_legend_of_cards_is_seen_on_a_white_page():
    """A point is white, as is the page, so its line has a dark edge."""
    image = np.full((64, 128, 3), 0.05, np.float32)
    image[20, 30], image[30:36, 60:80] = 500, 9
    cards = el.split(image, shapes=True).cards
    assert set(cards.shape) == {"rectangle", "point"}
    (axes,) = el.plot.cards(image, cards).axes
    lines = [*axes.get_legend().get_lines(), *axes.get_lines()]
    assert len(lines) == 4
    for line in lines:
        (edge,) = line.get_path_effects()
        assert max(to_rgb(edge._gc["foreground"])) < 0.3
        assert edge._gc["linewidth"] > line.get_linewidth()


def test_arrays_are_read_only_and_copies_are_not():
    env = el.EnvMap(GREY)
    for array in (env.radiance, el.fit(env, 1).lights.direction, el.detect(env).irradiance):
        assert not array.flags.writeable
        assert array.copy().flags.writeable


def run(code, **environment):
    return subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, **environment},
        check=False,
    )


def test_work_without_a_standard_error_output():
    """Windowed programs have None in its place."""
    code = """
import sys
sys.stderr = None
import numpy as np, envlights as el
grey = np.full((16, 32, 3), 0.5, "f4")
print(len(el.batch([grey], lights=1, jobs=1)), len(el.follow([grey], 1).sequence()))
"""
    assert run(code).stdout == "1 1\n"


@pytest.mark.parametrize(
    "arguments",
    [
        ["detect", "m.exr", "--set", "threshold=" + "[" * 100000],
        ["batch", "m.exr", "-o", "b", "--set", "lights=" + "[" * 100000],
        ["fit", "m.exr", "-o", "p.png"],
        ["detect", "m.exr", "-o", "p.svg"],
    ],
)
def test_the_command_line_has_no_traceback(arguments, tmp_path):
    el.EnvMap(GREY).save(tmp_path / "m.exr")
    code = f"import os; os.chdir({str(tmp_path)!r}); from envlights.cli import main; main()"
    command = [sys.executable, "-c", code, *arguments]
    environment = {**os.environ, "MPLBACKEND": "nope"}
    done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
    assert "Traceback" not in done.stderr
    assert done.stderr.startswith("envlights: ")
    assert done.returncode == 2


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="needs /dev/full")  # noqa: PTH110
@pytest.mark.parametrize("arguments", [["--help"], ["fit", "--help"], ["--version"]])
def test_a_help_that_cannot_be_printed_is_one_sentence(arguments):
    with open("/dev/full", "w") as full:  # noqa: PTH123
        done = subprocess.run(
            [sys.executable, "-m", "envlights", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            text=True,
            check=False,
        )
    assert done.stderr == "envlights: cannot print the answer: No space left on device\n"
    assert done.returncode == 1
