"""SAPIEN and Genesis: the lights that scripts give them, and balls that they render.

They render in processes of their own: `ENVLIGHTS_SAPIEN_PYTHON` and `ENVLIGHTS_GENESIS_PYTHON` name
a Python that has them, if this one has not. SAPIEN needs Vulkan, as Chromium has it in software:
``VK_ICD_FILENAMES=/usr/lib/chromium/vk_swiftshader_icd.json``.
"""

import importlib.util
import os
import runpy
import subprocess
import sys
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from envlights.export.targets import target_named
from tests.export.balls import SIDES, normals_of
from tests.export.rigs import POINTS, relative, rigs
from tests.export.test_mujoco import WORST, as_lamps
from tests.helpers import NORMALS

NAMES = ("sapien", "genesis")
#: Genesis draws all shapes as this: its shader, with a metalness and a roughness.
METALNESS, ROUGHNESS = 0.2, 0.8
#: Cosine to the eye from which a ball is compared: theirs are meshes, which end in corners.
INNER = 0.7
#: Python with each program.
PYTHONS = {
    name: os.environ.get(f"ENVLIGHTS_{name.upper()}_PYTHON", sys.executable) for name in NAMES
}


class Scene:
    """Methods of a scene of SAPIEN that a script calls; it keeps what they are given."""

    def __init__(self):
        self.lights, self.ambient = [], np.zeros(3)

    def set_ambient_light(self, colour):
        self.ambient = np.array(colour)

    def add_directional_light(self, direction, color, shadow=False):
        self.lights.append((-np.array(direction), np.array(color), shadow))


def vis_options(lights, ambient_light):
    """A scene of SAPIEN with the options of Genesis, within its limits."""
    scene = Scene()
    assert max(ambient_light) <= 1
    scene.set_ambient_light(ambient_light)
    for light in lights:
        assert light["type"] == "directional"
        assert max(light["color"]) <= 1
        scene.add_directional_light(light["dir"], light["intensity"] * np.array(light["color"]))
    return scene


def scene_of_file(path):
    """Lights and ambient term that a script gives to its program, and its scale."""
    scene, genesis = Scene(), ModuleType("genesis")
    genesis.options = SimpleNamespace(VisOptions=vis_options)
    script = runpy.run_path(str(path))
    if "add_lights" in script:
        script["add_lights"](scene)
        return scene, script["SCALE"]
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(sys.modules, "genesis", genesis)
        return script["vis_options"](), script["SCALE"]


def irradiance_of_file(path):
    """Irradiance at `NORMALS`, pi times the radiance of a white matte surface over the scale."""
    (scene, scale), there = scene_of_file(path), AXES["sapien"].to_target(NORMALS)
    total = scene.ambient + np.zeros((len(NORMALS), 3))
    for towards, colour, _ in scene.lights:
        total += np.maximum(there @ towards, 0)[:, None] * colour / np.pi
    return total / scale


@pytest.mark.parametrize("program", NAMES)
@pytest.mark.parametrize("name", rigs(POINTS))
def test_a_script_gives_the_lights_of_the_rig(program, name, tmp_path):
    most, rig = target_named(program).shows.lights, rigs(POINTS)[name]
    path = tmp_path / f"rig.{program}.py"
    getattr(el.export, f"save_{program}")(rig, path)
    assert len(scene_of_file(path)[0].lights) == most
    assert relative(irradiance_of_file(path), as_lamps(rig, most)(NORMALS)) < 1e-3


@pytest.mark.parametrize("program", NAMES)
def test_a_scale_of_ones_own_is_kept_and_nothing_is_black(program, tmp_path):
    for rig in (POINTS[:0], POINTS[:2]):
        path = tmp_path / f"rig.{program}.py"
        getattr(el.export, f"save_{program}")(rig, path, scale=0.1)
        assert scene_of_file(path)[1] == 0.1
        assert len(scene_of_file(path)[0].lights) == len(rig)


def test_of_a_map_the_mean_remains(tmp_path):
    env = el.EnvMap(np.full((8, 16, 3), [0.1, 0.2, 0.3], np.float32))
    el.export.save_genesis(POINTS[:1], tmp_path / "rig.genesis.py", env, scale=1)
    scene, _ = scene_of_file(tmp_path / "rig.genesis.py")
    np.testing.assert_allclose(scene.ambient, np.pi * env.radiance[0, 0], rtol=1e-6)


