"""Files of a sequence, read back at every frame."""

import base64
import json
import math
import types

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import envlights as el
from envlights.export import AXES
from envlights.kernels.probe import relative_rms
from envlights.sequence.formats import SUFFIXES
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.sequence.shows import towards

AMBIENT = np.array([0.1, 0.2, 0.3])


def rig_of(frame):
    """Light 5 turns and fades, light 9 burns in the frames 2 and 3."""
    rows = [(5, towards(20 * frame, 30 + 10 * frame), [4.0 + frame, 2.0, 1.0], 0.1 * frame)]
    if frame in (2, 3):
        rows.append((9, towards(-80, -20), [0.2, 0.5, 0.9], 0.3))
    ids, direction, irradiance, radius = zip(*rows, strict=True)
    lights = el.Lights(direction, irradiance, radius)
    return el.sequence.FrameRig(
        AMBIENT * (1 + frame), lights, 0.01, frame=frame, ids=ids, fit_error=0.02
    )


RIGS = el.sequence.RigSequence([rig_of(frame) for frame in range(5)], steadiness=2, fps=12.0)


BLACK = el.Lights([[0, 1, 0]], [[0, 0, 0]])


def difference(irradiance, frame):
    return relative_rms(irradiance, RIGS[frame].probe(NORMALS), SOLID_ANGLES)


def test_json_lines_hold_all(tmp_path):
    RIGS.save(tmp_path / "rigs.jsonl")
    assert el.sequence.RigSequence.load(tmp_path / "rigs.jsonl") == RIGS


def test_a_fit_survives_json_lines(tmp_path):
    lamp = el.Lights([[0, 0.6, 0.8]], [[3, 2, 1]], [0.1]).to_map(32)
    rigs = el.follow([lamp, lamp], lights=2, fps=25).sequence()
    rigs.save(tmp_path / "rigs.jsonl")
    assert el.sequence.RigSequence.load(tmp_path / "rigs.jsonl") == rigs


def test_a_csv_has_a_row_for_each_light_and_each_ambient_term(tmp_path):
    RIGS.save(tmp_path / "rigs.csv")
    lines = (tmp_path / "rigs.csv").read_text().splitlines()
    names = lines[1].split(",")
    rows = [dict(zip(names, line.split(","), strict=True)) for line in lines[2:]]
    for rig in RIGS:
        mine = [row for row in rows if int(row["frame"]) == rig.frame]
        lights = [row for row in mine if row["kind"] == "light"]
        assert [int(row["id"]) for row in lights] == list(rig.ids)
        for columns, values in (
            ("xyz", rig.lights.direction),
            (("red", "green", "blue"), rig.lights.irradiance),
            (("angular_radius",), rig.lights.angular_radius[:, None]),
        ):
            seen = [[float(row[column]) for column in columns] for row in lights]
            np.testing.assert_array_equal(seen, values)
        (ambient,) = [row for row in mine if row["kind"] == "ambient"]
        assert [float(ambient[c]) for c in ("red", "green", "blue")] == rig.ambient.tolist()


@pytest.mark.parametrize("suffix", [".usda", ".usdc", ".usd"])
def test_openusd_reads_the_irradiance_of_each_frame(suffix, tmp_path):
    pytest.importorskip("pxr", reason="needs usd-core")
    from pxr import Usd, UsdGeom, UsdLux

    RIGS.save(tmp_path / f"rigs{suffix}")
    stage = Usd.Stage.Open(str(tmp_path / f"rigs{suffix}"))
    assert (stage.GetStartTimeCode(), stage.GetEndTimeCode()) == (0, 4)
    assert stage.GetTimeCodesPerSecond() == 12
    for frame in range(5):
        rows, ambient = [], np.zeros(3)
        for prim in stage.Traverse():
            if prim.IsA(UsdLux.DomeLight):
                dome = UsdLux.DomeLight(prim)
                intensity = dome.GetIntensityAttr().Get(frame)
                ambient = intensity * np.array(dome.GetColorAttr().Get(frame))
            if prim.IsA(UsdLux.DistantLight):
                light = UsdLux.DistantLight(prim)
                to_world = UsdGeom.Xformable(prim).ComputeLocalToWorldTransform(frame)
                rows.append(
                    (
                        -np.array(to_world.TransformDir((0, 0, -1))),
                        light.GetIntensityAttr().Get(frame)
                        * np.array(light.GetColorAttr().Get(frame)),
                        math.radians(light.GetAngleAttr().Get(frame)) / 2,
                    )
                )
        seen = el.Rig(ambient, el.Lights(*zip(*rows, strict=True)), 0.0)
        assert difference(seen.probe(NORMALS), frame) < 1e-6


