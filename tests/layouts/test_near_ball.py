"""Mirror balls near the camera: rays of a pinhole camera, reflected by a unit sphere."""

import numpy as np
import pytest

import envlights as el
from envlights.io import Layout

#: Angles from the direction to the camera and around it, in degrees.
PLACES = [(0, 0), (30, 20), (90, 140), (120, 10), (150, -60)]
RADIUS = np.deg2rad(2.0)


def towards(angle, around):
    a, p = np.deg2rad([angle, around])
    return np.array([np.sin(a) * np.cos(p), np.sin(a) * np.sin(p), np.cos(a)])


def photograph(lamps, distance, n=256, times=4):
    """Picture by a camera at +z that looks along -z, with +x on its right; white outside."""
    half = 1 / np.sqrt(distance**2 - 1)
    at = (2 * (np.arange(n * times) + 0.5) / (n * times) - 1) * half
    x, y = np.meshgrid(at, -at)
    ray = np.stack([x, y, -np.ones_like(x)], axis=-1)
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    eye = np.array([0, 0, distance])
    along = -ray @ eye
    root = along**2 - (distance**2 - 1)
    normal = eye + (along - np.sqrt(np.maximum(root, 0)))[..., None] * ray
    seen = ray - 2 * (ray * normal).sum(axis=-1, keepdims=True) * normal
    image = np.full((*x.shape, 3), 0.1)
    for lamp in lamps:
        image[seen @ lamp > np.cos(RADIUS)] = 50.0
    image[root < 0] = 1.0
    return image.reshape(n, times, n, times, 3).mean(axis=(1, 3)), root >= 0


def degrees(one, other):
    return np.rad2deg(np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other))


@pytest.mark.parametrize("distance", [1.5, 3.0, 5.0, 20.0])
def test_lamps_are_where_their_rays_come_from(distance):
    picture, _ = photograph([towards(*place) for place in PLACES], distance)
    env = el.EnvMap(picture, layout=Layout.mirror_ball(distance=distance), width=720)
    found = el.detect(env)
    hidden = 180 - np.rad2deg(np.arcsin(1 / distance))
    for place in PLACES:
        if place[0] + 5 < hidden:
            # Pixels near the rim are many degrees long.
            most = 0.2 if place[0] + 20 < hidden else 2.5
            off = min(degrees(each, towards(*place)) for each in found.direction)
            assert off < most, place


def test_a_lamp_keeps_its_irradiance():
    """The pixels are 3 degrees long at 120 degrees; a far ball of this size is 3 % off there."""
    for place in PLACES[:4]:
        picture, _ = photograph([towards(*place)], 5.0)
        env = el.EnvMap(picture, layout=Layout.mirror_ball(distance=5.0), width=720)
        received = env.probe(towards(*place), fill=0.1)[0]
        expected = 0.1 * np.pi + 49.9 * np.pi * np.sin(RADIUS) ** 2
        assert received == pytest.approx(expected, rel=0.035), place


@pytest.mark.parametrize("distance", [1.5, 5.0])
def test_the_cone_behind_the_ball_is_not_seen(distance):
    env = el.EnvMap(photograph([], distance)[0], layout=Layout.mirror_ball(distance=distance))
    blind = (1 - np.sqrt(1 - 1 / distance**2)) / 2
    assert 1 - env.coverage_fraction == pytest.approx(blind, rel=0.02)
    angle = np.rad2deg(np.arcsin(1 / distance))
    assert any(f"hides {angle:.3g} degrees around -z" in note for note in env.notes)
    inside = env.radiance[env.coverage == 1]
    assert np.median(inside) == pytest.approx(0.1, abs=1e-6)


def test_a_far_camera_needs_no_distance():
    picture, _ = photograph([towards(90, 140)], 1e4)
    far = el.EnvMap(picture, layout="mirror-ball", width=256)
    near = el.EnvMap(picture, layout=Layout.mirror_ball(distance=1e4), width=256)
    np.testing.assert_allclose(near.probe(np.eye(3), fill=0.1), far.probe(np.eye(3)), rtol=2e-3)


def test_the_circle_may_lie_anywhere():
    picture, _ = photograph([towards(90, 140)], 5.0, n=128)
    wide = np.ones((150, 200, 3))
    wide[10:138, 40:168] = picture
    layout = Layout.mirror_ball(circle=(104, 74, 64), distance=5.0)
    env = el.EnvMap(wide, layout=layout, width=256)
    same = el.EnvMap(picture, layout=Layout.mirror_ball(distance=5.0), width=256)
    is_inside = (env.coverage == 1) & (same.coverage == 1)
    is_inside[np.abs(np.diff(same.coverage, axis=0, prepend=1)) > 0] = False
    inner = is_inside & np.roll(is_inside, 3, 0) & np.roll(is_inside, -3, 0)
    inner &= np.roll(is_inside, 3, 1) & np.roll(is_inside, -3, 1)
    assert inner.mean() > 0.9
    np.testing.assert_allclose(env.radiance[inner], same.radiance[inner], atol=1e-3)


@pytest.mark.parametrize("distance", [1, 0.5, -2, np.inf, "far"])
def test_a_camera_inside_the_ball_is_refused(distance):
    with pytest.raises(el.EnvLightsError, match="distance must be"):
        Layout.mirror_ball(distance=distance)


def test_other_projections_have_no_distance():
    with pytest.raises(el.EnvLightsError, match="distance is no argument of"):
        el.EnvMap(np.ones((8, 8, 3)), layout=Layout("angular", distance=3.0))
    with pytest.raises(el.EnvLightsError, match="distance"):
        el.EnvMap(np.ones((8, 16, 3))).to(Layout.mirror_ball(distance=3.0))