def test_one_light_of_sapien_casts_a_shadow(tmp_path):
    el.export.save_sapien(POINTS, tmp_path / "rig.sapien.py")
    shadows = [shadow for *_, shadow in scene_of_file(tmp_path / "rig.sapien.py")[0].lights]
    assert shadows == [True, False, False]


def test_genesis_clips_ambient_light_that_it_would_refuse(tmp_path):
    rig = el.Rig([1, 0.1, 0], POINTS[:1], 0.0)
    el.export.save_genesis(rig, tmp_path / "rig.genesis.py", scale=1)
    scene, _ = scene_of_file(tmp_path / "rig.genesis.py")
    np.testing.assert_allclose(scene.ambient, [1, 0.1 * np.pi, 0])


def has(program):
    """True if a Python has the program."""
    module = importlib.util.find_spec(program) is not None
    return module or PYTHONS[program] != sys.executable


def images(task, folder, program):
    """Pictures of a white ball from both sides, by the program in a process of its own."""
    np.save(
        folder / "sides.npy", AXES[program].to_target(SIDES.reshape(-1, 3)).reshape(SIDES.shape)
    )
    here = Path(__file__).with_name("in_simulators.py")
    command = [PYTHONS[program], here, task, folder / "sides.npy", folder / f"rig.{program}.py"]
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYOPENGL_PLATFORM": "egl"},
    )
    if "rendering device" in done.stderr:
        pytest.skip("SAPIEN finds no device for Vulkan")
    assert done.returncode == 0, done.stderr[-2000:]
    return np.load(folder / "sides.out.npy")


@pytest.mark.parametrize("name", ["none", "constant"])
def test_the_ball_of_sapien_shows_the_irradiance_of_the_rig(name, tmp_path):
    if not has("sapien"):
        pytest.skip("needs sapien")
    rig = rigs(POINTS[:3])[name]
    rig.save(tmp_path / "rig.sapien.py")
    scale = runpy.run_path(str(tmp_path / "rig.sapien.py"))["SCALE"]
    for image, side in zip(images("sapien", tmp_path, "sapien"), SIDES, strict=True):
        normals, is_ball = normals_of(side)
        off = np.abs(linear(image[is_ball]) - 255 * scale * rig.probe(normals))
        assert off[normals @ side[2] > INNER].max() < WORST


def linear(codes):
    """Linear codes up to 255: those of a picture are steep where a lamp's light ends."""
    return 255 * (codes / 255) ** 2.2


def ggx(normals, view, towards):
    """Radiance of Genesis' white surface for a lamp of irradiance 1: `mesh.frag`."""
    half = (towards + view) / np.linalg.norm(towards + view)
    nl, nv = np.clip(normals @ towards, 0.001, 1), np.clip(np.abs(normals @ view), 0.001, 1)
    nh, vh = np.clip(normals @ half, 0, 1), np.clip(view @ half, 0, 1)
    f0 = 0.04 * (1 - METALNESS) + METALNESS
    fresnel = f0 + (1 - f0) * (1 - vh) ** 5
    k, a2 = (ROUGHNESS + 1) ** 2 / 8, ROUGHNESS**4
    masking = nv / (nv * (1 - k) + k) * nl / (nl * (1 - k) + k)
    peak = a2 / (np.pi * (nh**2 * (a2 - 1) + 1) ** 2)
    matte = (1 - fresnel) * 0.96 * (1 - METALNESS) / np.pi
    return nl * (matte + fresnel * masking * peak / (4 * nl * nv + 0.001))


@pytest.mark.parametrize("name", ["none", "constant"])
def test_the_ball_of_genesis_shows_its_shader_under_the_lights_of_the_rig(name, tmp_path):
    if not has("genesis"):
        pytest.skip("needs genesis-world")
    rig = rigs(POINTS[:4])[name]
    rig.save(tmp_path / "rig.genesis.py")
    scale = runpy.run_path(str(tmp_path / "rig.genesis.py"))["SCALE"]
    for image, side in zip(images("genesis", tmp_path, "genesis"), SIDES, strict=True):
        normals, is_ball = normals_of(side)
        lamps = zip(rig.lights.direction, rig.lights.irradiance, strict=True)
        lit = sum(ggx(normals, side[2], towards)[:, None] * colour for towards, colour in lamps)
        off = np.abs(linear(image[is_ball]) - 255 * np.pi * scale * (lit + rig.ambient))
        # Its pixels are encoded and cut to 8 bits: a code of white is 2.2 linear ones.
        assert off[normals @ side[2] > INNER].max() < 2.2