def keyframes(asset):
    """Values of each channel, by what it moves, and the times."""
    data = base64.b64decode(asset["buffers"][0]["uri"].split(",")[1])
    assert len(data) == asset["buffers"][0]["byteLength"]

    def values(accessor):
        view = asset["bufferViews"][accessor["bufferView"]]
        columns = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        array = np.frombuffer(data, "<f4", accessor["count"] * columns, view["byteOffset"])
        array = array.reshape(-1, columns)
        np.testing.assert_array_equal(array.min(axis=0), np.float32(accessor["min"]))
        np.testing.assert_array_equal(array.max(axis=0), np.float32(accessor["max"]))
        return array.astype(float)

    (animation,) = asset["animations"]
    curves, times = {}, None
    for channel in animation["channels"]:
        sampler, target = animation["samplers"][channel["sampler"]], channel["target"]
        assert sampler["interpolation"] == "LINEAR"
        times = values(asset["accessors"][sampler["input"]])[:, 0]
        if target["path"] == "pointer":
            name = target["extensions"]["KHR_animation_pointer"]["pointer"]
        else:
            name = f"/nodes/{target['node']}/{target['path']}"
        curves[name] = values(asset["accessors"][sampler["output"]])
    return times, curves


def test_gltf_has_the_irradiance_of_each_frame(tmp_path):
    RIGS.save(tmp_path / "rigs.gltf")
    asset = json.loads((tmp_path / "rigs.gltf").read_text())
    assert asset["extensionsUsed"] == ["KHR_lights_punctual", "KHR_animation_pointer"]
    times, curves = keyframes(asset)
    np.testing.assert_allclose(times, np.arange(5) / 12, rtol=1e-6)
    lights = asset["extensions"]["KHR_lights_punctual"]["lights"]
    for frame in range(5):
        seen = np.pi * np.array(asset["asset"]["extras"]["ambient"][frame]) + np.zeros(
            (len(NORMALS), 3)
        )
        for row, light in enumerate(lights):
            rotation = curves[f"/nodes/{row}/rotation"][frame]
            at = f"/extensions/KHR_lights_punctual/lights/{row}/"
            irradiance = curves[at + "intensity"][frame] * curves[at + "color"][frame]
            direction = -Rotation.from_quat(rotation).apply([0, 0, -1])
            disc = el.Lights([direction], [irradiance], [light["extras"]["angular_radius"][frame]])
            seen += el.Rig([0, 0, 0], disc, 0.0).probe(NORMALS)
        assert difference(seen, frame) < 1e-6


def test_rotations_take_the_shorter_way():
    # Behind -z, the shortest rotation from there changes its axis.
    places = [towards(azimuth, 0.3) for azimuth in (170, 176, 183, 188)]
    rigs = [
        el.sequence.FrameRig([0, 0, 0], el.Lights([place], [[1, 1, 1]]), 0.0, frame=k, ids=(0,))
        for k, place in enumerate(places)
    ]
    rotations = keyframes(el.sequence.gltf(rigs))[1]["/nodes/0/rotation"]
    assert ((rotations[1:] * rotations[:-1]).sum(axis=1) > 0).all()


class Recorder:
    """Things of Blender that remember the values of their keyframes."""

    def __init__(self):
        self.keys = {}

    def keyframe_insert(self, name, frame):
        self.keys.setdefault(name, {})[frame] = getattr(self, name)


class Turn(np.ndarray):
    """Quaternion of Blender, w, x, y, z."""

    def make_compatible(self, other):
        if self @ other < 0:
            self *= -1


class Vector(tuple):
    """Vector of Blender."""

    __slots__ = ()

    def to_track_quat(self, axis, up):
        """Rotation by which the local z points along the vector."""
        assert (axis, up) == ("Z", "Y")
        x, y, z, w = Rotation.align_vectors([self], [[0, 0, 1]])[0].as_quat()
        return np.array([w, x, y, z]).view(Turn)


