"""pbrt-v4, checked by the formulas of its book, because no package has the renderer."""

import numpy as np
import pytest

import envlights as el
from envlights.export import AXES
from tests.export.rigs import DISCS, POINTS, relative_error, rigs
from tests.helpers import NORMALS
from tests.reference import pbrt

THERE = AXES["pbrt"].to_target(NORMALS)


def texture_of_file(path):
    """Name of the map of the infinite light."""
    return pbrt.light_sources(path)[-1][1]["filename"]


def irradiance_of_file(path):
    """Irradiance at `NORMALS` by the formulas of pbrt's book."""
    return pbrt.irradiance(path, THERE)


@pytest.mark.parametrize("lights", [POINTS, DISCS], ids=["points", "discs"])
@pytest.mark.parametrize("name", ["none", "constant", "floor", "harmonics"])
def test_the_irradiance_by_the_book_is_that_of_the_rig(name, lights, tmp_path):
    rig = rigs(lights)[name]
    rig.save(tmp_path / "rig.pbrt")
    kinds = [kind for kind, _ in pbrt.light_sources(tmp_path / "rig.pbrt")]
    in_map = name in ("floor", "harmonics") or lights is DISCS
    assert kinds.count("infinite") == (name != "none" or lights is DISCS)
    # Only the sun is so small that it is a distant light.
    assert kinds.count("distant") == (1 if lights is DISCS else 5)
    limit = 0.003 if in_map else 1e-6
    assert relative_error(pbrt.irradiance(tmp_path / "rig.pbrt", THERE), rig) < limit


def test_squares_and_spheres_are_inverse():
    """The map to the square of the book, and the one from it."""
    directions = pbrt.square_directions(64)
    grid = (np.arange(64) + 0.5) / 64
    uv = np.stack(np.meshgrid(grid, grid), axis=-1).reshape(-1, 2)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1, atol=1e-12)
    np.testing.assert_allclose(pbrt.sphere_to_square(directions), uv, atol=1e-12)


def test_a_map_keeps_its_flux(tmp_path):
    """Small discs too; samples of the map at 3x3 points of a pixel lost 0.2 % of one."""
    lamp = el.Lights([[0.6, 0.64, 0.48]], [[3, 2, 1]], [0.03])
    env = el.Rig([0.1, 0.1, 0.1], lamp, 0.0).to_map(256)
    lamp[:0].save(tmp_path / "rig.pbrt", environment=env)
    square = el.io.read_image(tmp_path / "rig.ambient.pbrt.exr").pixels.reshape(-1, 3)
    angles = el.kernels.pixel_solid_angles(*env.radiance.shape[:2]) / (4 * np.pi)
    mean = np.einsum("yx,yxc->c", angles, env.radiance, dtype=float)
    np.testing.assert_allclose(square.mean(axis=0, dtype=float), mean, rtol=1e-6)


@pytest.mark.parametrize("axis", range(3))
def test_a_map_lies_where_the_lights_are(axis, tmp_path):
    """One light on an axis, beside a map of it: both in the same direction there."""
    lamp = el.Lights(np.eye(3)[[axis]], [[1, 1, 1]])
    spot = el.Lights(lamp.direction, lamp.irradiance, [0.1])
    lamp.save(tmp_path / "rig.pbrt", environment=spot.to_map(64))
    (_, light), (_, sky) = pbrt.light_sources(tmp_path / "rig.pbrt")
    np.testing.assert_array_equal(light["from"], AXES["pbrt"].to_target(lamp.direction)[0])
    square = el.io.read_image(tmp_path / sky["filename"]).pixels
    centre = square[..., 0].reshape(-1) @ pbrt.square_directions(len(square))
    assert centre / np.linalg.norm(centre) @ light["from"] > np.cos(0.005)


def test_the_panorama_that_imgtool_converts_agrees_with_the_lights():
    """`imgtool makeequiarea` takes u = phi / 2 pi, v = theta / pi of pbrt's z up."""
    env_directions = el.kernels.pixel_directions(16, 32)
    x, y, z = np.moveaxis(AXES["pbrt"].to_target(env_directions.reshape(-1, 3)), 1, 0)
    u = np.arctan2(y, x) / (2 * np.pi) % 1
    v = np.arccos(z) / np.pi
    np.testing.assert_allclose(
        u.reshape(16, 32), (np.arange(32) + 0.5)[None] / 32 + 0 * env_directions[..., 0]
    )
    np.testing.assert_allclose(
        v.reshape(16, 32), (np.arange(16) + 0.5)[:, None] / 16 + 0 * env_directions[..., 0]
    )
