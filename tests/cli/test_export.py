"""`envlights export`, and -o with every suffix."""

import json

import pytest
from click.testing import CliRunner

import envlights as el
from envlights import io
from envlights.cli import main
from envlights.export import TARGETS

WITHOUT_EXTRA = [s for target in TARGETS for s in target.suffixes if s != ".usdc"]


def run(*arguments):
    return CliRunner().invoke(main, [str(each) for each in arguments])


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A map, a rig, lights and detected lights."""
    folder = tmp_path_factory.mktemp("export")
    radiance = el.synthetic.hall(64).radiance
    io.write_exr(folder / "hall.exr", radiance)
    rig = el.fit(radiance, lights=2)
    rig.save(folder / "rig.json")
    rig.save(folder / "rig.csv")
    rig.lights.save(folder / "lights.json")
    rig.lights.save(folder / "lights.csv")
    el.detect(radiance).save(folder / "found.json")
    return folder


@pytest.mark.parametrize("name", ["rig.json", "rig.csv", "lights.json", "lights.csv", "found.json"])
def test_all_files_of_lights_can_be_exported(folder, tmp_path, name):
    result = run("export", folder / name, tmp_path / "a.usda", tmp_path / "a.gltf")
    assert result.exit_code == 0, result.output
    warning, *written = result.stderr.splitlines()
    assert warning.startswith("warning: glTF 2.0 shows lights as points: ")
    assert written == [f"wrote {tmp_path / 'a.usda'}", f"wrote {tmp_path / 'a.gltf'}"]
    assert (tmp_path / "a.usda").read_text().count("DistantLight") >= 2


@pytest.mark.parametrize("suffix", WITHOUT_EXTRA)
def test_every_suffix_is_written_by_export_fit_and_detect(folder, tmp_path, suffix):
    outputs = [tmp_path / f"{name}{suffix}" for name in ("export", "fit", "detect")]
    for result in (
        run("export", folder / "rig.json", outputs[0]),
        run("fit", folder / "hall.exr", "-n", 1, "-o", outputs[1]),
        run("detect", folder / "hall.exr", "-o", outputs[2]),
    ):
        assert result.exit_code == 0, result.output
    assert all(output.stat().st_size > 0 for output in outputs)


def test_a_name_is_written_beside_the_rig(folder, tmp_path):
    (tmp_path / "rig.json").write_text((folder / "rig.json").read_text())
    result = run("export", tmp_path / "rig.json", "usd", "unity", "gltf")
    assert result.exit_code == 0, result.output
    names = {path.name for path in tmp_path.iterdir()}
    assert {"rig.usda", "rig.unity.json", "rig.gltf"} <= names


def test_a_map_in_place_of_the_ambient_term(folder, tmp_path):
    options = ("--environment", folder / "hall.exr")
    result = run("export", folder / "rig.json", tmp_path / "a.usda", *options)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "a.ambient.exr").exists()
    refused = run("export", folder / "rig.json", tmp_path / "a.csv", *options)
    assert refused.exit_code == 2
    assert "accepts no environment map" in refused.stderr


def test_strict_refuses_a_file_that_would_lose_the_sizes(folder, tmp_path):
    result = run("export", folder / "rig.json", tmp_path / "a.gltf", "--strict")
    assert result.exit_code == 1
    assert "--strict refuses a file: glTF 2.0 shows lights as points" in result.stderr
    assert list(tmp_path.iterdir()) == []


def test_fit_makes_points_for_a_program_without_sizes(folder, tmp_path):
    result = run("fit", folder / "hall.exr", "-n", 2, "-o", tmp_path / "a.gltf", "--strict")
    assert result.exit_code == 0, result.output
    assert result.stderr == f"wrote {tmp_path / 'a.gltf'}\n"
    assert "fitted for gltf" in result.output
    assert "radius" not in result.output


@pytest.mark.parametrize(
    ("outputs", "options", "target"),
    [
        (["a.json", "a.csv"], [], []),
        (["a.json", "a.gltf", "a.usda"], ["--one-rig"], ["gltf", "usd"]),
        (["a.gltf"], ["--target", "three"], ["three"]),
    ],
)
def test_fit_takes_its_targets_from_the_files_or_by_name(
    folder, tmp_path, outputs, options, target
):
    files = [argument for name in outputs for argument in ("-o", tmp_path / name)]
    result = run("fit", folder / "hall.exr", "-n", 2, "--json", *files, *options)
    assert result.exit_code == 0, result.output
    report = json.loads(result.stdout)["report"]
    assert report["target"] == target


@pytest.mark.parametrize("rig", ["", ".", "/", "..", "\x1b[31m.json"])
@pytest.mark.parametrize("target", ["usd", "out.usda", "", ".", "/"])
def test_what_names_no_file_is_refused_in_a_sentence(tmp_path, monkeypatch, rig, target):
    monkeypatch.chdir(tmp_path)
    result = run("export", rig, target)
    assert isinstance(result.exception, SystemExit)
    assert (result.exit_code, result.stderr.count("\n")) in ((1, 1), (2, 1))
    assert "\x1b" not in result.stderr


@pytest.mark.parametrize("content", ['{"format": [1]}', '{"format": {}}', "[]", "3", "null"])
def test_a_file_of_another_kind_is_refused_in_a_sentence(tmp_path, content):
    (tmp_path / "rig.json").write_text(content)
    result = run("export", tmp_path / "rig.json", tmp_path / "out.usda")
    assert (result.exit_code, result.stderr.count("\n")) == (1, 1)
    assert "is not a rig: it does not say 'format'" in result.stderr


def test_the_help_lists_what_each_target_shows():
    text = " ".join(run("export", "-h").output.split())
    for target in TARGETS:
        assert f"{target.name}: {target.title} ({', '.join(target.suffixes)})" in text
        assert " ".join(target.lines()) in text


@pytest.mark.parametrize(
    ("source", "target", "sentence"),
    [
        ("none.json", "a.usda", "cannot read"),
        ("hall.exr", "a.usda", "`envlights fit` or `el.fit` makes a rig of it"),
        ("rig.json", "a.yaml", "the suffix must be one of .json, .csv"),
        ("rig.json", ".usda", "the suffix must be one of .json, .csv"),
        ("rig.json", "none/a.usda", "does not exist"),
    ],
)
def test_what_cannot_be_exported_is_refused_in_one_sentence(
    folder, tmp_path, source, target, sentence
):
    result = run("export", folder / source, tmp_path / target)
    assert result.exit_code == (2 if "suffix" in sentence else 1)
    assert sentence in result.stderr
    assert result.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_name_that_is_no_target_is_told_those_that_are(folder):
    result = run("export", folder / "rig.json", "nosuch")
    assert result.exit_code == 2
    assert f"a target ({', '.join(target.name for target in TARGETS)})" in result.stderr


def test_the_rig_itself_is_not_overwritten(folder):
    result = run("export", folder / "rig.json", "json")
    assert result.exit_code == 2
    assert "it is the rig; give another name" in result.stderr


def test_split_names_the_maps_that_scenes_bring(folder, tmp_path):
    outputs = [tmp_path / name for name in ("rest.exr", "sun.py", "sun.xml", "split.png")]
    result = run("split", folder / "hall.exr", *(word for path in outputs for word in ("-o", path)))
    assert result.exit_code == 0, result.output
    texture = tmp_path / "sun.ambient.mitsuba.exr"
    wanted = [*outputs[:3], texture, outputs[3]]
    assert result.stderr.splitlines() == [f"wrote {path}" for path in wanted]
    assert sorted(tmp_path.iterdir()) == sorted(wanted)
    assert "MAP = 'rest.exr'" in outputs[1].read_text()


def test_split_does_not_overwrite_its_map_with_the_map_of_a_scene(folder, tmp_path):
    source = tmp_path / "sun.ambient.exr"
    source.write_bytes((folder / "hall.exr").read_bytes())
    result = run("split", source, "-o", tmp_path / "sun.py")
    assert result.exit_code == 2
    assert "it is the map; give another name" in result.stderr
    assert list(tmp_path.iterdir()) == [source]
    assert source.read_bytes() == (folder / "hall.exr").read_bytes()


def test_the_up_axis_is_that_of_files_for_openusd_alone(folder, tmp_path):
    scene = tmp_path / "a.usda"
    for arguments in (
        ("export", folder / "rig.json", scene),
        ("fit", folder / "hall.exr", "-n", 1, "-o", scene, "-o", tmp_path / "a.json"),
        ("detect", folder / "hall.exr", "-o", scene),
        ("split", folder / "hall.exr", "-n", 1, "-o", scene),
    ):
        result = run(*arguments, "--up", "z", "--metres-per-unit", 0.01)
        assert result.exit_code == 0, result.output
        assert 'upAxis = "Z"' in scene.read_text()
        assert "metersPerUnit = 0.01" in scene.read_text()
        scene.unlink()
    result = run("export", folder / "rig.json", tmp_path / "a.gltf", "--up", "z")
    assert result.exit_code == 2
    assert "--up changes nothing for glTF 2.0; it is an option of OpenUSD" in result.stderr


def test_each_of_several_files_has_the_best_fit_for_its_program(folder, tmp_path):
    env = el.EnvMap.open(folder / "hall.exr")
    files = [tmp_path / name for name in ("a.three.json", "b.gltf", "c.usda", "d.py", "e.json")]
    outputs = [word for file in files for word in ("-o", file)]
    result = run("fit", folder / "hall.exr", "-n", 3, *outputs, "--json", "--strict")
    assert result.exit_code == 0, result.output
    rigs = json.loads(result.stdout)
    for file, target in zip(
        files, ("three", "gltf", ("blender", "usd"), ("blender", "usd"), None), strict=True
    ):
        wanted = el.fit(env, 3, target=target).to_dict()
        assert rigs[str(file)] == wanted
    assert rigs[str(files[0])]["error"] < rigs[str(files[1])]["error"]
    # The files hold these rigs.
    scene = json.loads(files[0].read_text())["object"]["children"]
    assert [each["type"] for each in scene][-1] == "LightProbe"
    assert el.Rig.load(files[4]).error == rigs[str(files[4])]["error"]


def test_one_rig_is_that_of_what_all_programs_show(folder, tmp_path):
    outputs = "-o", tmp_path / "a.three.json", "-o", tmp_path / "b.gltf"
    result = run("fit", folder / "hall.exr", "-n", 3, *outputs, "--one-rig", "--json")
    env = el.EnvMap.open(folder / "hall.exr")
    assert json.loads(result.stdout) == el.fit(env, 3, target=("gltf", "three")).to_dict()
    named = run("fit", folder / "hall.exr", "-n", 3, *outputs, "--target", "gltf", "--json")
    assert json.loads(named.stdout)["report"]["target"] == ["gltf"]
    text = run("fit", folder / "hall.exr", "-n", 3, *outputs).stdout
    assert text.count("relative RMS error") == 2
    assert text.startswith(f"{tmp_path / 'a.three.json'}:\n")


def test_a_file_of_ours_joins_the_only_program(folder, tmp_path):
    outputs = "-o", tmp_path / "a.gltf", "-o", tmp_path / "a.json"
    result = run("fit", folder / "hall.exr", "-n", 3, *outputs, "--json")
    assert json.loads(result.stdout)["report"]["target"] == ["gltf"]