class Color(tuple):
    """Colour of Blender in a file whose working space is Rec.709."""

    __slots__ = ()

    def from_rec709_linear_to_scene_linear(self):
        """The colour in the working space."""
        return self


def blender_of(script):
    """Lamps by name, and the background, after a run of the script in a double of Blender."""
    lamps, suns, background = {}, {}, Recorder()

    def make(made):
        def new(name, *_):
            made[name] = Recorder()
            return made[name]

        return new

    world = types.SimpleNamespace(node_tree=None, use_nodes=False)
    nodes = types.SimpleNamespace(
        clear=lambda: None,
        new=lambda kind: types.SimpleNamespace(
            inputs={"Color": background, "Strength": Recorder(), "Surface": None}, outputs=[None]
        ),
    )
    world.node_tree = types.SimpleNamespace(
        nodes=nodes, links=types.SimpleNamespace(new=lambda *_: None)
    )
    collection = types.SimpleNamespace(objects=types.SimpleNamespace(link=lambda _: None))
    scene = types.SimpleNamespace(
        render=types.SimpleNamespace(),
        collection=types.SimpleNamespace(children=types.SimpleNamespace(link=lambda _: None)),
    )
    data = types.SimpleNamespace(
        lights=types.SimpleNamespace(new=make(lamps)),
        objects=types.SimpleNamespace(new=make(suns)),
        worlds=types.SimpleNamespace(new=lambda _: world),
        collections=types.SimpleNamespace(get=lambda _: None, new=lambda _: collection),
    )
    bpy = types.SimpleNamespace(data=data, context=types.SimpleNamespace(scene=scene))
    mathutils = types.SimpleNamespace(Vector=Vector)
    imports = {"bpy": bpy, "mathutils": mathutils}
    lines = [
        line
        for line in script.splitlines()
        if line not in ("import bpy", "from mathutils import Color, Vector")
    ]
    exec("\n".join(lines), {**imports, "Vector": Vector, "Color": Color, "__name__": "script"})
    return lamps, suns, background, scene


def test_the_script_for_blender_sets_the_keys_of_each_frame(tmp_path):
    RIGS.save(tmp_path / "rigs.py")
    lamps, suns, background, scene = blender_of((tmp_path / "rigs.py").read_text())
    assert (scene.frame_start, scene.frame_end) == (0, 4)
    assert scene.render.fps / scene.render.fps_base == 12
    for frame in range(5):
        ambient = background.keys["default_value"][frame]
        assert ambient[3] == 1
        rows = []
        for name, lamp in lamps.items():
            w, x, y, z = suns[name].keys["rotation_quaternion"][frame]
            there = Rotation.from_quat([x, y, z, w]).apply([0, 0, 1])
            irradiance = lamp.keys["energy"][frame] * np.array(lamp.keys["color"][frame])
            rows.append(
                (
                    there @ AXES["blender"].to_target(np.eye(3)).T,
                    irradiance,
                    lamp.keys["angle"][frame] / 2,
                )
            )
        seen = el.Rig(ambient[:3], el.Lights(*zip(*rows, strict=True)), 0.0)
        assert difference(seen.probe(NORMALS), frame) < 1e-9


def test_calibrated_rigs_have_the_units_of_the_target():
    lights = el.Lights([[0, 1, 0]], [[683.0, 683.0, 683.0]], units="cd/m2")
    rigs = [el.sequence.FrameRig([0, 0, 0], lights, 0.0, ids=(0,))]
    assert " [1.0, 1.0, 1.0], 1.0, 0.0)" in el.sequence.blender(rigs)
    assert "inputs:intensity.timeSamples = {0: 683.0}" in el.sequence.usd(rigs)
    assert "cd/m2" in el.sequence.csv(rigs).splitlines()[0]


def test_other_suffixes_are_refused(tmp_path):
    with pytest.raises(el.EnvLightsError, match=r"one of \.jsonl, .* got the suffix '\.xml'"):
        RIGS.save(tmp_path / "rigs.xml")
    assert list(tmp_path.iterdir()) == []


