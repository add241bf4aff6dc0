"""Radiance: irradiance as its own `rtrace` measures it."""

import os
from pathlib import Path

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES, radiance
from tests.export.balls import CAMERA, check_balls, environment, rays
from tests.export.rigs import AXES as LAMPS
from tests.export.rigs import DISCS, POINTS, relative, relative_error, rigs
from tests.helpers import NORMALS
from tests.reference.radiance import tokens

pyradiance = pytest.importorskip("pyradiance")

AMBIENT = ["-ab", "1", "-ad", "16384", "-as", "0", "-aa", "0", "-lw", "1e-9"]
#: Four normals of each face of the icosahedron: each traces thousands of rays.
SOME = NORMALS[::4]
RIGS = rigs(POINTS)


def irradiance(path, params, repeats=1, normals=NORMALS):
    """Irradiance on surfaces with these normals, (n, 3); pictures are beside the file."""
    there = AXES["radiance"].to_target(normals)
    lines = np.hstack([np.zeros_like(there), there]).repeat(repeats, axis=0)
    found = trace(path, lines, params, irradiance=True)
    return found.reshape(len(normals), repeats, 3).mean(axis=1)


def texture_of_file(path):
    """Name of the picture of the sky."""
    words = [text for kind, text in tokens(path) if kind == "word"]
    place = words.index("blue") + 1
    assert words[place + 1] == "."
    return words[place]


def irradiance_of_file(path):
    """Irradiance that `rtrace` measures in 16 runs of few rays; it starts in the file's folder."""
    options = ["-ab", "1", "-ad", "4096", "-as", "0", "-aa", "0", "-lw", "1e-9", "-dj", "1"]
    here = Path.cwd()
    os.chdir(path.parent)
    try:
        return irradiance(path, options, repeats=16)
    finally:
        os.chdir(here)


