"""Each parameter of a public function is an option of its subcommand, or has a reason not to be."""

import inspect
import json
import re

import click
import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.layouts.projections import ARGUMENTS

OPEN = (el.EnvMap.open, el.EnvMap.calibrated, el.EnvMap.levelled, el.EnvMap.rotated)
#: Functions of each subcommand.
FUNCTIONS = {
    "fit": (el.fit, *OPEN),
    "detect": (el.detect, el.papers.loghin.detect, *OPEN),
    "split": (el.split, el.limit, el.with_sun, el.detect, *OPEN),
    "error-curve": (el.error_curve, *OPEN),
    "follow": (el.follow, *OPEN),
    "batch": (el.batch, *OPEN),
    "convert": (el.EnvMap.to, el.EnvMap.resized, el.EnvMap.limited, el.EnvMap.save, *OPEN),
    "merge": (el.EnvMap.from_exposures,),
    "place": (el.place, *OPEN),
    "relight": OPEN,
    "repair": (el.EnvMap.repaired, *OPEN),
    "compare": (el.compare, el.compare_folders, *OPEN),
    "show": (el.error_curve, *OPEN),
    "view": (el.view, el.viewer.Model.open, *OPEN),
    "photograph": (el.detect_photograph,),
    "export": (el.export.save,),
    "vary": (el.vary,),
    "transfer fit": (el.TransferModel.fit,),
    "transfer apply": (el.TransferModel.predict,),
}
#: Public functions without a subcommand.
WITHOUT = {
    "bake": "it takes a scene of Mitsuba, a Python object",
    "find_sun": "the answer behind --sun, which split and repair print",
    "fit_probe": "it takes arrays of normals and irradiance",
    "read_pairs": "the first step of transfer fit",
    "threads": "the variable RAYON_NUM_THREADS",
}
#: Names of parameters that a subcommand calls otherwise.
OTHER_NAMES = {
    ("*", "path"): "MAP",
    ("*", "env"): "MAP",
    ("*", "progress"): "--quiet",
    ("*", "width"): "--map-width",
    ("*", "up"): "--level",
    ("*", "distance"): "--ball-distance",
    ("*", "reading"): "--colour",
    ("*", "matrix"): "--rotate",
    ("place", "reading"): "--depth-reading",
    ("place", "camera"): "--camera-position",
    ("view", "fill"): "--fill",
    ("batch", "maps"): "MAP",
    ("batch", "out"): "--output",
    ("batch", "options"): "--set",
    ("split", "maximum"): "--limit",
    ("split", "options"): "--set",
    ("convert", "path"): "OUT",
    ("convert", "projection"): "--to",
    ("convert", "maximum"): "--limit",
    ("merge", "pictures"): "GLOB",
    ("photograph", "image"): "PHOTO",
    ("photograph", "settings"): "--set",
    ("detect", "settings"): "--set",
    ("follow", "frames"): "FRAMES",
    ("compare", "truth"): "TRUTH",
    ("compare", "guess"): "GUESS",
    ("view", "source"): "--model",
    ("export", "rig"): "RIG",
    ("export", "path"): "TARGET",
    ("vary", "rigs"): "RIG",
    ("export", "options"): "--up",
    ("transfer fit", "direct"): "FOLDER",
    ("transfer fit", "indirect"): "FOLDER",
    ("transfer apply", "direct"): "DIRECT",
}
#: Parameters without an option.
LEFT_OUT = {
    ("convert", "fill"): "a map in another layout keeps what is not seen",
    ("batch", "fill"): "--set fill=... of the work",
    ("compare", "fill"): "maps are filled as by default",
    ("detect", "fill"): "lights are detected where the map is seen",
    ("relight", "fill"): "lights are drawn where the map is seen",
    ("split", "fill"): "lights are detected where the map is seen",
    ("transfer fit", "virtual"): "an array of images",
    ("transfer fit", "notebook"): "for the display of Jupyter",
    ("transfer apply", "region"): "slices of an array",
}


def command_of(name):
    command = main
    for word in name.split():
        command = command.get_command(click.Context(main), word)
    return command


