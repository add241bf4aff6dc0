"""Stages of +z up: referenced into a stage of a robot simulator, they light as the rig does."""

import numpy as np
import pytest

import envlights as el
from tests.export import cards
from tests.export.rigs import DISCS, environment, relative, rigs
from tests.helpers import NORMALS

pytest.importorskip("pxr", reason="needs usd-core")

from pxr import Usd, UsdGeom, UsdLux

from tests.export.test_usd import problems

RIGS = rigs(DISCS)


def there(vectors):
    """Vectors of our frame in a stage of +z up: a quarter turn about +x."""
    x, y, z = np.transpose(vectors)
    return np.stack([x, -z, y], axis=-1)


def compose(path):
    """A new stage of +z up that references a file, as programs do: without turning it."""
    stage = Usd.Stage.CreateInMemory()
    UsdGeom.SetStageUpAxis(stage, UsdGeom.Tokens.z)
    UsdGeom.SetStageMetersPerUnit(stage, 1.0)
    stage.DefinePrim("/World/lights").GetReferences().AddReference(str(path))
    return stage


def to_world(prim, time):
    return UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(time)


def irradiance_in(stage, normals, time=0.0):
    """Irradiance by the definitions of UsdLux at `normals` in the frame of the stage."""
    total, time = np.zeros((len(normals), 3)), Usd.TimeCode(time)
    for prim in stage.Traverse():
        if prim.IsA(UsdLux.DistantLight):
            light = UsdLux.DistantLight(prim)
            towards = -np.array(to_world(prim, time).TransformDir((0, 0, -1)))
            colour = light.GetIntensityAttr().Get(time) * np.array(light.GetColorAttr().Get(time))
            radius = np.deg2rad(light.GetAngleAttr().Get(time)) / 2
            lamp = el.Lights([towards], [colour], [radius])
            total += el.Rig([0, 0, 0], lamp, 0.0).probe(normals)
        elif prim.IsA(UsdLux.DomeLight):
            total += dome(UsdLux.DomeLight(prim), to_world(prim, time), normals, time)
    return total


def dome(light, matrix, normals, time):
    colour = light.GetIntensityAttr().Get(time) * np.array(light.GetColorAttr().Get(time))
    file = light.GetTextureFileAttr().Get()
    if not file:
        return np.pi * colour
    # The pole of a dome is its own +y; the stage turns it by its transform alone.
    local = normals @ np.linalg.inv(np.array(matrix)[:3, :3])
    return colour * el.EnvMap.open(file.resolvedPath).probe(local)


@pytest.mark.parametrize("suffix", [".usda", ".usdc"])
@pytest.mark.parametrize("name", RIGS)
def test_a_stage_of_z_up_lights_as_the_rig_does(name, suffix, tmp_path):
    rig = RIGS[name]
    rig.save(tmp_path / f"scene{suffix}", up="z")
    found = irradiance_in(compose(tmp_path / f"scene{suffix}"), there(NORMALS))
    assert relative(found, rig.probe(NORMALS)) < (1e-4 if name == "harmonics" else 1e-6)


def test_a_map_lies_where_the_lights_are(tmp_path):
    env = environment()
    DISCS.save(tmp_path / "scene.usda", env, up="z")
    wanted = env.probe(NORMALS) + el.Rig([0, 0, 0], DISCS, 0.0).probe(NORMALS)
    stage = compose(tmp_path / "scene.usda")
    assert relative(irradiance_in(stage, there(NORMALS)), wanted) < 1e-6
    light = UsdLux.DomeLight(stage.GetPrimAtPath("/World/lights/ambient"))
    turned = to_world(light.GetPrim(), Usd.TimeCode(0.0))
    light.OrientToStageUpAxis()  # what OpenUSD does to the dome of a stage of +z up
    assert to_world(light.GetPrim(), Usd.TimeCode(0.0)) == turned


