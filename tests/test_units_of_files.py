"""Units in files: OpenEXR, JSON, CSV, and each target's own."""

import json
import re

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.kernels.image import LUMINANCE

OWN = "the map's own scale"
#: A sun of 100000 lux overhead and a sky of 5000 cd/m2.
SUN, SKY = 1e5, 5e3
NOON = el.Lights([[0, 1, 0]], [[SUN] * 3], units="cd/m2")
RIG = el.Rig([SKY] * 3, NOON, error=0.0)


def write_exr(path, radiance, nits):
    spec = oiio.ImageSpec(radiance.shape[1], radiance.shape[0], radiance.shape[2], oiio.FLOAT)
    spec.attribute("whiteLuminance", nits)
    image = oiio.ImageOutput.create(str(path))
    image.open(str(path), spec)
    image.write_image(radiance)
    image.close()


def test_an_exr_keeps_its_units(tmp_path):
    env = el.EnvMap(np.ones((8, 16, 3))).calibrated(lux=20000)
    env.save(tmp_path / "map.exr")
    found = el.EnvMap.open(tmp_path / "map.exr")
    assert found.units == "cd/m2"
    np.testing.assert_array_equal(found.radiance, env.radiance)
    assert el.fit(tmp_path / "map.exr", 0).units == "cd/m2"
    env.to("cube").save(tmp_path / "cube.exr")
    assert (
        el.EnvMap.open(tmp_path / "cube.exr", layout=el.io.Layout.cube(faces="opengl")).units
        == "cd/m2"
    )
    el.EnvMap(env.radiance).save(tmp_path / "plain.exr")
    assert el.EnvMap.open(tmp_path / "plain.exr").units == OWN
    assert el.fit(tmp_path / "plain.exr", 0).units == OWN


@pytest.mark.parametrize("channels", [1, 3])
def test_the_luminance_of_white_scales_an_exr(channels, tmp_path):
    radiance = np.random.default_rng(1).random((8, 16, channels), np.float32)
    write_exr(tmp_path / "map.exr", radiance, 203.0)
    env = el.EnvMap.open(tmp_path / "map.exr")
    assert env.units == "cd/m2"
    np.testing.assert_allclose(env.radiance, 203 * radiance * np.ones(3), rtol=1e-5)
    assert any("203 cd/m2 (whiteLuminance)" in note for note in env.notes)
    rig, whole = el.fit(tmp_path / "map.exr", 1), el.fit(env, 1)
    assert rig.units == "cd/m2"
    np.testing.assert_allclose(rig.ambient, whole.ambient, rtol=1e-6)


@pytest.mark.parametrize("nits", [0.0, -3.0, np.nan, np.inf])
def test_a_luminance_that_is_none_is_passed_over(nits, tmp_path):
    write_exr(tmp_path / "map.exr", np.ones((8, 16, 3), np.float32), nits)
    env = el.EnvMap.open(tmp_path / "map.exr")
    assert (env.units, env.radiance.max()) == (OWN, 1)


def test_faces_of_two_units_are_refused(tmp_path):
    face = np.ones((4, 4, 3), np.float32)
    for j, name in enumerate(("px", "nx", "py", "ny", "pz", "nz")):
        write_exr(tmp_path / f"sky_{name}.exr", face, 1.0 if j else 0.0)
    with pytest.raises(el.EnvLightsError, match="must have one scale"):
        el.EnvMap.open(str(tmp_path / "sky_{face}.exr"))
    write_exr(tmp_path / "sky_px.exr", face, 1.0)
    assert el.EnvMap.open(str(tmp_path / "sky_{face}.exr")).units == "cd/m2"


@pytest.mark.parametrize("suffix", [".json", ".csv"])
@pytest.mark.parametrize("lights", [NOON, el.Lights(NOON.direction, NOON.irradiance)])
def test_rigs_and_lights_are_read_back_with_their_units(suffix, lights, tmp_path):
    path = tmp_path / f"file{suffix}"
    lights.save(path)
    assert el.Lights.load(path) == lights
    rig = el.Rig([1, 2, 3], lights, error=0.0)
    rig.save(path)
    assert el.Rig.load(path) == rig
    assert lights.units in path.read_text()


