"""`el.view` without a browser: the text of a page and its data."""

import base64
import html
import io
import json
import re

import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import decode_srgb
from envlights.viewer import data, page
from tests.cli.test_cli import run

RIG = el.fit(el.synthetic.hall(64).radiance, lights=2, floor=True)


@pytest.fixture(scope="module")
def hall():
    return el.view(el.synthetic.hall(64).radiance)


def test_the_code_of_a_page_is_small(hall):
    data = ("map", "irradiance", "rigs")
    drawn = sum(len(json.dumps(hall.data[name], separators=(",", ":"))) for name in data)
    assert len(hall.html) - drawn < 60_000


def test_a_page_holds_rigs_of_one_to_eight_lights(hall):
    names = {
        f"{ambient} {shape}"
        for ambient in ("constant", "harmonics")
        for shape in ("discs", "points")
    }
    assert set(hall.data["rigs"]) == names
    for name, rigs in hall.data["rigs"].items():
        assert len(rigs) == 8
        assert [len(rig["lights"]) <= n for n, rig in enumerate(rigs, 1)] == [True] * 8
        assert all(rig["floor"] == name.startswith("constant") for rig in rigs)


def test_harmonics_are_those_of_the_rig():
    rig = el.fit(el.synthetic.hall(64).radiance, lights=1, ambient="sh2")
    (x, y, z), c = np.array([0.48, 0.6, 0.64]), np.array(data.rig_data(rig)["ambient"])
    terms = [1, y, z, x, x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y]
    lights = el.Rig([0, 0, 0], rig.lights, 0.0).probe([x, y, z])
    np.testing.assert_allclose(np.array(terms) @ c + lights, rig.probe([x, y, z]), rtol=1e-4)


@pytest.mark.parametrize(
    "name", ["</script><script>alert(1)</script>", "<!--<script>", '"&\u2028', "{{DATA}}"]
)
def test_hostile_names_stay_text(name):
    text = el.view(RIG, title=name).html
    assert html.escape(name) in text
    scripts = re.findall(r"<script[^>]*>(.*?)</script>", text, flags=re.S)
    assert len(scripts) == text.count("<script") == 1
    assert "<!--" not in scripts[0]
    (line,) = re.findall(r"const data = (\{.*\});\nwindow", scripts[0])
    assert json.loads(line)["title"] == name


def test_the_picture_of_the_map_has_its_radiance_where_it_is_not_clipped():
    from PIL import Image

    env = el.EnvMap(el.synthetic.hall(256).radiance)
    made = data.picture(env)
    kind, content = re.fullmatch(r"data:image/(\w+);base64,(.*)", made["map"]).groups()
    assert kind == "webp"
    codes = np.asarray(Image.open(io.BytesIO(base64.b64decode(content))))
    found = made["white"] * decode_srgb(codes / 255)
    unclipped = env.radiance.max(axis=2) < made["white"]
    apart = np.abs(found - env.radiance)[unclipped]
    assert np.median(apart) < 0.02 * made["white"]


def test_jpeg_serves_where_webp_is_missing(monkeypatch):
    from PIL import features

    monkeypatch.setattr(features, "check", lambda _: False)
    assert data.picture(el.EnvMap(np.ones((16, 32, 3))))["map"].startswith("data:image/jpeg;")


def test_the_ground_has_the_albedo_that_its_light_says():
    radiance = np.ones((64, 128, 3), np.float32)
    radiance[32:] = [0.1, 0.2, 0.3]
    albedo, notes = data.floor_of(el.EnvMap(radiance))
    np.testing.assert_allclose(albedo, [0.1, 0.2, 0.3], rtol=1e-3)
    assert notes == []
    radiance[32:] = 3
    albedo, notes = data.floor_of(el.EnvMap(radiance))
    assert albedo.tolist() == [0.8] * 3
    assert "not plausible" in notes[0]


def test_a_table_of_irradiance_is_that_of_the_map_or_its_upper_half():
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    upper = env.radiance.copy()
    upper[32:] = 0
    for over_floor, world in ((False, env), (True, el.EnvMap(upper))):
        table = data.irradiance_table(env, 2.0, over_floor)
        width, height = table["size"]
        halves = np.frombuffer(base64.b64decode(table["halves"]), "<f2").reshape(-1, 3)
        found = 2.0 * halves.astype(float)
        normals = el.kernels.pixel_directions(height, width).reshape(-1, 3)
        np.testing.assert_allclose(found, world.probe(normals), rtol=3e-3, atol=5e-3)


def test_a_page_of_a_rig_shows_its_lights_and_says_what_it_lacks(tmp_path):
    shown = el.view(RIG)
    assert shown.data["notes"] == []
    assert [len(rig["lights"]) for rig in shown.data["rigs"]["constant discs"]] == [2]
    other = el.view(np.ones((16, 32, 3)), el.Rig([1, 1, 1], RIG.lights, 0.0))
    assert "without a floor" in other.data["notes"][-1]
    shown.save(tmp_path / "page.html")
    assert (tmp_path / "page.html").read_text(encoding="utf-8") == shown.html
    frame = shown._repr_html_()
    assert html.unescape(re.search('srcdoc="([^"]*)"', frame)[1]) == shown.html


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((RIG, RIG), "two rigs"),
        ((np.ones((16, 32, 3)), 4), "rig must be"),
        (
            (el.Rig([0, 0, 0], el.Lights(np.tile([0, 1, 0], (9, 1)), np.ones((9, 3))), 0.0),),
            "at most 8",
        ),
    ],
)
def test_refusals(arguments, said, tmp_path):
    with pytest.raises(el.EnvLightsError, match=said):
        el.view(*arguments)
    with pytest.raises(el.EnvLightsError, match="fill must be"):
        el.view(RIG, fill="nonsense")
    with pytest.raises(el.EnvLightsError, match="suffix"):
        el.view(RIG).save(tmp_path / "page.txt")


def test_the_command_writes_a_page_of_a_map_and_of_a_rig(tmp_path):
    el.io.write_exr(tmp_path / "hall.exr", el.synthetic.hall(64).radiance)
    RIG.save(tmp_path / "rig.json")
    for arguments in (["hall.exr", "--rig", "rig.json"], ["rig.json"]):
        names = [str(tmp_path / each) if "." in each else each for each in arguments]
        result = run("view", *names, "-o", tmp_path / "page.html")
        assert result.exit_code == 0, result.output
        assert "<title>" in (tmp_path / "page.html").read_text(encoding="utf-8")
    result = run("view", tmp_path / "hall.exr", "-o", tmp_path / "page.png")
    assert (result.exit_code, "suffix" in result.stderr) == (2, True)


def test_the_files_of_a_page_are_files_of_the_package():
    for name in ("light.glsl", "scene.glsl", "scene.js", "view.js", "view.css", "page.html"):
        assert page._text(name)
