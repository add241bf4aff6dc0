"""MuJoCo: pixels of its classic renderer, off screen."""

import os
from xml.etree import ElementTree

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from envlights.export.targets import target_named
from tests.export.balls import SIDE, SIDES, SQUARE, normals_of
from tests.export.rigs import AXES as ON_AXES
from tests.export.rigs import DISCS, POINTS, environment, relative, rigs
from tests.helpers import NORMALS

LAMPS = target_named("mujoco").shows.lights
#: One lamp in each direction of a dodecahedron's vertices, more than OpenGL has.
MANY = el.Lights(el.kernels.icosphere(20)[0], np.linspace(3, 0.2, 60).reshape(20, 3))
#: Codes of 255 that a pixel may be off: four passes are rounded to whole codes and added.
WORST = 2.01
# The ball is turned, because narrow triangles at its poles shadow themselves.
MODEL = """<mujoco>
  <include file="{file}"/>
  <statistic extent="4" center="0 0 0"/>
  <visual><quality numslices="256" numstacks="256"/></visual>
  <asset><material name="matte" rgba="{colour}" specular="0" shininess="0"/></asset>
  <worldbody><geom type="sphere" size="1" quat="9 3 2 1" material="matte"/>{more}</worldbody>
</mujoco>"""
CAMERA_OF = '<camera name="{}" pos="{}" xyaxes="{} {}" projection="orthographic" fovy="{}"/>'


@pytest.fixture(scope="module")
def mujoco():
    """MuJoCo with an off-screen renderer."""
    os.environ.setdefault("MUJOCO_GL", "egl")
    module = pytest.importorskip("mujoco", exc_type=ImportError)
    try:
        module.GLContext(8, 8).free()
    except Exception as error:
        pytest.skip(f"needs OpenGL off screen for MuJoCo: {error}")
    return module


def words(values):
    return " ".join(map(str, values))


def camera(name, right, up, width=SQUARE, middle=(0, 0, 0)):
    """Element of a camera that looks at `middle`, all in our frame."""
    there = AXES["mujoco"].to_target([right, up, np.cross(right, up), middle])
    pos = words(there[3] + 15 * there[2])
    return CAMERA_OF.format(name, pos, words(there[0]), words(there[1]), width)


def pictures(mujoco, folder, more="", colour="1 1 1 1"):
    """Picture of each camera in `more`, of a model that includes the rig in `folder`."""
    model = folder / "model.xml"
    if not hasattr(mujoco.MjModel, "cam_projection"):  # of older versions
        more = more.replace('projection="orthographic"', 'orthographic="true"')
    model.write_text(MODEL.format(file="rig.mujoco.xml", more=more, colour=colour))
    compiled = mujoco.MjModel.from_xml_path(str(model))
    data = mujoco.MjData(compiled)
    mujoco.mj_forward(compiled, data)
    with mujoco.Renderer(compiled, SIDE, SIDE) as renderer:
        shown = []
        for number in range(compiled.ncam):
            renderer.update_scene(data, number)
            shown.append(renderer.render().astype(float))
    return shown, float(compiled.numeric("envlights_scale").data[0])


def worst_code(mujoco, folder, irradiance):
    """Largest difference in codes from `irradiance(normals)`, of a white ball from two sides."""
    shown, scale = pictures(mujoco, folder, sides())
    off = []
    for image, side in zip(shown, SIDES, strict=True):
        normals, is_ball = normals_of(side)
        off.append(np.abs(image[is_ball] - 255 * scale * irradiance(normals)).max())
    return max(off)


@pytest.mark.parametrize("axis", range(3))
def test_a_lamp_on_an_axis_lights_the_ball_from_there(mujoco, axis, tmp_path):
    lamp = el.Lights(np.eye(3)[[axis]], [[3, 2, 1]])
    el.export.save_mujoco(lamp, tmp_path / "rig.mujoco.xml")

    def irradiance(normals):
        return np.maximum(normals[:, [axis]], 0) * np.array([3, 2, 1])

    assert worst_code(mujoco, tmp_path, irradiance) < WORST


@pytest.mark.parametrize("name", ["none", "constant"])
def test_the_ball_shows_the_irradiance_of_the_rig(mujoco, name, tmp_path):
    rig = rigs(POINTS)[name]
    el.export.save_mujoco(rig, tmp_path / "rig.mujoco.xml")
    assert worst_code(mujoco, tmp_path, rig.probe) < WORST


def sides():
    """Cameras that together see the whole ball."""
    return "".join(camera(f"side{k}", *side[:2]) for k, side in enumerate(SIDES))


