"""Images of solids on a floor in closed form, against Mitsuba and against closed forms."""

import numpy as np
import pytest

import envlights as el
from envlights.scene.camera import FLOOR, Camera, first_surfaces
from envlights.scene.closed_form import closed_form, shade, shade_directly
from envlights.scene.mitsuba.path_traced import SolidsOnFloor, Still, Texture, path_traced
from envlights.scene.panorama_floor import background, floor_albedo, radiance_at
from envlights.scene.view_image import true_view, view_image

SOLIDS = (
    el.scene.Ball((-0.65, 0.5, 0.1), 0.5),
    el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), np.pi / 6),
)
SCENE = SolidsOnFloor(SOLIDS, np.full((2, 3), 0.7), np.array([0.3, 0.2, 0.1]))
CAMERA = Camera((1.6, 2.2, 3.9), (0, 0.3, 0), 40, 80, 45)
UP = np.array([[0.0, 1.0, 0.0]])


@pytest.fixture(scope="module")
def env():
    return el.EnvMap(el.synthetic.hall(128).radiance)


@pytest.fixture(scope="module")
def rig(env):
    return el.fit(env, 4, floor=True)


def test_the_middle_ray_goes_to_the_target():
    rays = Camera((1, 2, 3), (-2, 0.5, 1), 60, 3, 5).rays()
    towards = np.array([-3, -1.5, -2])
    np.testing.assert_allclose(rays.directions[7], towards / np.linalg.norm(towards), atol=1e-12)


def test_rays_at_the_edges_span_the_field_of_view():
    """The outermost points are half a column inside of the edges."""
    directions = Camera((0, 1, 0), (0, 1, -1), 90, 1000, 1).rays().directions
    np.testing.assert_allclose(directions[0, 0] / -directions[0, 2], -0.999, rtol=1e-9)
    np.testing.assert_allclose(directions[-1, 0] / -directions[-1, 2], 0.999, rtol=1e-9)


def test_surfaces_are_on_their_solids():
    sight = first_surfaces(CAMERA.rays(2), SOLIDS)
    ball, box = (sight.points[sight.own == row] for row in (0, 1))
    away = ball - SOLIDS[0].centre
    np.testing.assert_allclose(np.linalg.norm(away, axis=1), 0.5, rtol=1e-12)
    np.testing.assert_allclose(sight.normals[sight.own == 0], 2 * away, atol=1e-9)
    normals, distances = SOLIDS[1].planes()
    heights = box @ normals.T - distances
    np.testing.assert_allclose(heights.max(axis=1), 0, atol=1e-12)
    assert np.isin(sight.own, (FLOOR, 0, 1)).all()


def test_an_empty_floor_has_the_probe_of_the_rig(rig):
    scene = SolidsOnFloor((), np.zeros((0, 3)), SCENE.floor_albedo)
    image = closed_form(rig, scene, CAMERA, 1)
    wanted = scene.floor_albedo / np.pi * rig.probe(UP)[0]
    np.testing.assert_allclose(image, np.broadcast_to(wanted, image.shape), rtol=1e-12)


def test_a_texture_of_one_colour_changes_nothing(rig):
    texture = Texture(np.broadcast_to(SCENE.floor_albedo, (8, 8, 3)), 5.0)
    images = (closed_form(rig, s, CAMERA, 1) for s in (SCENE, SCENE._replace(texture=texture)))
    np.testing.assert_allclose(*images, rtol=1e-12)


def test_a_texture_is_linear_between_its_pixels():
    ramp = np.zeros((4, 4, 3)) + np.arange(4)[:, None, None] + 10 * np.arange(4)[:, None]
    points = np.array([[0.3, 0, -0.2], [-1.4, 0, 1.0]])
    wanted = (points[:, 2] + 1.5) + 10 * (points[:, 0] + 1.5)
    np.testing.assert_allclose(Texture(ramp, 2.0).at(points)[:, 0], wanted)


def test_the_panorama_is_seen_as_it_is_from_its_camera(env):
    """From the position of its camera, the ground projection changes nothing."""
    rays = Camera((0, 1.6, 0), (1, 1.2, 2), 80, 40, 30).rays()
    found = background(env, rays, dome=1e9)
    np.testing.assert_allclose(found, radiance_at(env, rays.directions), rtol=1e-6)


def test_pixel_centres_of_a_map_are_read_exactly(env):
    directions = el.kernels.pixel_directions(128, 256).reshape(-1, 3)
    found = radiance_at(env, directions).reshape(128, 256, 3)
    np.testing.assert_allclose(found, env.radiance, rtol=1e-5, atol=1e-7)


