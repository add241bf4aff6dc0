"""Direct light in closed form is that of rays, within their noise."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.kernels.solids import Stage
from envlights.scene.solids import blocked_by, source_light

SOLIDS = (
    el.scene.Ball((-0.65, 0.5, 0.1), 0.5),
    el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), 0.5),
    el.scene.Box((0, -50, 0), (1000, 50, 1000)),
)
LIGHTS = el.Lights(
    [[0.48, 0.8, 0.36], [-0.6, 0.64, -0.48], [0, 0.28, 0.96]],
    [[3, 2, 1], [1, 1.5, 2], [0.5, 0.5, 0.4]],
    [0.0, 0.6, 0.25],
)
HARMONICS = np.random.default_rng(0).normal(size=(9, 3)) * 0.1
HARMONICS[0] = 3.0


def surface():
    """Texels of the floor, of the ball and of the upper side of the box."""
    x, z = np.meshgrid(np.linspace(-1.9, 1.9, 24), np.linspace(-1.9, 1.9, 24))
    floor = np.stack([x, 0 * x, z], axis=-1).reshape(-1, 3)
    normals, _ = kernels.icosphere(320)
    ball = np.array(SOLIDS[0].centre) + 0.5 * normals
    top = np.array([[0.65, 0.8, -0.1]])
    up = np.array([[0.0, 1, 0]])
    points = np.vstack([floor, ball, top])
    normals = np.vstack([np.tile(up, (len(floor), 1)), normals, up])
    return el.scene.Surface(points[None], normals[None], np.full((1, len(points), 3), np.pi))


@pytest.mark.parametrize("ambient", [[0.3, 0.2, 0.4], HARMONICS])
def test_the_closed_form_is_that_of_rays_within_their_noise(ambient):
    rig = el.Rig(ambient, LIGHTS, error=0.0)
    texels = surface()
    exact = el.scene.DirectLight.of_solids(texels, SOLIDS).image(rig)
    rays = el.scene.DirectLight.of(texels, blocked_by(SOLIDS), 1024)
    traced = el.scene.DirectLight(texels, rays.blocked, rays.sky, rays=1024).image(rig)
    scale = rig.probe([[0, 1, 0]]).mean()
    difference = (exact - traced) / scale
    # A point light is hidden or not: rays start above the surface, so a few texels may differ.
    assert np.median(np.abs(difference)) < 1e-3
    assert np.abs(difference.mean()) < 5e-4
    assert np.quantile(np.abs(difference), 0.99) < 0.01
    assert np.abs(exact).max() > 0.3 * scale


def test_harmonics_of_order_0_are_a_constant_sky():
    constant = np.zeros((9, 3))
    constant[0] = np.sqrt(4 * np.pi) * np.array([1, 2, 3])
    light = el.scene.DirectLight.of_solids(surface(), SOLIDS)
    images = [light.image(el.Rig(each, LIGHTS, error=0.0)) for each in ([1, 2, 3], constant)]
    np.testing.assert_allclose(*images, rtol=1e-12, atol=1e-12)


def test_the_hidden_light_is_no_more_than_all_light():
    texels = surface()
    stage = Stage(SOLIDS, texels.position[0], texels.normal[0])
    light = source_light(el.Rig([1, 2, 3], LIGHTS, error=0.0), stage)
    assert light.whole.shape == light.hidden.shape == (4, texels.position.shape[1], 3)
    assert (light.hidden <= light.whole).all()
    assert (light.hidden >= 0).all()


def test_rays_meet_a_polyhedron_where_they_meet_the_same_box():
    box = el.scene.Box((0.2, 0.4, 0), (0.4, 0.3, 0.2), 0.3)
    solid = el.scene.Polyhedron(box.vertices, box.faces)
    origins = np.random.default_rng(1).normal(size=(2000, 3))
    towards = np.random.default_rng(2).normal(size=(2000, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    one, other = (blocked_by((each,))(origins, towards) for each in (box, solid))
    np.testing.assert_array_equal(one, other)
    assert 20 < one.sum() < 1000


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize("solid", [el.scene.Ball, el.scene.Box], ids=["ball", "box"])
def test_points_lie_on_a_solid_by_a_tolerance_relative_to_its_size(solid, size):
    centre = np.array([0.5, 0.25, -0.25]) * size
    made = solid(centre, size if solid is el.scene.Ball else [size] * 3)
    steps = np.array([1 - 1e-4, 1 - 1e-8, 1.0, 1 + 1e-8, 1 + 1e-4])
    points = centre + size * steps[:, None] * [1.0, 0, 0]
    normals = made.normals_at(points)
    is_on = np.isfinite(normals).all(axis=2).any(axis=1)
    assert is_on.tolist() == [False, True, True, True, False]
    np.testing.assert_allclose(np.nansum(normals[is_on], axis=1), [[1.0, 0, 0]] * 3, atol=1e-9)
