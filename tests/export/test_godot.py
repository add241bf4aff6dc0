"""Godot 4: pictures of its renderer Compatibility, and the formulas of the shaders of Forward+."""

import base64
import json
import re

import numpy as np
import pytest

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.export import AXES
from envlights.export.formats.godot import _LIGHTS as LAMPS
from tests.export import godot
from tests.export.balls import SIDE, SIDES, SQUARE, normals_of
from tests.export.rigs import DISCS, POINTS, environment, relative, rigs
from tests.helpers import NORMALS

RIGS = rigs(POINTS)
#: One lamp in each direction of an icosahedron's faces, more than Godot draws.
MANY = el.Lights(el.kernels.icosphere(20)[0], np.linspace(1, 0.1, 60).reshape(20, 3))
NOTHING = POINTS[:0]
EXPOSURE = 0.25
#: Rigs whose ambient term is one colour: the sky of the renderer Compatibility is not linear.
RENDERED = {
    **{
        f"axis{k}": el.Rig([0, 0, 0], el.Lights(np.eye(3)[[k]], [[3, 2, 1]]), 0.0) for k in range(3)
    },
    "points": RIGS["none"],
    "constant": RIGS["constant"],
    "sun": el.Rig([0.1, 0.2, 0.3], el.Lights([[0.6, 0.8, 0]], [[3, 2, 1]], [0.00465]), 0.0),
    "ambient": el.Rig([3, 0.2, 0], NOTHING, 0.0),
    "many": el.Rig([0.1, 0.2, 0.3], MANY, 0.0),
}
#: Channels of a sky that grow along +x, +y and +z.
SLOPES = el.EnvMap((0.5 + 0.5 * el.kernels.pixel_directions(32, 64)).astype(np.float32))


def sections(scene):
    """Headings of a scene, each with its own values, by a parser of its own."""
    parts = re.split(r"^\[(.*)\]$", scene, flags=re.M)[1:]
    for heading, body in zip(parts[::2], parts[1::2], strict=True):
        values = dict(re.findall(r"^(\w+) = (.*)$", body, flags=re.M))
        yield heading.split()[0], dict(re.findall(r'(\w+)="(.*?)"', heading)), values


def numbers(text):
    return np.array(re.search(r"\((.*)\)", text).group(1).split(","), float)


def linear(values, name):
    """Colour times energy; `Color.srgb_to_linear` of Godot's core."""
    codes = numbers(values[f"{name}_color"])[:3]
    colour = np.where(codes < 0.04045, codes / 12.92, ((codes + 0.055) / 1.055) ** 2.4)
    return colour * float(values[f"{name}_energy"])


def radiance_of(scene, sky=None):
    """Radiance of a white matte surface at `NORMALS` by the shaders of Forward+.

    A light's energy is multiplied by pi, the matte surface divides by it, and 1 minus the cosine of
    the angular size is added to the cosine. Of a sky, roughness 1 has the mean weighted by cosines.
    """
    there, total = AXES["godot"].to_target(NORMALS), np.zeros((len(NORMALS), 3))
    for _, heading, values in sections(scene):
        if heading.get("type") == "DirectionalLight3D":
            towards = numbers(values["transform"])[:9].reshape(3, 3) @ [0, 0, 1]
            size = 1 - np.cos(np.deg2rad(float(values.get("light_angular_distance", 0))))
            cosine = np.clip(there @ towards + size, 0, 1)
            total += np.pi * linear(values, "light") * cosine[:, None] / np.pi
        if heading.get("type") == "Environment":
            is_colour = values["ambient_light_source"] == "2"
            total += linear(values, "ambient_light") if is_colour else sky.probe(NORMALS) / np.pi
    return total


def texture_of_file(path):
    """Path of the external resource, whose only escapes here are of quotes."""
    text = path.read_text(encoding="utf-8")
    return json.loads(re.search(r'path=("(?:[^"\\]|\\.)*") id="map"', text).group(1))


def irradiance_of_file(path):
    """Irradiance at `NORMALS` from a scene and the map beside it."""
    scene = path.read_text(encoding="utf-8")
    places = [heading["path"] for kind, heading, _ in sections(scene) if kind == "ext_resource"]
    sky = el.EnvMap.open(path.parent / places[0]) if places else None
    return np.pi * radiance_of(scene, sky)


@pytest.mark.parametrize("name", RIGS)
def test_by_formula_a_file_lights_as_the_rig_does(name, tmp_path):
    el.export.save_godot(RIGS[name], tmp_path / "rig.tscn")
    assert relative(irradiance_of_file(tmp_path / "rig.tscn"), RIGS[name].probe(NORMALS)) < 1e-4
    is_map = name in ("floor", "harmonics")
    assert (tmp_path / "rig.ambient.exr").exists() == is_map


def test_a_sun_has_its_size_and_wide_lamps_are_points():
    lights = [values for _, heading, values in sections(el.export.godot(DISCS)) if values]
    sizes = [values.get("light_angular_distance") for values in lights if "transform" in values]
    assert sizes == [str(np.rad2deg(2 * 0.00465)), None, None, None, None]
    # The addition to the cosine of the widest lamp that keeps its size.
    widest = el.Lights([[0, 1, 0]], [[1, 1, 1]], [np.deg2rad(0.75)])
    assert (
        relative(np.pi * radiance_of(el.export.godot(widest)), np.maximum(NORMALS[:, [1]], 0))
        < 2e-3
    )