def test_a_floor_under_a_white_sky_has_its_albedo():
    rows = np.arange(64)[:, None, None] < 32
    env = el.EnvMap(np.where(rows, 1.0, [0.5, 0.3, 0.1]) * np.ones((64, 128, 3)))
    np.testing.assert_allclose(floor_albedo(env), [0.5, 0.3, 0.1], rtol=1e-4)


def test_without_solids_the_view_is_the_panorama(env, rig):
    scene = SolidsOnFloor((), np.zeros((0, 3)), SCENE.floor_albedo)
    camera = Camera((1, 1.2, 2), (0, 0.8, 0), 80, 40, 30)
    wanted = camera.pixels(background(env, camera.rays(2)), 2)
    np.testing.assert_allclose(view_image(env, rig, scene, camera, 2), wanted, rtol=1e-9)


@pytest.mark.mitsuba
@pytest.mark.slow
def test_both_cameras_see_the_same_outlines():
    """Only the solids reflect light, so that the image is a mask of them, within one pixel."""
    pytest.importorskip("mitsuba")
    rig = el.Rig(np.ones(3), el.Lights([[0, 1, 0]], [[1, 1, 1]])[:0], 0.0)
    scene = SCENE._replace(floor_albedo=np.zeros(3))
    traced = path_traced(rig, scene, CAMERA, 128, bounces=1).image[..., 0]
    sight = first_surfaces(CAMERA.rays(8), SOLIDS)
    coverage = CAMERA.pixels((sight.own >= 0).astype(float), 8)
    near = np.pad(coverage, 1, mode="edge")
    shifts = [near[y : y + 45, x : x + 80] for y in range(3) for x in range(3)]
    assert (traced[np.min(shifts, axis=0) == 1] > 0.01).all()
    assert (traced[np.max(shifts, axis=0) == 0] == 0).all()
    assert 0.1 < coverage.mean() < 0.5


@pytest.mark.mitsuba
@pytest.mark.slow
def test_direct_light_is_that_of_mitsuba(rig):
    """Away from outlines, which 6x6 points sample coarsely; noise by two images is removed."""
    pytest.importorskip("mitsuba")
    traced = path_traced(rig, SCENE, CAMERA, 128, bounces=1)
    image = closed_form(rig, SCENE, CAMERA, 6, shade_directly)
    own = first_surfaces(CAMERA.rays(6), SOLIDS).own[:, None].astype(float)
    inside = CAMERA.pixels(own, 6) == CAMERA.pixels(own, 6).round()
    traced = Still(*(half * inside for half in traced))
    image *= inside
    assert traced.noise < 0.02
    assert Still(image, image).error(traced) < 0.006


@pytest.mark.mitsuba
@pytest.mark.slow
def test_all_light_is_nearly_that_of_mitsuba(rig):
    """The model of reflected light has about 1 % error here; without it, over 3 %."""
    pytest.importorskip("mitsuba")
    traced = path_traced(rig, SCENE, CAMERA, 128)
    image, direct = (closed_form(rig, SCENE, CAMERA, 6, way) for way in (shade, shade_directly))
    assert traced.noise < 0.02
    assert Still(image, image).error(traced) < 0.015
    assert Still(direct, direct).error(traced) > 0.03


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_textured_floor_lies_alike_in_mitsuba():
    pytest.importorskip("mitsuba")
    albedo = np.full((16, 16, 3), 0.1)
    albedo[2:5, 2:12], albedo[9:14, 9:11] = [0.8, 0.2, 0.2], [0.2, 0.2, 0.8]
    empty = SolidsOnFloor((), np.zeros((0, 3)), np.full(3, 0.1), Texture(albedo, 2.0))
    rig = el.Rig(np.ones(3), el.Lights([[0, 1, 0]], [[1, 1, 1]])[:0], 0.0, floor=True)
    traced = path_traced(rig, empty, CAMERA, 128, bounces=1)
    image = closed_form(rig, empty, CAMERA, 6)
    assert Still(image, image).error(traced) < 0.003


@pytest.mark.mitsuba
@pytest.mark.slow
def test_the_true_view_is_near_that_of_the_rig(env, rig):
    pytest.importorskip("mitsuba")
    truth = true_view(env, rig, SCENE, CAMERA, 72)
    image = view_image(env, rig, SCENE, CAMERA, 6)
    assert Still(image, image).error(truth) < 0.03