def pictures_of_warp(folder):
    """Pictures of the ball from both sides by MuJoCo Warp, and the scale of the file."""
    mujoco, warp, mjw = map(pytest.importorskip, ("mujoco", "warp", "mujoco_warp"))
    (folder / "model.xml").write_text(
        MODEL.format(file="rig.mujoco.xml", more=sides(), colour="1 1 1 1")
    )
    model = mujoco.MjModel.from_xml_path(str(folder / "model.xml"))
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    there, state = mjw.put_model(model), mjw.put_data(model, data)
    context = mjw.create_render_context(model, cam_res=(SIDE, SIDE), render_rgb=True)
    mjw.refit_bvh(there, state, context)
    mjw.render(there, state, context)
    shown = [warp.zeros((1, SIDE, SIDE), dtype=warp.vec3f) for _ in SIDES]
    for k, image in enumerate(shown):
        mjw.get_rgb(context, k, image)
    scale = float(model.numeric("envlights_scale").data[0])
    return [255 * image.numpy()[0] for image in shown], scale


@pytest.mark.parametrize("name", ["none", "constant"])
def test_mujoco_warp_shows_the_same_ball(name, tmp_path):
    rig = rigs(POINTS)[name]
    el.export.save_mujoco(rig, tmp_path / "rig.mujoco.xml")
    shown, scale = pictures_of_warp(tmp_path)
    for image, side in zip(shown, SIDES, strict=True):
        normals, is_ball = normals_of(side)
        assert np.abs(image[is_ball] - 255 * scale * rig.probe(normals)).max() < WORST


def test_other_ambient_terms_and_further_lights_give_their_mean(mujoco, tmp_path):
    for rig in (*rigs(POINTS).values(), el.Rig([0.1, 0.2, 0.3], MANY, 0.0)):
        el.export.save_mujoco(rig, tmp_path / "rig.mujoco.xml")
        assert worst_code(mujoco, tmp_path, as_lamps(rig)) < WORST


def as_lamps(rig, most=LAMPS):
    """Irradiance of the brightest lights as points, and the mean of all else; no floor."""
    normals, areas = el.kernels.icosphere(5120)
    points = el.Lights(rig.lights.direction, rig.lights.irradiance)
    lamps = el.Rig([0, 0, 0], points[:most], 0.0)
    rest = el.Rig(rig.ambient, points[most:], 0.0).probe(normals)
    mean = areas @ rest / areas.sum()
    return lambda those: lamps.probe(those) + mean


def test_a_white_surface_just_fills_the_range(mujoco, tmp_path):
    rig = rigs(POINTS)["constant"]
    el.export.save_mujoco(rig, tmp_path / "rig.mujoco.xml")
    _, scale = pictures(mujoco, tmp_path)
    assert scale * rig.probe(el.kernels.icosphere(20480)[0]).max() == pytest.approx(1, abs=1e-3)