def parameters_of(function):
    names = [name for name in inspect.signature(function).parameters if name not in ("cls", "self")]
    # A layout is one argument in Python, and an option for each of its arguments.
    return [each for name in names for each in (ARGUMENTS if name == "layout" else [name])]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_each_parameter_is_an_option(name):
    options = {each for parameter in command_of(name).params for each in parameter.opts}
    text = CliRunner().invoke(main, [*name.split(), "--help"], terminal_width=100).stdout
    settings = re.findall(r"as in Python \((.*?)\)\.", text, re.DOTALL)
    by_set = {each.strip() for each in settings[0].split(",")} if settings else set()
    for function in FUNCTIONS[name]:
        for parameter in parameters_of(function):
            if (name, parameter) in LEFT_OUT or parameter in by_set:
                continue
            known = [OTHER_NAMES.get((of, parameter), "") for of in (name, "*")]
            wanted = [f"--{parameter.replace('_', '-')}", *filter(None, known)]
            found = [
                each for each in wanted if each in options or (each[0] != "-" and each in text)
            ]
            assert found, f"{name} has no option for {parameter} of {function.__qualname__}"


def test_each_public_function_has_a_subcommand_or_a_reason():
    functions = {name for name in el.__all__ if inspect.isfunction(getattr(el, name))}
    assert WITHOUT.keys() <= functions
    reached = {function.__name__ for each in FUNCTIONS.values() for function in each}
    assert functions - WITHOUT.keys() <= reached
    assert not reached & WITHOUT.keys()


def test_no_reason_is_left_over():
    for name, parameter in LEFT_OUT:
        assert any(parameter in parameters_of(function) for function in FUNCTIONS[name])
        assert f"--{parameter}" not in command_of(name).params


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "hall.exr"
    el.EnvMap(el.synthetic.hall(64).radiance).save(path)
    return str(path)


def run(*arguments):
    done = CliRunner().invoke(main, [*map(str, arguments)])
    assert done.exit_code == 0, done.output
    return done


def test_fit_starts_from_a_file_and_holds_directions(hall, tmp_path):
    first, rig = tmp_path / "first.json", tmp_path / "rig.json"
    run("fit", hall, "-n", 2, "-o", first)
    run("fit", hall, "--start", first, "--objective", "probe", "-o", rig)
    assert el.Rig.load(rig) == el.fit(hall, start=el.Rig.load(first), objective="probe")
    run("fit", hall, "-n", 2, "--fixed", "0,6,8", "--start", "even", "-o", rig)
    assert el.Rig.load(rig) == el.fit(hall, 2, fixed=[[0, 0.6, 0.8]], start="even")
    run("fit", hall, "-n", 3, "--fixed", first, "-o", rig)
    assert el.Rig.load(rig) == el.fit(hall, 3, fixed=el.Rig.load(first).lights)


def test_the_light_at_a_point_is_that_of_python(hall, tmp_path):
    depth, there, rig = (tmp_path / name for name in ("depth.npy", "there.exr", "rig.json"))
    placed = el.place(hall, room=(8, 4, 6), camera=(4, 1.6, 3))
    room = ["--room", "8,4,6", "--camera-position", "4,1.6,3"]
    printed = run("place", hall, *room, "--point", "1,0.2,-0.5", "-o", there, "-o", rig).stdout
    assert printed.startswith(str(placed))
    assert el.EnvMap.open(there).radiance == pytest.approx(placed.map_at([1, 0.2, -0.5]).radiance)
    assert el.Rig.load(rig) == placed.at([1, 0.2, -0.5])
    np.save(depth, 1 / placed.depth)
    words = ["--depth", depth, "--depth-reading", "inverse", "--scale", 0.5, "--json"]
    (first, *_) = json.loads(run("place", hall, *words).stdout)["lights"]
    assert first["position"] == pytest.approx(2 * placed[0].position, rel=1e-6)
    refused = CliRunner().invoke(main, ["place", hall, *room, "--point", "1,0,0"])
    assert refused.exit_code == 2
    assert "give -o as well" in refused.output


@pytest.mark.filterwarnings("ignore:.* in one colour")
def test_lights_with_positions_are_those_of_python(hall, tmp_path):
    placed = el.place(hall, room=(8, 4, 6))
    for folder in ("one", "two"):
        (tmp_path / folder).mkdir()
    stage = {"up": "z", "metres_per_unit": 0.01, "at": [1, 0.2, -0.5]}
    placed.save(tmp_path / "one/room.usda", tmp_path / "one/rest.exr", **stage)
    outputs = ["-o", tmp_path / "two/room.usda", "-o", tmp_path / "two/rest.exr"]
    words = [
        "--room",
        "8,4,6",
        "--up",
        "z",
        "--metres-per-unit",
        "0.01",
        "--remainder-at",
        "1,0.2,-0.5",
    ]
    run("place", hall, *words, *outputs)
    for path in (tmp_path / "one").iterdir():
        assert path.read_bytes() == (tmp_path / "two" / path.name).read_bytes(), path.name
    no_positions = ["place", hall, "--room", "8,4,6", "-o", str(tmp_path / "rig.json")]
    refused = CliRunner().invoke(main, no_positions)
    assert refused.exit_code == 2
    assert "shows no lights with positions" in refused.output
    for words in (["--point", "1,0,0", "-o", str(tmp_path / "a.usda")], []):
        refused = CliRunner().invoke(
            main, ["place", hall, "--room", "8,4,6", "--remainder-at", "1,0,0", *words]
        )
        assert refused.exit_code == 2
        assert "--remainder-at is a point for lights with positions" in refused.output


