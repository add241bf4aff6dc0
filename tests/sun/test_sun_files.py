"""Files of a sun: its size in each program, the sky beside it, and the guess in words."""

import json
import re

import numpy as np
import pytest

import envlights as el
from tests.sun.suns import IRRADIANCE, TOWARDS, clipped, sun_of

SUFFIXES = [suffix for target in el.export.TARGETS for suffix in target.suffixes]
GUESS = "the irradiance is a guess, in two of three maps true times 0.5 to 2"


@pytest.fixture(scope="module")
def parts():
    env, plateau = clipped()
    return el.with_sun(env, sun_of(plateau))


def text_of(parts, folder, suffix):
    """Text of the saved scene."""
    path = folder / f"sun{suffix}"
    assert path in parts.save(path)
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("suffix", [s for s in SUFFIXES if s != ".usdc"])
def test_every_file_calls_the_guess_a_guess(parts, tmp_path, suffix):
    assert GUESS in text_of(parts, tmp_path, suffix)


def test_the_map_beside_it_does_so_too(parts, tmp_path):
    parts.save(tmp_path / "rest.exr", tmp_path / "rest.hdr")
    for name in ("rest.exr", "rest.hdr"):
        assert GUESS.encode() in (tmp_path / name).read_bytes()


@pytest.mark.parametrize(
    ("suffix", "pattern", "value"),
    [
        (".usda", r"DistantLight.*?inputs:angle = ([\d.]+)", 0.53),
        (".py", r"LIGHTS = \[\n.*, ([\d.]+)\),", np.radians(0.53)),
        (".gltf", r'"angular_radius": ([\d.]+)', np.radians(0.265)),
        (".three.json", r'"angular_radius": ([\d.]+)', np.radians(0.265)),
        (".rad", r"source light_0\n0\n0\n4 \S+ \S+ \S+ ([\d.]+)", 0.53),
        (".unity.json", r'"angular_diameter": ([\d.]+)', 0.53),
        (".unreal.json", r'"angular_diameter": ([\d.]+)', 0.53),
        (".tscn", r"light_angular_distance = ([\d.]+)", 0.53),
    ],
)
def test_the_size_is_that_of_the_sun(parts, tmp_path, suffix, pattern, value):
    found = re.search(pattern, text_of(parts, tmp_path, suffix), re.DOTALL)
    assert float(found[1]) == pytest.approx(value, rel=1e-6)


def test_pbrt_has_a_distant_light_and_the_sky_as_a_map(parts, tmp_path):
    text = text_of(parts, tmp_path, ".pbrt")
    assert text.count('LightSource "distant"') == 1
    assert '"string filename" "sun.ambient.pbrt.exr"' in text


def test_the_map_of_mitsuba_holds_the_sun(parts, tmp_path):
    text_of(parts, tmp_path, ".xml")
    radiance = el.io.read_image(tmp_path / "sun.ambient.mitsuba.exr").pixels
    env = el.EnvMap(radiance[:-1] / 2 + radiance[1:] / 2)
    added = env.probe(TOWARDS) - parts.remainder.probe(TOWARDS)
    np.testing.assert_allclose(added, IRRADIANCE, rtol=2e-3)


def test_json_keeps_the_notes_and_csv_the_lights(parts, tmp_path):
    for suffix in (".json", ".csv"):
        text_of(parts, tmp_path, suffix)
    assert el.Lights.load(tmp_path / "sun.json") == parts.lights
    again = el.Lights.load(tmp_path / "sun.csv")
    np.testing.assert_array_equal(again.irradiance, parts.lights.irradiance)
    data = json.loads((tmp_path / "sun.json").read_text())
    assert data["notes"] == list(parts.lights.notes)


def test_lights_without_notes_write_none():
    assert "notes" not in el.Lights([[0, 1, 0]], [[1, 1, 1]]).to_dict()


def test_a_rig_keeps_the_note_of_its_sun(tmp_path):
    env, plateau = clipped()
    rig = el.fit(env, 2, sun=sun_of(plateau))
    rig.save(tmp_path / "rig.json")
    assert el.Rig.load(tmp_path / "rig.json") == rig
    rig.save(tmp_path / "rig.usda")
    assert GUESS in (tmp_path / "rig.usda").read_text(encoding="utf-8")


def test_no_note_breaks_the_syntax_of_a_file(tmp_path):
    note = 'a "note" \\ with -- dashes */ and\na line break'
    lights = el.Lights([[0, 1, 0]], [[1, 1, 1]], notes=note)
    for suffix in (s for s in SUFFIXES if s != ".usdc"):
        path = tmp_path / f"sun{suffix}"
        lights.save(path)
        text = path.read_text(encoding="utf-8")
        assert "with" in text
        if suffix == ".usda":
            assert re.search(r'^    doc = "(?:[^"\\]|\\.)*"$', text, re.MULTILINE)
        if suffix == ".py":
            compile(text, "sun.py", "exec")
        if suffix.endswith(".json") or suffix == ".gltf":
            json.loads(text)
        if suffix.endswith("xml"):
            from xml.etree import ElementTree

            ElementTree.fromstring(text)
    assert el.Lights.load(tmp_path / "sun.csv").direction.shape == (1, 3)


def test_a_result_shows_itself(parts):
    assert "the map around it" in str(parts)
    assert parts._repr_html_().count("guess") >= 2
    with pytest.raises(el.EnvLightsError, match="there is no path"):
        parts.save()


def test_slices_and_turns_keep_the_notes(parts):
    lights = parts.lights
    assert lights[:1].notes == lights.notes
    assert lights.rotated(np.eye(3)).notes == lights.notes