def test_a_scale_of_ones_own_and_a_grey_material(mujoco, tmp_path):
    lamp = el.Lights([[0, 1, 0]], [[1, 1, 1]])
    el.export.save_mujoco(lamp, tmp_path / "rig.mujoco.xml", scale=0.8)
    above = camera("above", [1, 0, 0], [0, 0, -1])
    (image,), scale = pictures(mujoco, tmp_path, above, "0.5 0.25 1 1")
    assert scale == 0.8
    np.testing.assert_allclose(
        image[SIDE // 2, SIDE // 2], 255 * 0.8 * np.array([0.5, 0.25, 1]), atol=1
    )


def test_the_three_brightest_lights_cast_shadows(mujoco, tmp_path):
    """Four lamps around the zenith: the shadows of three lie beside the ball on the floor."""
    flat = np.array([[1, 0], [0, 1], [-1, 0], [0, -1]])
    towards = np.insert(flat, 1, 1, axis=1) / np.sqrt(2)
    el.Lights(towards, 0.25 * np.array([[1.3] * 3, [1.2] * 3, [1.1] * 3, [1] * 3])).save(
        tmp_path / "rig.mujoco.xml"
    )
    floor = '<geom type="plane" size="9 9 1" pos="0 0 -3" material="matte"/>'
    below = [
        camera(f"at{k}", [1, 0, 0], [0, 0, -1], 0.4, (-3 * x, -3, -3 * z))
        for k, (x, z) in enumerate(flat)
    ]
    # Seen from above through the ball's sides: its shadow is 3 metres from its foot.
    shown, scale = pictures(mujoco, tmp_path, floor + "".join(below))
    lit = 255 * scale * 0.25 * np.array([1.3, 1.2, 1.1, 1]) / np.sqrt(2)
    seen = [image[SIDE // 2, SIDE // 2, 0] for image in shown]
    np.testing.assert_allclose(seen, lit.sum() - lit * [1, 1, 1, 0], atol=3)


def test_what_is_high_above_the_origin_casts_a_shadow_too(mujoco, tmp_path):
    el.export.save_mujoco(el.Lights([[0, 1, 0]], [[1, 1, 1]]), tmp_path / "rig.mujoco.xml")
    things = (
        '<geom type="plane" size="9 9 1" pos="0 0 -3" material="matte"/>'
        '<geom type="sphere" size="0.5" pos="2 0 4" material="matte"/>'
    )
    # Below the small ball, and in the open; seen from above and behind.
    up, feet = [0, 0.1**0.5, -(0.9**0.5)], [(0, -3, 2), (3, -3, -2)]
    below = [camera(f"at{k}", [1, 0, 0], up, 0.4, foot) for k, foot in enumerate(feet)]
    shown, _ = pictures(mujoco, tmp_path, things + "".join(below))
    assert [image[SIDE // 2, SIDE // 2, 0] for image in shown] == [0, 255]


def test_a_file_is_a_model_of_its_own(mujoco, tmp_path):
    el.export.save_mujoco(DISCS, tmp_path / "rig.mujoco.xml")
    model = mujoco.MjModel.from_xml_path(str(tmp_path / "rig.mujoco.xml"))
    np.testing.assert_allclose(
        -model.light_dir, AXES["mujoco"].to_target(DISCS.direction), atol=1e-7
    )
    if hasattr(model, "light_type"):
        assert (model.light_type == mujoco.mjtLightType.mjLIGHT_DIRECTIONAL).all()
    else:  # before MuJoCo 3.3.3
        assert model.light_directional.all()
    assert model.light_castshadow.tolist() == [True, True, True, False, False]
    assert not np.any([model.vis.headlight.diffuse, model.vis.headlight.specular])


def by_formula(model):
    """Irradiance over scale at `NORMALS`, and the number of lights, by OpenGL's formula."""
    root = ElementTree.fromstring(model)

    def read(element, name):
        return np.array(element.get(name).split(), float)

    lights = root.findall("worldbody/light")
    there = AXES["mujoco"].to_target(NORMALS)
    total = read(root.find("visual/headlight"), "ambient") + np.zeros((len(NORMALS), 3))
    for light in lights:
        total += np.maximum(there @ -read(light, "dir"), 0)[:, None] * read(light, "diffuse")
    return total / float(root.find("custom/numeric").get("data")), len(lights)


def irradiance_of_file(path):
    """Irradiance at `NORMALS` by the formula that MuJoCo's renderer uses."""
    return by_formula(path.read_text())[0]


@pytest.mark.parametrize("name", rigs(POINTS))
def test_by_formula_a_file_lights_as_it_says(name):
    rig = rigs(POINTS)[name]
    irradiance, count = by_formula(el.export.mujoco(rig))
    assert count == len(POINTS)
    assert relative(irradiance, as_lamps(rig)(NORMALS)) < 1e-3


def test_files_state_their_units():
    assert "the scale is that of the map, which is not calibrated" in el.export.mujoco(POINTS)
    assert 'metadata/units = "the scale is that of the map' in el.export.godot(POINTS)


def test_without_lights_and_without_light():
    for rig in (POINTS[:0], el.Lights([[0, 1, 0]], [[0, 0, 0]])):
        irradiance, count = by_formula(el.export.mujoco(rig))
        assert count == len(rig)
        assert not irradiance.any()


def test_of_a_map_the_mean_remains():
    env = environment()
    irradiance, _ = by_formula(el.export.mujoco(POINTS[:0], env))
    normals, areas = el.kernels.icosphere(5120)
    mean = areas @ env.probe(normals) / areas.sum()
    np.testing.assert_allclose(irradiance, np.broadcast_to(mean, irradiance.shape), rtol=1e-3)


def test_the_front_of_a_robot_looks_at_the_centre_of_the_map():
    irradiance, _ = by_formula(el.export.mujoco(ON_AXES))
    np.testing.assert_allclose(irradiance, 3 * np.maximum(NORMALS, 0), atol=1e-12)
    assert AXES["mujoco"].to_target([[0, 0, 1]]).tolist() == [[1, 0, 0]]


@pytest.mark.parametrize("scale", [-1, np.nan, "2", True])
def test_a_scale_that_is_none_is_refused(scale):
    with pytest.raises(el.EnvLightsError, match="scale must be a finite number, 0 or more; got"):
        el.export.mujoco(POINTS, scale=scale)
