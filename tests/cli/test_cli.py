"""The command line: one subcommand, one public function, one sentence for a refusal."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest
from click.testing import CliRunner
from matplotlib.image import imsave

import envlights as el
from envlights import cli, io
from envlights.cli import main
from tests.helpers import DETECTORS, relative_errors


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


@pytest.fixture(scope="module")
def hall(tmp_path_factory):
    path = tmp_path_factory.mktemp("maps") / "hall.exr"
    io.write_exr(path, el.synthetic.hall(64).radiance)
    return path


def test_python_runs_the_package_as_the_command_line(hall):
    command = [sys.executable, "-m", "envlights", "fit", hall, "-n", "1"]
    result = subprocess.run(command, capture_output=True, text=True, check=True)
    assert "relative RMS error" in result.stdout


def test_fit_prints_a_table_and_writes_rig_and_picture(hall, tmp_path):
    rig, picture = tmp_path / "rig.json", tmp_path / "rig.png"
    result = run("fit", hall, "-n", 3, "-o", rig, "-o", picture)
    assert result.exit_code == 0, result.output
    assert "relative RMS error" in result.stdout
    assert len(el.Rig.load(rig).lights) == 3
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["rig.json", "rig.png"]


def test_fit_takes_ambient_and_error(hall):
    result = run("fit", hall, "--error", 0.05, "--ambient", "sh2", "--json")
    assert result.exit_code == 0, result.output
    rig = json.loads(result.stdout)
    assert len(rig["ambient"]) == 9
    assert rig["error"] <= 0.05


def test_fit_takes_a_floor_and_chooses_the_ambient_term(hall):
    result = run("fit", hall, "-n", 2, "--floor", "--ambient", "auto", "--json")
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)["report"]
    assert "over a floor" in report["measured_on"]
    assert set(report["ambients"]) == {"none", "constant"}
    text = run("fit", hall, "-n", 2, "--ambient", "auto").stdout
    assert "ambient term 'sh2' selected from  none: 2 lights, " in text
    assert "direction tolerance" not in text
    verbose = run("fit", hall, "-n", 2, "--ambient", "auto", "--verbose").stdout
    assert "direction tolerance (10 % more error): " in verbose
    assert verbose.startswith(text.rstrip())
    refused = run("fit", hall, "--floor", "--ambient", "sh2")
    assert refused.exit_code == 2
    assert "where there is a floor" in refused.stderr


def test_fit_takes_sizes_and_an_error_of_shadows(hall):
    discs = json.loads(run("fit", hall, "-n", 2, "--json").stdout)["lights"]
    points = json.loads(run("fit", hall, "-n", 2, "--points", "--json").stdout)["lights"]
    assert min(discs["angular_radius"]) > 0
    assert points["angular_radius"] == [0, 0]
    rig = json.loads(run("fit", hall, "--shadow-error", 0.1, "--json").stdout)
    assert rig["report"]["shadow_error"] <= 0.1


def test_json_is_what_save_writes(hall):
    result = run("fit", hall, "-n", 2, "--json")
    assert result.exit_code == 0
    data = json.loads(result.stdout)
    expected = el.fit(el.EnvMap.open(hall), lights=2).to_dict()
    for name in ("ambient", "lights", "error"):
        assert data[name] == expected[name]


@pytest.mark.slow
def test_the_demo_of_transfer_leads_from_pairs_to_a_predicted_lightmap(tmp_path):
    result = run("demo", "transfer", "-o", tmp_path)
    assert (result.exit_code, result.stdout.splitlines()[0][:21]) == (0, "rank 64 from 64 pairs")
    model = el.TransferModel.load(tmp_path / "room.npz")
    direct, lightmap = (
        el.io.read_image(tmp_path / f"room_{name}.exr").pixels for name in ("direct", "lightmap")
    )
    np.testing.assert_allclose(model.predict(direct), lightmap, atol=1e-6)
    # The files are those of the room itself, whose frame 64 the model has not seen.
    made = el.synthetic.room(65)
    pairs = el.read_pairs(tmp_path / "room")
    np.testing.assert_array_equal(pairs.indirect, made.indirect[:64])
    assert relative_errors(lightmap[None], made.indirect[64:])[0] < 0.1
    assert {"room.png", "room_parts.png"} <= {path.name for path in tmp_path.iterdir()}


def test_demo_writes_map_rig_and_picture(tmp_path):
    result = run("demo", "-o", tmp_path)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in tmp_path.iterdir()) == ["hall.exr", "hall.json", "hall.png"]
    assert el.Rig.load(tmp_path / "hall.json").error < 0.01


@pytest.mark.parametrize("method", ["tree", "loghin"])
def test_detect_prints_and_writes_what_the_function_finds(hall, tmp_path, method):
    outputs = ("-o", tmp_path / "lights.json", "-o", tmp_path / "lights.png")
    result = run("detect", hall, "-n", 2, "--method", method, *outputs)
    assert result.exit_code == 0, result.output
    lights = DETECTORS[method](el.EnvMap.open(hall), lights=2)
    assert result.stdout.startswith(str(lights).split("\n\n")[0])
    assert json.loads((tmp_path / "lights.json").read_text()) == lights.to_dict()
    assert (tmp_path / "lights.png").read_bytes().startswith(b"\x89PNG")
    as_json = run("detect", hall, "-n", 2, "--method", method, "--json")
    assert json.loads(as_json.stdout) == lights.to_dict()


def test_split_prints_and_writes_what_the_function_finds(hall, tmp_path):
    outputs = [tmp_path / name for name in ("lights.json", "rest.exr", "split.png")]
    result = run("split", hall, "-n", 2, *(part for each in outputs for part in ("-o", each)))
    assert result.exit_code == 0, result.output
    lights, rest = el.split(el.EnvMap.open(hall), 2)
    assert result.stdout.startswith(str(lights).split("\n\n")[0])
    assert lights.to_dict().items() <= json.loads(outputs[0].read_text()).items()
    assert el.Lights.load(outputs[0]) == lights.discs()
    np.testing.assert_array_equal(el.EnvMap.open(outputs[1]).radiance, rest.radiance)
    assert outputs[2].read_bytes().startswith(b"\x89PNG")
    as_json = run("split", hall, "-n", 2, "--json")
    assert json.loads(as_json.stdout) == lights.to_dict()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="this system has no full device")
def test_files_are_written_even_where_nothing_can_be_printed(hall, tmp_path):
    command = [sys.executable, "-m", "envlights", "fit", hall, "-n", "1", "-o", tmp_path / "r.json"]
    with Path("/dev/full").open("w") as full:
        result = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True)
    assert len(el.Rig.load(tmp_path / "r.json").lights) == 1
    assert "Traceback" not in result.stderr
    assert "cannot print the answer: No space left on device" in result.stderr


def test_a_black_map_is_answered(tmp_path):
    io.write_exr(tmp_path / "black.exr", np.zeros((16, 32, 3), np.float32))
    result = run("fit", tmp_path / "black.exr", "-o", tmp_path / "black.png")
    assert result.exit_code == 0, result.output
    assert "no directional light" in result.stdout


def test_a_refusal_of_an_output_leaves_the_folder_as_it_was(hall, tmp_path):
    read_only = tmp_path / "kept.json"
    read_only.write_text("kept")
    read_only.chmod(0o444)
    for output, message in ((read_only, "marked read-only"), (tmp_path / "a.yaml", "suffix must")):
        result = run("fit", hall, "-o", output)
        assert message in result.stderr
        assert result.stdout == ""
    assert [path.name for path in tmp_path.iterdir()] == ["kept.json"]
    assert read_only.read_text() == "kept"


def test_the_map_is_never_overwritten_by_its_picture(tmp_path):
    path, link = tmp_path / "map.png", tmp_path / "link.png"
    imsave(path, np.full((8, 16, 3), 0.5))
    before = path.read_bytes()
    link.symlink_to(path)
    for output in (path, link):
        result = run("fit", path, "-o", output)
        assert result.exit_code == 2
        assert "it is the map; give another name" in result.stderr
    assert path.read_bytes() == before


def test_outputs_are_checked_before_the_map_is_read(hall, tmp_path, monkeypatch):
    def read(*_, **__):
        raise AssertionError("the map was read")

    monkeypatch.setattr(el.EnvMap, "open", read)
    for command in ("fit", "detect", "split"):
        for output in (tmp_path / "out.yaml", tmp_path / "none" / "out.json", hall):
            result = run(command, hall, "-o", tmp_path / "good.json", "-o", output)
            assert result.exit_code == (1 if output.parent.name == "none" else 2), result.exception
            assert "cannot write" in result.stderr
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments", [("fit", "-n", 10**9), ("fit", "--error", -1), ("detect", "-n", -1)]
)
def test_a_refusal_leaves_no_file(hall, tmp_path, arguments):
    command, *options = arguments
    outputs = ("-o", tmp_path / "out.json", "-o", tmp_path / "out.png")
    result = run(command, hall, *options, *outputs)
    assert result.exit_code == 2
    assert result.stderr.startswith("envlights: ")
    assert result.stdout == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("command", ["fit", "detect", "split"])
def test_where_drawing_fails_nothing_half_drawn_stays_and_nothing_is_printed(
    hall, tmp_path, monkeypatch, command
):
    def savefig(_, target, **__):
        target.write(b"half")
        raise RuntimeError("the library broke")

    monkeypatch.setattr("matplotlib.figure.Figure.savefig", savefig)
    (tmp_path / "out.png").write_bytes(b"old")
    result = run(command, hall, "-o", tmp_path / "out.json", "-o", tmp_path / "out.png")
    assert "the library broke" in str(result.exception)
    assert result.output == ""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["out.json", "out.png"]
    assert json.loads((tmp_path / "out.json").read_text())
    assert (tmp_path / "out.png").read_bytes() == b"old"


WITHOUT_MATPLOTLIB = """
import sys
sys.modules["matplotlib"] = None
from envlights.cli import main
main(sys.argv[1:])
"""


@pytest.mark.parametrize("command", ["fit", "detect", "split"])
def test_json_is_written_without_the_library_that_draws(hall, tmp_path, command):
    arguments = [command, hall, "-o", tmp_path / "out.json"]
    subprocess.run([sys.executable, "-c", WITHOUT_MATPLOTLIB, *arguments], check=True)
    assert json.loads((tmp_path / "out.json").read_text())


@pytest.mark.parametrize(
    "words", ["fit none.exr -o rig.png", "show none.exr", "error-curve none.exr -o curve.pdf"]
)
def test_a_picture_without_the_library_that_draws_names_the_extra(words):
    command = [sys.executable, "-c", WITHOUT_MATPLOTLIB, *words.split()]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stdout) == (2, "")
    assert "pip install 'envlights[plot]'" in done.stderr


def test_the_help_lists_every_subcommand_and_imports_none():
    context = click.Context(main)
    names = {path.stem for path in Path(cli.__file__).parent.iterdir()}
    listed = {name.replace("_", "-") for name in names if name[0] != "_"}
    listed -= {"options", "demonstration", "examples", "refusal-words"}
    assert set(main.list_commands(context)) == listed
    for name in main.list_commands(context):
        assert main.get_command(context, name).name == name
    code = "import sys\nfrom envlights.cli import main\nmain(['--help'], standalone_mode=False)\n"
    code += "print([name for name in sys.modules if name.startswith('envlights.cli.')])"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert all(name in told.stdout for name in main.list_commands(context))
    options = ["options", "options.quiet", "options.standard_streams"]
    imported = [f"envlights.cli.{name}" for name in ("examples", *options, "refusal_words")]
    assert told.stdout.endswith(f"{imported}\n")


def test_a_pipe_that_nobody_reads_ends_without_a_traceback(hall, tmp_path):
    command = [sys.executable, "-m", "envlights", "fit", hall, "-n", "1", "-o", tmp_path / "r.json"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    process.stdout.close()
    errors = process.stderr.read()
    process.stderr.close()
    assert process.wait() == 1
    assert "Traceback" not in errors
    assert len(el.Rig.load(tmp_path / "r.json").lights) == 1


@pytest.mark.parametrize("name", ["hall.exr", "hall.json", "hall.png"])
def test_the_demo_writes_nothing_where_one_of_its_files_cannot_be(tmp_path, name):
    (tmp_path / name).mkdir()
    result = run("demo", "-o", tmp_path)
    assert result.exit_code == 1
    assert f"{name}: it is a folder" in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == [name]


def test_repair_writes_the_map_with_the_light_that_was_cut_off(tmp_path):
    picture, repaired = tmp_path / "clipped.png", tmp_path / "repaired.exr"
    sky = np.full((64, 128, 3), 0.35)
    sky[12:14, 60:62] = 1.0
    sky[32:] = 0.4
    imsave(picture, sky)
    assert run("repair", picture).exit_code == 2
    result = run("repair", picture, "-o", repaired, "--irradiance", 2)
    assert result.exit_code == 0, result.output
    assert "the flux was raised by a factor of" in result.stdout
    expected = el.EnvMap.open(picture).repaired(irradiance=2.0)
    np.testing.assert_allclose(el.EnvMap.open(repaired).radiance, expected.radiance, rtol=1e-3)
    assert "suffix must be one of .exr, .hdr" in run("repair", picture, "-o", picture).stderr


@pytest.fixture(scope="module")
def street(tmp_path_factory):
    """A photograph of a lamp, of an aspect that no map has."""
    codes = np.full((90, 130, 3), 40, np.uint8)
    codes[30:40, 60:80] = 255
    path = tmp_path_factory.mktemp("photographs") / "street.png"
    imsave(path, codes)
    return path


def test_photograph_prints_places_and_draws_them(street, tmp_path):
    picture = tmp_path / "lights.png"
    result = run("photograph", street, "-o", picture)
    assert result.exit_code == 0, result.output
    assert "threshold 0.8 (relative to the clip level" in result.stdout
    assert "no field of view is known" in result.stdout
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("options", [(), ("--fov", 60), ("--absolute", "--sampling", "hammersley")])
def test_photograph_prints_what_the_function_finds(street, options):
    result = run("photograph", street, "--json", *options)
    assert result.exit_code == 0, result.output
    settings = el.papers.loghin.PHOTOGRAPH
    if "--absolute" in options:
        settings = replace(settings, relative=False, sampling="hammersley")
    wanted = el.detect_photograph(street, 60 if "--fov" in options else None, settings=settings)
    assert json.loads(result.stdout) == json.loads(json.dumps(wanted.to_dict()))


def test_detect_names_the_subcommand_of_photographs(street):
    result = run("detect", street)
    assert result.exit_code == 2
    assert "detect_photograph" in result.stderr
    assert "`envlights photograph`" in result.stderr


def test_detect_takes_a_sampling_of_the_article(hall):
    result = run("detect", hall, "--method", "loghin", "--sampling", "halton", "--json")
    assert result.exit_code == 0, result.output
    settings = el.papers.loghin.Settings(sampling="halton")
    wanted = el.papers.loghin.detect(hall, settings=settings)
    assert json.loads(result.stdout) == json.loads(json.dumps(wanted.to_dict()))
    refused = run("detect", hall, "--sampling", "halton")
    assert refused.exit_code == 2
    assert "--sampling is an option of --method loghin" in refused.stderr


def test_fit_reaches_an_error_on_metal(tmp_path):
    el.EnvMap(el.synthetic.hall(32).radiance).save(tmp_path / "hall.exr")
    options = ["--gloss-error", "0.5", "--roughness", "0.5", "-o", str(tmp_path / "rig.json")]
    done = CliRunner().invoke(main, ["fit", str(tmp_path / "hall.exr"), *options])
    assert done.exit_code == 0, done.output
    assert el.Rig.load(tmp_path / "rig.json").report.gloss_error(0.5) <= 0.5
