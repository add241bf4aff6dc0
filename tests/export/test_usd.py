"""Rigs in OpenUSD, read back by its own library."""

import sys

import numpy as np
import pytest

import envlights as el
from tests.export.rigs import AXES, DISCS, environment, relative, rigs
from tests.helpers import NORMALS

pytest.importorskip("pxr", reason="needs usd-core")

from pxr import Sdf, Usd, UsdGeom, UsdLux, UsdUtils

try:
    from pxr import UsdValidation
except ImportError:  # of older versions
    UsdValidation = None

RIGS = rigs(DISCS)


def lights_of(stage):
    """Distant lights as the schema defines them."""
    direction, irradiance, radius = [], [], []
    for prim in stage.Traverse():
        if not prim.IsA(UsdLux.DistantLight):
            continue
        light = UsdLux.DistantLight(prim)
        to_world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(Usd.TimeCode.Default())
        direction.append(-np.array(to_world.TransformDir((0, 0, -1))))  # emission is along -z
        angle = np.deg2rad(light.GetAngleAttr().Get()) / 2
        scale = light.GetIntensityAttr().Get() * 2 ** light.GetExposureAttr().Get()
        # Of a normalised light the luminance is divided by what a disc of that angle receives.
        assert light.GetNormalizeAttr().Get()
        irradiance.append(scale * np.array(light.GetColorAttr().Get()))
        radius.append(angle)
    return el.Lights(np.reshape(direction, (-1, 3)), np.reshape(irradiance, (-1, 3)), radius)


def dome_of(stage, folder):
    """The dome as a map; None where there is none."""
    domes = [UsdLux.DomeLight(p) for p in stage.Traverse() if p.IsA(UsdLux.DomeLight)]
    if not domes:
        return None
    (dome,) = domes
    colour = dome.GetIntensityAttr().Get() * np.array(dome.GetColorAttr().Get())
    file = dome.GetTextureFileAttr().Get()
    if not file:
        return np.pi * colour
    assert dome.GetTextureFormatAttr().Get() == "latlong"
    assert file.resolvedPath == str(folder / file.path.removeprefix("./"))
    return colour * el.EnvMap.open(file.resolvedPath).probe(NORMALS)


def irradiance_of_file(path):
    stage = Usd.Stage.Open(str(path))
    dome = dome_of(stage, path.parent)
    lights = el.Rig([0, 0, 0], lights_of(stage), 0.0).probe(NORMALS)
    return lights if dome is None else lights + dome


def texture_of_file(path):
    """Path of the texture of the dome, which OpenUSD finds."""
    stage = Usd.Stage.Open(str(path))
    file = stage.GetPrimAtPath("/rig/ambient").GetAttribute("inputs:texture:file").Get()
    assert file.resolvedPath == str(path.parent / file.path)
    return file.path.removeprefix("./")


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
@pytest.mark.parametrize("name", RIGS)
def test_a_stage_lights_as_the_rig_does(name, suffix, tmp_path):
    rig = RIGS[name]
    rig.save(tmp_path / f"scene{suffix}")
    seen = irradiance_of_file(tmp_path / f"scene{suffix}")
    # Harmonics become a map of 128 rows, and lose what is negative; here nothing is.
    assert relative(seen, rig.probe(NORMALS)) < (1e-4 if name == "harmonics" else 1e-6)


def test_a_map_stands_in_place_of_the_ambient_term(tmp_path):
    env = environment()
    DISCS.save(tmp_path / "scene.usda", environment=env)
    wanted = env.probe(NORMALS) + el.Rig([0, 0, 0], DISCS, 0.0).probe(NORMALS)
    assert relative(irradiance_of_file(tmp_path / "scene.usda"), wanted) < 1e-6
    assert {path.name for path in tmp_path.iterdir()} == {"scene.usda", "scene.ambient.exr"}


def test_lights_on_the_axes_arrive_where_they_should(tmp_path):
    AXES.save(tmp_path / "scene.usda")
    lights = lights_of(Usd.Stage.Open(str(tmp_path / "scene.usda")))
    for axis, colour in zip(lights.direction, lights.irradiance, strict=True):
        np.testing.assert_allclose(colour / 3, axis, atol=1e-12)


def test_a_black_light_stays_black_beside_others(tmp_path):
    lights = el.Lights([[0, 0, 1], [0, 1, 0]], [[0, 0, 0], [1, 2, 3]], [0.1, 0.2])
    lights.save(tmp_path / "scene.usda")
    found = lights_of(Usd.Stage.Open(str(tmp_path / "scene.usda"))).irradiance
    np.testing.assert_allclose(sorted(found.tolist()), [[0, 0, 0], [1, 2, 3]], rtol=1e-6)


def problems(path):
    """Problems that usdchecker reports."""
    if UsdValidation is None:
        checker = UsdUtils.ComplianceChecker()
        checker.CheckCompliance(str(path))
        return [*checker.GetErrors(), *checker.GetWarnings(), *checker.GetFailedChecks()]
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    stage = Usd.Stage.Open(str(path))
    context = UsdValidation.ValidationContext(validators)
    return [error.GetMessage() for error in context.Validate(stage)]


@pytest.mark.parametrize("name", RIGS)
def test_usdchecker_has_nothing_to_say(name, tmp_path):
    RIGS[name].save(tmp_path / "scene.usda")
    assert problems(tmp_path / "scene.usda") == []


def test_usdchecker_does_look(tmp_path):
    RIGS["constant"].save(tmp_path / "scene.usda")
    text = (tmp_path / "scene.usda").read_text().replace('    upAxis = "Y"\n', "")
    (tmp_path / "scene.usda").write_text(text)
    assert any("upAxis" in problem for problem in problems(tmp_path / "scene.usda"))


def test_the_stage_says_its_frame():
    layer = Sdf.Layer.CreateAnonymous(".usda")
    assert layer.ImportFromString(el.export.usd(RIGS["harmonics"], texture="sky.exr"))
    stage = Usd.Stage.Open(layer)
    assert UsdGeom.GetStageUpAxis(stage) == "Y"
    assert UsdGeom.GetStageMetersPerUnit(stage) == 1
    dome = UsdLux.DomeLight(stage.GetPrimAtPath("/rig/ambient"))
    assert dome.GetTextureFileAttr().Get().path == "./sky.exr"


def test_without_openusd_text_is_written_and_a_crate_refused(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pxr.Sdf", None)
    DISCS.save(tmp_path / "scene.usda")
    with pytest.raises(el.EnvLightsError, match=r"pip install 'envlights\[usd\]'"):
        DISCS.save(tmp_path / "scene.usdc")
    assert [path.name for path in tmp_path.iterdir()] == ["scene.usda"]