def test_harmonics_are_not_animated_but_saved(tmp_path):
    harmonics = np.zeros((9, 3))
    harmonics[0] = 1
    rigs = el.sequence.RigSequence(
        [el.sequence.FrameRig(harmonics, el.Lights([[0, 1, 0]], [[1, 1, 1]]), 0.0, ids=(0,))]
    )
    for suffix in SUFFIXES:
        if suffix in (".jsonl", ".csv"):
            rigs.save(tmp_path / f"rigs{suffix}")
        else:
            with pytest.raises(el.EnvLightsError, match="got harmonics"):
                rigs.save(tmp_path / f"rigs{suffix}")
    assert el.sequence.RigSequence.load(tmp_path / "rigs.jsonl") == rigs


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "line 1, is not JSON"),
        ("[1]\n", "is not a sequence of rigs of version 1"),
        ('{"format": "envlights rig", "version": 4}\n', "is not a sequence of rigs of version 1"),
        (None, "line 3, is not JSON"),
    ],
)
def test_damaged_json_lines_are_refused(text, sentence, tmp_path):
    path = tmp_path / "rigs.jsonl"
    RIGS.save(path)
    whole = path.read_text()
    path.write_text(
        whole[: whole.index("\n", whole.index("\n") + 1) + 40] if text is None else text
    )
    with pytest.raises(el.EnvLightsError, match=sentence):
        el.sequence.RigSequence.load(path)


def test_json_lines_that_lost_whole_frames_are_refused(tmp_path):
    path = tmp_path / "rigs.jsonl"
    RIGS.save(path)
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    with pytest.raises(el.EnvLightsError, match=f"holds {len(RIGS) - 1} of {len(RIGS)} frames"):
        el.sequence.RigSequence.load(path)
    path.write_text(path.read_text().replace('"frames": ', '"frames": -'))
    with pytest.raises(el.EnvLightsError, match="frames of the first line must be"):
        el.sequence.RigSequence.load(path)


def test_numbers_of_numpy_are_saved_as_those_of_python(tmp_path):
    rigs = el.sequence.RigSequence(
        [
            el.sequence.FrameRig(
                AMBIENT, BLACK, frame=frame, ids=(1,), is_step=np.False_, floor=np.True_
            )
            for frame in np.arange(2)
        ]
    )
    for suffix in SUFFIXES:
        rigs.save(tmp_path / f"rigs{suffix}")
        assert b"np." not in (tmp_path / f"rigs{suffix}").read_bytes()
    assert el.sequence.RigSequence.load(tmp_path / "rigs.jsonl") == rigs
    with pytest.raises(el.EnvLightsError, match="fit_error must be a finite number"):
        el.sequence.FrameRig(AMBIENT, BLACK, ids=(1,), fit_error=np.nan)


def test_a_sequence_without_errors_says_so():
    rigs = el.sequence.RigSequence([el.sequence.FrameRig(AMBIENT, BLACK, ids=(1,))])
    assert "error not measured" in repr(rigs)
    assert "relative RMS error not measured" in str(rigs)
    assert np.isnan(rigs.error).all()


def test_sequences_show_themselves():
    assert repr(RIGS) == "<RigSequence: 5 frames, 2 lights, mean error 1 %, flicker 6.4 %>"
    text = str(RIGS)
    assert "steadiness 2 frames at 12 frames in a second" in text
    assert "2 to 3" in text
    assert "<table>" in RIGS._repr_html_()
    assert len(RIGS.columns()["id"]) == 7


def test_the_table_of_a_sequence_holds_flux_and_motion_of_each_light():
    # Luminances of light 5 in the frames 0 to 4, and of light 9 in two of them, by Rec. 709.
    five = np.mean([0.2126 * (4 + frame) + 0.7152 * 2 + 0.0722 for frame in range(5)])
    nine = 2 / 5 * (0.2126 * 0.2 + 0.7152 * 0.5 + 0.0722 * 0.9)
    rows = RIGS.table().rows
    assert [row[:2] for row in rows] == [["5", "0 to 4"], ["9", "2 to 3"]]
    shares = [f"{100 * each / (five + nine):.1f} %" for each in (five, nine)]
    assert [row[2] for row in rows] == shares
    np.testing.assert_allclose([float(row[3]) for row in rows], [five, nine], rtol=1e-3)
    assert rows[1][4] == "0.00° a frame"
    assert el.sequence.RigSequence(list(RIGS)[2:]).table().rows[0][1] == "2 to 4"
    black = [
        el.sequence.FrameRig(AMBIENT, BLACK, 0.01, frame=frame, ids=(1,)) for frame in range(2)
    ]
    assert el.sequence.RigSequence(black).table().rows[0][2] == "0.0 %"