def trace(path, lines, params, **options):
    """Radiance that `rtrace` computes for rays (origin, direction), shape (n, 6)."""
    octree = path.with_suffix(".oct")
    octree.write_bytes(pyradiance.oconv(str(path)))
    text = "\n".join(" ".join(f"{value:.17g}" for value in line) for line in lines)
    found = pyradiance.rtrace(text.encode(), octree, header=False, params=params, **options)
    return np.array([line.split() for line in found.decode().splitlines()], float)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Radiance looks for pictures in the folder in which it runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_points_alone_are_exact(folder):
    POINTS.save(folder / "rig.rad")
    assert (
        relative_error(irradiance(folder / "rig.rad", ["-ab", "0", "-dt", "0"]), RIGS["none"])
        < 1e-6
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", RIGS)
@pytest.mark.parametrize("lights", [POINTS, DISCS], ids=["points", "discs"])
def test_the_irradiance_that_radiance_measures_is_that_of_the_rig(name, lights, folder):
    rig = rigs(lights)[name]
    rig.save(folder / "rig.rad")
    params, repeats = (["-dj", "1"], 16) if lights is DISCS else ([], 1)
    ambient = AMBIENT if repeats == 1 else ["-ab", "1", "-ad", "1024", *AMBIENT[4:]]
    found = irradiance(folder / "rig.rad", [*ambient, *params], repeats, SOME)
    assert relative_error(found, rig, SOME) < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("name", ["constant", "harmonics"])
def test_no_light_takes_the_sky_behind_it_away(name, folder):
    """Dim lamps before a bright sky; it was 5 % too dark where they stand."""
    dim = el.Lights(DISCS.direction, 1e-3 * DISCS.irradiance, [0.19] * 5)
    rig = rigs(dim)[name]
    rig.save(folder / "rig.rad")
    found = irradiance(folder / "rig.rad", AMBIENT, normals=SOME)
    assert relative_error(found, rig, SOME) < 0.01


@pytest.mark.parametrize("radius", [0.6, 1.2])
def test_a_wide_light_is_a_part_of_the_sky(radius, folder):
    """Written as a source, its error would be 2 % and 12 %."""
    wide = el.Lights(DISCS.direction[:1], DISCS.irradiance[:1], [radius])
    wide.save(folder / "rig.rad")
    found = irradiance(folder / "rig.rad", AMBIENT, normals=SOME)
    assert relative_error(found, rigs(wide)["none"], SOME) < 0.005


def test_a_map_lies_where_the_lights_are(folder):
    large = el.Lights(DISCS.direction, DISCS.irradiance, [0.4] * 5)
    env = el.Rig([0.5] * 3, large, error=0.0).to_map(128)
    el.Lights(np.eye(3), np.eye(3)).save(folder / "rig.rad", environment=env)
    found = irradiance(folder / "rig.rad", AMBIENT, normals=SOME)
    wanted = env.probe(SOME) + np.maximum(SOME, 0)
    assert np.linalg.norm(found - wanted) < 0.01 * np.linalg.norm(wanted)


def test_a_map_from_a_radiance_file_is_not_brightened(folder):
    """Its mantissas are whole, and Radiance adds half a step: that was 0.25 %."""
    env = el.EnvMap(np.full((64, 128, 3), 200 / 512, np.float32))
    POINTS[:0].save(folder / "rig.rad", environment=env)
    found = irradiance(folder / "rig.rad", AMBIENT, normals=SOME)
    assert found.mean() == pytest.approx(np.pi * 200 / 512, rel=5e-4)


def test_each_pixel_of_a_map_is_seen_in_its_direction(folder):
    """Radiance takes the outer pixels for the edges: the sky was off by half a pixel."""
    env = el.EnvMap(el.synthetic.hall(32).radiance)
    POINTS[:0].save(folder / "rig.rad", environment=env)
    directions = el.kernels.pixel_directions(32, 64).reshape(-1, 3)
    there = AXES["radiance"].to_target(directions)
    seen = trace(folder / "rig.rad", np.hstack([0 * there, there]), ["-ab", "0"])
    wanted = env.radiance.reshape(-1, 3)
    assert (np.abs(seen - wanted).max(axis=1) < 0.01 * wanted.max(axis=1)).all()


@pytest.mark.slow
def test_the_parts_of_a_split_map_light_as_the_map(folder):
    env = el.Rig([0.2, 0.3, 0.5], DISCS[:1], error=0.0).to_map(128)
    el.split(env).save(folder / "sun.rad")
    normals = NORMALS[::8]
    ambient = ["-dj", "1", "-ab", "1", "-ad", "4096", *AMBIENT[4:]]
    found = irradiance(folder / "sun.rad", ambient, 8, normals)
    assert relative(found, env.probe(normals)) < 0.01
    np.testing.assert_allclose(found.mean(axis=0), env.probe(normals).mean(axis=0), rtol=3e-3)


BALLS = """
void plastic matte 0 0 5 1 1 1 0 0
void metal mirror 0 0 5 1 1 1 1 0
matte sphere left 0 0 4 {} 1
mirror sphere right 0 0 4 {} 1
"""


def test_map_and_lights_meet_on_two_balls(folder):
    LAMPS.save(folder / "balls.rad", environment=environment())
    right, _, _ = AXES["radiance"].to_target(CAMERA)
    with (folder / "balls.rad").open("a") as file:
        file.write(BALLS.format(*(" ".join(map(str, x * right)) for x in (-1.05, 1.05))))
    origin, direction = (AXES["radiance"].to_target(each) for each in rays())
    image = trace(folder / "balls.rad", np.hstack([origin, direction]), ["-ab", "1", "-ad", "256"])
    image = image.reshape(128, 256, 3)
    el.io.write_exr(folder / "balls.exr", image.astype(np.float32))
    check_balls(image)


def test_black_lights_and_no_lights_are_read(folder):
    nothing = el.Rig([0, 0, 0], POINTS[:0], error=0.0)
    nothing.save(folder / "rig.rad")
    assert "source" not in radiance(nothing)
    assert not irradiance(folder / "rig.rad", ["-ab", "0"], normals=NORMALS[:1]).any()