def test_each_stage_of_another_axis_is_one_that_usdchecker_accepts(tmp_path):
    for name, rig in RIGS.items():
        rig.save(tmp_path / f"{name}.usda", up="z", metres_per_unit=0.01)
        stage = Usd.Stage.Open(str(tmp_path / f"{name}.usda"))
        assert UsdGeom.GetStageUpAxis(stage) == "Z"
        assert UsdGeom.GetStageMetersPerUnit(stage) == 0.01
        assert problems(tmp_path / f"{name}.usda") == []


#: Local points of a light: its centre, and the middles of its right and upper sides.
PARTS = {
    "RectLight": lambda light: (
        0.5 * light.GetWidthAttr().Get(),
        0.5 * light.GetHeightAttr().Get(),
    ),
    "DiskLight": lambda light: (light.GetRadiusAttr().Get(), light.GetRadiusAttr().Get()),
}


@pytest.mark.parametrize("name", cards.ALL)
def test_a_card_stands_in_its_place_in_centimetres(name, tmp_path):
    card = cards.ALL[name].at(3.0)
    el.export.save(card, tmp_path / "card.usda", up="z", metres_per_unit=0.01)
    stage = Usd.Stage.Open(str(tmp_path / "card.usda"))
    prim = stage.GetPrimAtPath("/rig/card_0")
    u, v, start = card.matrix[0].T
    if prim.IsA(UsdGeom.Mesh):
        found = np.array(UsdGeom.Mesh(prim).GetPointsAttr().Get())
        wanted = [start, start + v, start + u + v, start + u]
    else:
        kind = prim.GetTypeName()
        x, y = PARTS[kind](getattr(UsdLux, kind)(prim))
        place = to_world(prim, Usd.TimeCode.Default())
        found = [place.Transform(point) for point in ((0, 0, 0), (-x, 0, 0), (0, -y, 0))]
        middle = start + (u + v) / 2
        wanted = [middle, middle + u / 2, middle + v / 2]
    np.testing.assert_allclose(found, 100 * there(wanted), atol=1e-4)


def test_the_frames_of_a_sequence_are_of_z_up_too(tmp_path):
    frames = [
        el.sequence.FrameRig([0.1 * k, 0, 0], DISCS[k : k + 2], 0.0, frame=k, ids=(k, k + 1))
        for k in range(3)
    ]
    el.sequence.RigSequence(frames).save(tmp_path / "rigs.usda", up="z", metres_per_unit=0.5)
    stage = compose(tmp_path / "rigs.usda")
    for rig in frames:
        found = irradiance_in(stage, there(NORMALS), rig.frame)
        assert relative(found, rig.probe(NORMALS)) < 1e-6
    assert UsdGeom.GetStageMetersPerUnit(Usd.Stage.Open(str(tmp_path / "rigs.usda"))) == 0.5


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"up": "x"}, "up must be 'y' or 'z'; got 'x'"),
        ({"metres_per_unit": 0}, "metres_per_unit must be above 0"),
        ({"metres_per_unit": np.nan}, "metres_per_unit must be a finite number"),
    ],
)
def test_another_frame_is_refused(options, words, tmp_path):
    with pytest.raises(el.EnvLightsError, match=words):
        el.export.usd(DISCS, **options)
    with pytest.raises(el.EnvLightsError, match=words):
        DISCS.save(tmp_path / "scene.usda", **options)
    assert not list(tmp_path.iterdir())


def test_an_option_of_another_program_is_refused(tmp_path):
    with pytest.raises(el.EnvLightsError, match=r"up= changes nothing for three.js; .* OpenUSD"):
        DISCS.save(tmp_path / "scene.three.json", up="z")
    with pytest.raises(el.EnvLightsError, match=r"upp= changes nothing .* no program has this"):
        DISCS.save(tmp_path / "scene.usda", upp="z")
    parts = el.split(environment(), lights=1)
    with pytest.raises(el.EnvLightsError, match=r"scale= .* it is an option of MuJoCo"):
        parts.save(tmp_path / "scene.usda", scale=2.0)
    assert not list(tmp_path.iterdir())
    parts.save(tmp_path / "scene.usda", tmp_path / "scene.py", up="z")
    assert 'upAxis = "Z"' in (tmp_path / "scene.usda").read_text()