def test_the_three_brightest_lights_cast_shadows():
    scene = el.export.godot(POINTS)
    assert scene.count("shadow_enabled = true") == 3
    assert scene.index("light_2") < scene.rindex("shadow_enabled") < scene.index("light_3")


def test_lights_beyond_eight_become_part_of_the_ambient_term():
    for rig, sky in ((RENDERED["many"], None), (MANY, SLOPES)):
        scene = el.export.godot(rig, sky)
        assert scene.count("DirectionalLight3D") == LAMPS
    total = radiance_of(el.export.godot(RENDERED["many"])) * np.pi
    normals, areas = el.kernels.icosphere(5120)
    rest = areas @ el.Rig([0.1, 0.2, 0.3], MANY[LAMPS:], 0.0).probe(normals) / areas.sum()
    kept = el.Rig([0, 0, 0], MANY[:LAMPS], 0.0).probe(NORMALS)
    np.testing.assert_allclose(total, kept + rest, rtol=1e-3)


def test_a_name_cannot_end_its_string():
    scene = el.export.godot(NOTHING, environment(), 'a"] [node.exr')
    assert 'path="a\\"] [node.exr" id="map"]' in scene


def test_without_light():
    dark = el.Lights([[0, 1, 0]], [[0, 0, 0]])
    assert not radiance_of(el.export.godot(dark)).any()


@pytest.fixture(scope="module")
def pictures(tmp_path_factory):
    """Pictures that Godot renders of each rig and of a sky, as codes from 0 to 255."""
    folder, files = tmp_path_factory.mktemp("godot"), {}
    for name, rig in RENDERED.items():
        el.export.save_godot(rig, folder / f"{name}.tscn")
        # The renderer Compatibility adds lights with shadows as sRGB codes.
        scene = (folder / f"{name}.tscn").read_text(encoding="utf-8")
        files[f"{name}.tscn"] = scene.replace("shadow_enabled = true", "")
    NOTHING.save(folder / "sky.tscn", environment=SLOPES)
    files["sky.tscn"] = (folder / "sky.tscn").read_text(encoding="utf-8")
    files |= import_of("sky.ambient.exr", el.EnvMap.open(folder / "sky.ambient.exr"))
    files["main.gd"] = godot.script(
        scenes=[*RENDERED, "sky"],
        sides=AXES["godot"].to_target(SIDES.reshape(-1, 3)).reshape(-1, 3, 3).tolist(),
        size=SIDE,
        width=SQUARE,
        exposure=EXPOSURE,
    )
    lines = godot.output_of(files)
    assert not [line for line in lines if "tscn" in line], lines
    words = [line.split() for line in lines if line.startswith("IMAGE")]
    assert len(words) == 2 * len(RENDERED) + 2, lines
    return {(name, int(side)): picture(text) for _, name, side, text in words}


def import_of(name, env):
    """Files that Godot's editor makes of a picture: where it is, and its pixels."""
    pixels = np.ones((env.height, env.width, 4), np.float16)
    pixels[..., :3] = env.radiance
    data = base64.b64encode(pixels.tobytes()).decode()
    image = (
        f'{{"data": PackedByteArray("{data}"), "format": "RGBAHalf", "height": {env.height},'
        f' "mipmaps": false, "width": {env.width}}}'
    )
    return {
        f"{name}.import": f'[remap]\nimporter="texture"\ntype="ImageTexture"\npath="res://{name}.tres"',
        f"{name}.tres": '[gd_resource type="ImageTexture" format=4]\n\n[sub_resource type="Image"'
        f' id="image"]\ndata = {image}\n\n[resource]\nimage = SubResource("image")\n',
    }


def picture(text):
    return np.frombuffer(base64.b64decode(text), np.uint8).reshape(SIDE, SIDE, 3).astype(float)


@godot.needs_godot
@pytest.mark.parametrize("name", RENDERED)
def test_the_ball_shows_the_irradiance_of_the_rig(name, pictures):
    """Within 2 codes; within 4 where sRGB has a steep slope, at the edge of a lamp alone."""
    rig = RENDERED[name]
    lamps, rest = (
        rig.lights[:LAMPS],
        rig.lights[LAMPS:].irradiance.sum(axis=0) / 4,
    )
    shown = el.Rig([0, 0, 0], el.Lights(lamps.direction, lamps.irradiance), 0.0)
    for k, side in enumerate(SIDES):
        normals, is_ball = normals_of(side)
        radiance = EXPOSURE * ((shown.probe(normals) + rest) / np.pi + rig.ambient)
        off = np.abs(pictures[name, k][is_ball] - 255 * encode_srgb(radiance))
        assert off.max() < (2 if rig.ambient.all() else 4)
        assert off.mean() < 0.5


@godot.needs_godot
def test_a_sky_lies_where_the_lights_are(pictures):
    """The renderer Compatibility takes its values as sRGB codes, so only directions count."""
    for k, side in enumerate(SIDES):
        normals, is_ball = normals_of(side)
        columns = np.insert(normals, 0, 1, axis=1)
        fitted = np.linalg.lstsq(columns, pictures["sky", k][is_ball], rcond=None)[0]
        for slope, towards in zip(fitted[1:].T, np.eye(3), strict=True):
            assert slope @ towards > 0.99 * np.linalg.norm(slope)
