"""Rigs in Mitsuba, as its own emitters sample them."""

import sys

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.export.rigs import AXES, MIXED, POINTS, environment, relative, rigs
from tests.helpers import NORMALS

pytest.importorskip("mitsuba")

from envlights.scene.renderer import mitsuba

RIGS = {
    **rigs(MIXED),
    "points": rigs(POINTS)["constant"],
    "ambient": rigs(POINTS[:0])["constant"],
}
BALL = '<scene version="3.0.0"><include filename="{}"/><shape type="sphere"/></scene>'


def irradiance_in(scene, mi, normals=NORMALS, samples=16384):
    """Irradiance at `normals` from directions that Mitsuba picks on an even grid."""
    place = mi.SurfaceInteraction3f()
    seen = [
        scene.sample_emitter_direction(place, mi.Point2f(*each), False)
        for each in kernels.hammersley(samples)
    ]
    towards = np.array([list(sample.d) for sample, _ in seen])
    strength = np.array([list(colour) for _, colour in seen])
    towards, strength = (each[strength.any(axis=1)] for each in (towards, strength))
    return np.maximum(normals @ towards.T, 0) @ strength / samples


def irradiance_of(emitters):
    with mitsuba() as mi:
        ball = {"type": "sphere"}
        scene = mi.load_dict({"type": "scene", "ball": ball, **emitters}, optimize=False)
        return irradiance_in(scene, mi)


def irradiance_of_file(path):
    with mitsuba() as mi:
        (path.parent / "ball.xml").write_text(BALL.format(path.name))
        return irradiance_in(mi.load_file(str(path.parent / "ball.xml")), mi)


@pytest.mark.parametrize("name", RIGS)
def test_emitters_light_as_the_rig_does(name):
    assert relative(irradiance_of(el.export.mitsuba(RIGS[name])), RIGS[name].probe(NORMALS)) < 1e-3


@pytest.mark.parametrize("name", RIGS)
def test_a_file_lights_as_the_rig_does(name, tmp_path):
    RIGS[name].save(tmp_path / "scene.xml")
    seen = irradiance_of_file(tmp_path / "scene.xml")
    assert relative(seen, RIGS[name].probe(NORMALS)) < 1e-3


def test_a_map_stands_in_place_of_the_ambient_term(tmp_path):
    env, rig = environment(), RIGS["constant"]
    rig.save(tmp_path / "scene.xml", environment=env)
    wanted = env.probe(NORMALS) + rig.lights.discs().to_map(512).probe(NORMALS)
    assert relative(irradiance_of_file(tmp_path / "scene.xml"), wanted) < 1e-3
    assert relative(irradiance_of(el.export.mitsuba(rig.lights, env)), wanted) < 1e-3
    assert {path.name for path in tmp_path.iterdir()} == {
        "ball.xml",
        "scene.ambient.mitsuba.exr",
        "scene.xml",
    }


def test_a_border_sampled_map_is_understood():
    radiance = environment().radiance
    env = el.EnvMap(radiance, registration="border-sampled")
    seen = irradiance_of(el.export.mitsuba(el.Lights(np.zeros((0, 3)), np.zeros((0, 3))), env))
    assert relative(seen, env.probe(NORMALS)) < 1e-3


@pytest.mark.parametrize("radius", [0.0, 0.05])
def test_lights_on_the_axes_arrive_where_they_should(radius):
    lights = el.Lights(AXES.direction, AXES.irradiance, [radius] * 3)
    seen = irradiance_of(el.export.mitsuba(lights))
    np.testing.assert_allclose(seen, 3 * np.maximum(NORMALS, 0), atol=0.045)


def test_lights_alone_have_no_environment():
    assert set(el.export.mitsuba(AXES)) == {"light_0", "light_1", "light_2"}


def test_without_mitsuba_a_file_is_written_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mitsuba", None)
    RIGS["constant"].save(tmp_path / "scene.xml")
    assert (tmp_path / "scene.xml").exists()
    with pytest.raises(el.EnvLightsError, match=r"pip install 'envlights\[bake\]'"):
        el.export.mitsuba(RIGS["constant"])


def test_a_texture_that_cannot_be_written_leaves_no_scene(tmp_path):
    (tmp_path / "scene.ambient.mitsuba.exr").mkdir()
    with pytest.raises(el.EnvLightsError, match="it is a folder"):
        RIGS["constant"].save(tmp_path / "scene.xml")
    assert not (tmp_path / "scene.xml").exists()