def test_the_map_beside_a_scene_of_positions_does_not_replace_the_input(hall, tmp_path):
    own = tmp_path / "room.ambient.exr"
    el.EnvMap.open(hall).save(own)
    words = ["place", str(own), "--room", "8,4,6", "-o", str(tmp_path / "room.usda")]
    refused = CliRunner().invoke(main, words)
    assert refused.exit_code == 2
    assert "it is the map; give another name" in refused.output


def test_settings_reach_the_detection(hall, tmp_path):
    found = tmp_path / "found.json"
    run("detect", hall, "--set", "threshold=8", "--set", "gap_deg=3", "-o", found)
    assert el.detection.DetectedLights.load(found) == el.detect(hall, threshold=8, gap_deg=3)
    parts = tmp_path / "parts.json"
    run("split", hall, "--set", "threshold=8", "-o", parts)
    expected = el.split(hall, threshold=8).lights
    assert el.Lights.load(parts).direction == pytest.approx(expected.direction)


def test_the_curve_of_the_command_line_is_that_of_python(hall, tmp_path):
    names = [tmp_path / f"curve.{suffix}" for suffix in ("csv", "json", "png")]
    outputs = [word for name in names for word in ("-o", name)]
    done = run("error-curve", hall, "-n", "0-1,3", "--points", *outputs)
    curve = el.error_curve(hall, (0, 1, 3), sizes=False)
    assert done.stdout.rstrip() == str(curve)
    assert done.stderr.splitlines() == [f"wrote {name}" for name in names]
    rows = [line.split(",") for line in names[0].read_text().splitlines()]
    assert [[float(cell) for cell in row] for row in rows[1:]] == [
        list(row)
        for row in zip(
            curve.lights,
            curve.used,
            curve.objective,
            curve.probe,
            curve.shadows,
            curve.gloss,
            strict=True,
        )
    ]
    assert rows[0] == list(curve.to_frame().columns)
    assert names[2].stat().st_size > 1000


def test_options_of_the_file_reach_its_reader(hall, tmp_path):
    square = tmp_path / "square.exr"
    el.EnvMap.open(hall).to(el.io.Layout.fisheye(fov=180, mapping="equisolid"), width=64).save(
        square
    )
    wide = tmp_path / "wide.exr"
    words = ["--projection", "fisheye", "--mapping", "equisolid", "--fov", 180, "--circle"]
    words += ["32,32,32", "--forward", "1,0,0", "--map-width", 64, "--channels", "R,G,B"]
    run("convert", square, wide, *words)
    env = el.EnvMap.open(
        square,
        layout=el.io.Layout.fisheye(
            mapping="equisolid", fov=180.0, circle=(32, 32, 32), forward=(1, 0, 0)
        ),
        width=64,
        channels=["R", "G", "B"],
    )
    assert el.EnvMap.open(wide).radiance == pytest.approx(env.radiance)


def test_readings_reach_the_calibration(hall, tmp_path):
    out = tmp_path / "out.exr"
    run("convert", hall, out, "--nits", 500, "--at", "0,0,1", "--patch", 5)
    env = el.EnvMap.open(hall).calibrated(nits=500, at=(0, 0, 1), patch=5)
    assert el.EnvMap.open(out).radiance == pytest.approx(env.radiance)
    assert el.EnvMap.open(out).units == "cd/m2"


def test_the_help_lists_the_options_of_the_file_on_their_own():
    first = CliRunner().invoke(main, ["fit", "--help"]).stdout
    second = CliRunner().invoke(main, ["fit", "--help-map"]).stdout
    assert len(first.splitlines()) <= 60
    assert "--start" in first
    assert "--colour" not in first
    assert "--colour" in second
    assert not re.search(r"^  MAP\b", first, re.MULTILINE)