@pytest.mark.parametrize("kind", ["rig", "lights", "detected lights"])
def test_files_of_older_versions_have_the_scale_of_the_map(kind, tmp_path):
    path = tmp_path / "file.json"
    detected = el.detect(el.synthetic.hall(32).radiance)
    thing = {"rig": RIG, "lights": NOON, "detected lights": detected}[kind]
    thing.save(path)
    data = json.loads(path.read_text())
    data["version"] -= 1
    for part in (data, data.get("lights", {})):
        part.pop("scale", None)
    path.write_text(json.dumps(data))
    assert type(thing).load(path).units == OWN
    found = {**data, "version": data["version"] + 1}
    (found["lights"] if kind == "rig" else found)["scale"] = "lux"
    path.write_text(json.dumps(found))
    with pytest.raises(el.EnvLightsError, match="units must be"):
        type(thing).load(path)


def gltf(rig):
    light = el.export.gltf(rig)["extensions"]["KHR_lights_punctual"]["lights"][0]
    return light["intensity"], el.export.gltf(rig)["scenes"][0]["extras"]["ambient"][0]


def three(rig):
    light, ambient = el.export.three(rig)["object"]["children"]
    return light["intensity"], ambient["intensity"] / np.pi


def usd(rig):
    text = el.export.usd(rig)
    assert "exposure" not in text
    return tuple(map(float, re.findall(r"inputs:intensity = (\S+)", text)))


def mitsuba(rig):
    emitters = el.export.mitsuba(rig)
    return (
        emitters["light_0"]["irradiance"]["value"][0],
        emitters["ambient"]["radiance"]["value"][0],
    )


def blender(rig):
    text = el.export.blender(rig)
    light = re.search(r"^    \(\[.*?\], \[(.*?),", text, re.M)[1]
    return float(light), float(re.search(r"^AMBIENT = \[(.*?),", text, re.M)[1])


def radiance(rig):
    numbers = [line.split() for line in el.export.radiance(rig).splitlines()]
    light, sky = (
        float(row[1]) for row in numbers if row[:1] in (["3"], ["4"]) and row[1] == row[2] == row[3]
    )
    return (light - sky) * np.pi * np.sin(1e-4) ** 2, sky


def pbrt(rig):
    return tuple(map(float, re.findall(r'"rgb L" \[(\S+)', el.export.pbrt(rig))))


def unity(rig):
    scene = el.export.unity(rig)
    return scene["lights"][0]["lux"], scene["ambient"][0]


def unreal(rig):
    scene = el.export.unreal(rig)
    return scene["lights"][0]["lux"], scene["ambient"][0]


#: Lumens in the unit of each target, from its documentation.
LUMENS = {
    gltf: 1,
    three: 1,
    usd: 1,
    mitsuba: 1,
    blender: 683,
    radiance: 179,
    pbrt: 1,
    unity: 1,
    unreal: 1,
}


@pytest.mark.parametrize("target", LUMENS, ids=lambda target: target.__name__)
def test_noon_has_the_numbers_of_the_target(target):
    np.testing.assert_allclose(target(RIG), np.array([SUN, SKY]) / LUMENS[target], rtol=1e-6)
    own = el.Rig(RIG.ambient, el.Lights(NOON.direction, NOON.irradiance), error=0.0)
    np.testing.assert_allclose(target(own), [SUN, SKY], rtol=1e-6)


@pytest.mark.parametrize("target", el.export.TARGETS, ids=lambda target: target.name)
def test_every_file_names_its_units(target, tmp_path):
    path = tmp_path / f"rig{target.suffixes[0]}"
    RIG.save(path)
    calibrated = path.read_text()
    assert any(unit in calibrated for unit in ("lux", "W/m2", "cd/m2"))
    el.Rig(RIG.ambient, el.Lights(NOON.direction, NOON.irradiance), error=0.0).save(path)
    plain = path.read_text()
    wanted = OWN if target.name == "csv" else "the scale is that of the map"
    assert wanted in plain
    assert "in lux" not in plain.replace("lux, multiply", "")


