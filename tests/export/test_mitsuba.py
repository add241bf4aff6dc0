"""Rigs in Mitsuba, as its own emitters sample them."""

import sys
from xml.etree import ElementTree

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.export.rigs import AXES, MIXED, POINTS, environment, relative, rigs
from tests.helpers import NORMALS

pytest.importorskip("mitsuba")

from envlights.scene.mitsuba.renderer import mitsuba

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


def texture_of_file(path):
    """Path of the map in a file, which Mitsuba loads."""
    with mitsuba() as mi:
        mi.load_file(str(path))
    return ElementTree.parse(path).find(".//string[@name='filename']").get("value")


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


def test_six_faces_stand_in_place_of_the_ambient_term(tmp_path):
    faces = [tmp_path / f"{face}.exr" for face in ("px", "nx", "py", "ny", "pz", "nz")]
    for path in faces:
        el.io.write_exr(path, np.full((8, 8, 3), 0.5, np.float32))
    RIGS["constant"].lights[:0].save(tmp_path / "scene.xml", environment=faces)
    np.testing.assert_allclose(irradiance_of_file(tmp_path / "scene.xml"), np.pi / 2, rtol=1e-3)


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
    env = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled"))
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


def test_the_parts_of_a_split_map_light_as_the_map(tmp_path):
    env = el.Rig([0.2, 0.3, 0.5], MIXED[1:], error=0.0).to_map(128)
    el.split(env, 1).save(tmp_path / "scene.xml")
    assert relative(irradiance_of_file(tmp_path / "scene.xml"), env.probe(NORMALS)) < 1e-3


def test_emitters_are_picked_by_the_irradiance_of_the_surface_that_each_lights_most():
    rig = el.Rig([2, 0, 0], el.Lights([[0, 1, 0], [1, 0, 0]], [[0, 3, 4], [0.001, 0, 0]]), 0.0)
    weights = [each["sampling_weight"] for each in el.export.mitsuba(rig).values()]
    mean = (5 + 0.001 + 2 * np.pi) / 3
    np.testing.assert_allclose(weights, [5 / mean, 0.01, 2 * np.pi / mean])


@pytest.mark.parametrize("radius", [0.05, 0.3])
def test_a_lamp_in_a_map_weighs_what_it_weighs_as_a_point(radius):
    lights = el.Lights([[0.48, 0.8, 0.36], [0, 0, 1]], [[3, 2, 1], [1, 1, 1]], [radius, 0])
    weights = [each["sampling_weight"] for each in el.export.mitsuba(lights).values()]
    assert weights[1] / weights[0] == pytest.approx(np.sqrt(14 / 3), rel=0.1)


def test_black_emitters_weigh_the_same():
    rig = el.Rig([0, 0, 0], el.Lights(np.eye(3), np.zeros((3, 3))), 0.0)
    weights = {each["sampling_weight"] for each in el.export.mitsuba(rig).values()}
    assert weights == {1.0}


@pytest.mark.parametrize("name", ["constant", "harmonics"])
def test_files_have_the_weights_of_the_dictionary(name, tmp_path):
    RIGS[name].save(tmp_path / "scene.xml")
    values = ElementTree.parse(tmp_path / "scene.xml").iterfind(".//float[@name='sampling_weight']")
    emitters = el.export.mitsuba(RIGS[name]).values()
    assert [float(each.get("value")) for each in values] == [
        each["sampling_weight"] for each in emitters
    ]


def test_weights_lower_the_noise_of_a_bright_light_among_dim_ones():
    lights = el.Lights(np.eye(3), np.diag([10, 0.5, 0.5]))
    emitters = el.export.mitsuba(el.Rig([0.05] * 3, lights, 0.0))
    equal = {name: {**each, "sampling_weight": 1.0} for name, each in emitters.items()}
    assert variance(emitters) < 0.2 * variance(equal)


def variance(emitters):
    """Variance of the irradiance of a tilted surface from one emitter that Mitsuba picks."""
    normal = np.ones(3) / np.sqrt(3)
    with mitsuba() as mi:
        ball = {"type": "sphere"}
        scene = mi.load_dict({"type": "scene", "ball": ball, **emitters}, optimize=False)
        place = mi.SurfaceInteraction3f()
        picked = [
            scene.sample_emitter_direction(place, mi.Point2f(*each), False)
            for each in kernels.hammersley(4096)
        ]
    values = [max(normal @ list(sample.d), 0) * np.array(list(rgb)) for sample, rgb in picked]
    return np.var(values, axis=0).sum()
