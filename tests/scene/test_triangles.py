"""Rays to the triangles of a scene against Mitsuba's own rays."""

import numpy as np
import pytest

import envlights as el

mi = pytest.importorskip("mitsuba")

from envlights.scene.mitsuba.chart_rays import mitsuba_hits  # noqa: E402, needs Mitsuba
from envlights.scene.mitsuba.renderer import mitsuba  # noqa: E402, needs Mitsuba


def scene(*more):
    """Meshes and rectangles in all orientations: flipped, mirrored, stretched."""
    place = mi.ScalarTransform4f
    shapes = [
        {"type": "cube", "to_world": place().translate([-3, 0, 0])},
        {"type": "cube", "to_world": place().translate([3, 0, 0]), "flip_normals": True},
        {"type": "cube", "to_world": place().translate([0, 3, 0]).scale([-1, 1, 1])},
        {"type": "rectangle", "to_world": place().translate([0, 0, -3])},
        {"type": "rectangle", "to_world": place().scale([2, 0.5, -1]), "flip_normals": True},
        {"type": "rectangle", "to_world": place().translate([0, -3, 0]).scale([-1, 1, 1])},
        *more,
    ]
    return {"type": "scene", **{f"shape_{k}": shape for k, shape in enumerate(shapes)}}


def rays(count=4000):
    """Rays from a sphere around the scene to points in it."""
    rng = np.random.default_rng(0)
    origins, ends = rng.normal(size=(2, count, 3))
    origins *= 8 / np.linalg.norm(origins, axis=1, keepdims=True)
    directions = 2.5 * ends - origins
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


@pytest.fixture(scope="module")
def seen():
    """First hits of our triangles and of Mitsuba."""
    with mitsuba():
        whole = el.scene.MitsubaScene(scene(), lightmap=16)
    with mitsuba() as ours:
        theirs = mitsuba_hits(ours, whole._scene, whole._shapes)(*rays())
    return whole._triangles.hits(*rays()), theirs


def test_rays_hit_the_shapes_that_mitsuba_hits(seen):
    ours, theirs = seen
    assert set(ours.shape) == set(range(-1, 6))
    np.testing.assert_array_equal(ours.shape, theirs.shape)


def test_texture_coordinates_are_mitsubas(seen):
    ours, theirs = seen
    hit = ours.shape >= 0
    np.testing.assert_allclose(ours.uv[hit], theirs.uv[hit], atol=1e-5)


def test_sides_are_mitsubas(seen):
    ours, theirs = seen
    for shape in range(6):
        hit = ours.shape == shape
        assert hit.any()
        np.testing.assert_array_equal(ours.is_front[hit], theirs.is_front[hit])


def test_a_scene_with_a_sphere_has_the_same_prior_by_rays_of_mitsuba():
    """The sphere is inside a cube, so the other charts must be those of the scene without it."""
    away = {"type": "sphere", "center": [-3, 0, 0], "radius": 0.5}
    with mitsuba():
        one, two = (
            el.scene.MitsubaScene(scene(), lightmap=48),
            el.scene.MitsubaScene(scene(away), lightmap=48),
        )
    assert two._triangles is None
    ends = rays(500)
    np.testing.assert_array_equal(one.blocked(*ends), two.blocked(*ends))
    with mitsuba():
        first, second = (each.gather(rays=16) for each in (one, two))
    # Compare the charts of the six shapes in both.
    texels = [np.where(each.covered)[0] < 32 for each in (first, second)]
    ours, theirs = (each.hits[some] for each, some in zip((first, second), texels, strict=True))
    # Rays of single precision may end in the texel beside.
    assert np.abs(ours.astype(int) - theirs).sum() < 1e-3 * ours.sum()