def test_textures_have_the_units_of_the_target(tmp_path):
    env = el.EnvMap(np.full((8, 16, 3), SKY), units="cd/m2")
    RIG.save(tmp_path / "rig.py", environment=env)
    texture = el.EnvMap.open(tmp_path / "rig.ambient.exr")
    np.testing.assert_allclose(texture.radiance, SKY / 683, rtol=1e-6)
    RIG.save(tmp_path / "rig.usda", environment=env)
    np.testing.assert_array_equal(
        el.EnvMap.open(tmp_path / "rig.ambient.exr").radiance, env.radiance
    )


def test_lights_and_environment_of_two_scales_are_refused(tmp_path):
    env = el.EnvMap(np.ones((8, 16, 3)))
    with pytest.raises(el.EnvLightsError, match="'cd/m2'; got \"the map's own"):
        RIG.save(tmp_path / "rig.usda", environment=env)
    own = el.Lights(NOON.direction, NOON.irradiance)
    with pytest.raises(el.EnvLightsError, match="calibrate both"):
        own.save(tmp_path / "rig.usda", environment=env.calibrated(lux=3))
    RIG.save(tmp_path / "rig.rad", environment=np.full((8, 16, 3), SKY))
    sky = el.io.read_image(tmp_path / "rig.ambient.hdr").pixels
    np.testing.assert_allclose(sky, SKY / 179, rtol=0.01)
    assert not list(tmp_path.glob("*.usda"))


def test_radiance_measures_the_lux_that_were_given(tmp_path, monkeypatch):
    """`rtrace -I` times 179 lm/W on surfaces that face up and sideways."""
    pyradiance = pytest.importorskip("pyradiance")
    monkeypatch.chdir(tmp_path)
    sun = el.synthetic.Disc((0.6, 0.8, 0), 2.0, (900, 900, 900))
    world = el.synthetic.scene(128, background=[0.3, 0.3, 0.3], shapes=[sun])
    rig = el.fit(el.EnvMap(world.radiance).calibrated(lux=64000), 1)
    rig.save("rig.rad")
    octree = tmp_path / "rig.oct"
    octree.write_bytes(pyradiance.oconv("rig.rad"))
    # Our x, y, z are y, z, x there.
    rays = b"0 0 0 0 0 1\n0 0 0 0 1 0\n"
    params = ["-ab", "1", "-ad", "16384", "-as", "0", "-aa", "0", "-lw", "1e-9", "-dj", "0"]
    found = pyradiance.rtrace(rays, octree, header=False, params=params, irradiance=True)
    lux = 179 * np.array([line.split() for line in found.decode().splitlines()], float) @ LUMINANCE
    np.testing.assert_allclose(lux[0], 64000, rtol=0.01)
    np.testing.assert_allclose(lux, rig.probe([[0, 1, 0], [1, 0, 0]]) @ LUMINANCE, rtol=0.01)


@pytest.mark.parametrize(
    ("options", "wanted"),
    [
        (["--lux", "20000"], lambda env: env.calibrated(lux=20000)),
        (["--ev100", "12"], lambda env: env.calibrated(ev100=12)),
    ],
)
def test_the_command_line_calibrates_a_map(options, wanted, tmp_path):
    source, target = tmp_path / "map.exr", tmp_path / "out.exr"
    env = el.EnvMap(np.random.default_rng(2).random((16, 32, 3)))
    env.save(source)
    run = CliRunner().invoke(main, ["convert", str(source), str(target), *options])
    assert run.exit_code == 0, run.output
    assert el.EnvMap.open(target) == wanted(el.EnvMap.open(source))
    run = CliRunner().invoke(main, ["fit", str(source), "-n", "1", *options])
    assert "irradiance in lux" in run.output
