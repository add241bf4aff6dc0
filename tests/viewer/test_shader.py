"""The shaders of a page, against the kernel and against `Rig.probe`."""

import numpy as np
import pytest

import envlights as el
from envlights import _native
from envlights._srgb import encode_srgb
from tests.viewer import things
from tests.viewer.browser import needs_browser, run

pytestmark = needs_browser

HIDDEN = "(jobs) => jobs.map((job) => envlights.hidden({ off: [], shadows: 'exact', ...job }))"
RENDER = (
    "(options) => [{ ...envlights.state, floor: envlights.data.floor }, envlights.render(options)]"
)
#: Points for each arrangement of things and lights, lights, and arrangements.
POINTS, LIGHTS, ARRANGEMENTS = 250, 8, 8
WIDTH, HEIGHT = 160, 90


def unit(vectors):
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    path = tmp_path_factory.mktemp("pages") / "page.html"
    el.view(el.Rig([0.2, 0.3, 0.4], el.Lights([[0, 1, 0]], [[2, 2, 1]], [0.2]), 0.0)).save(path)
    return path


def random_things(rng):
    """Ball and box on the floor, near each other and apart."""
    box = [*rng.uniform(-1, 1, 2), *rng.uniform(0.2, 0.6, 3), rng.uniform(0, 90)]
    angle, radius = rng.uniform(0, 2 * np.pi), rng.uniform(0.2, 0.6)
    away = np.hypot(box[2], box[4]) + radius + rng.uniform(0.02, 1)
    return [box[0] + away * np.cos(angle), box[1] + away * np.sin(angle), radius], box


def random_points(rng, ball, box):
    """Points of floor, ball and box in turn, with their normals and things."""
    own = np.resize([things.FLOOR, things.BALL, things.BOX], POINTS)
    normals = np.where(
        (own == things.FLOOR)[:, None], [0, 1, 0], unit(rng.normal(size=(POINTS, 3)))
    )
    points = rng.uniform(-3, 3, (POINTS, 3)) * [1, 0, 1]
    turn, half, middle = things.rotation(box[5]), np.array(box[2:5]), [box[0], box[3], box[1]]
    under = (np.abs((points - middle) @ turn) <= half * [1, np.inf, 1]).all(axis=1)
    points[under] += [9, 0, 0]
    on_ball = own == things.BALL
    points[on_ball] = [ball[0], ball[2], ball[1]] + ball[2] * normals[on_ball]
    inside, face = rng.uniform(-1, 1, (POINTS, 3)), rng.integers(3, size=POINTS)
    inside[np.arange(POINTS), face] = rng.choice([-1, 1], POINTS)
    outward = np.eye(3)[face] * np.sign(inside[np.arange(POINTS), face])[:, None]
    on_box = own == things.BOX
    points[on_box] = ((inside * half) @ turn.T + middle)[on_box]
    normals[on_box] = (outward @ turn.T)[on_box]
    return points.astype(np.float32).astype(float), normals, own


def random_lights(rng):
    """Directions from below the horizon on, and radii of 0.1 to 80 degrees."""
    up, around = np.deg2rad(rng.uniform(-10, 85, LIGHTS)), rng.uniform(0, 2 * np.pi, LIGHTS)
    across = np.cos(up)
    directions = np.stack([across * np.sin(around), np.sin(up), across * np.cos(around)], axis=1)
    return directions, np.deg2rad(np.geomspace(0.1, 80, LIGHTS)[rng.permutation(LIGHTS)])


def test_hidden_shares_are_those_of_the_kernel(page):
    rng = np.random.default_rng(7)
    jobs, shares, factors = [], [], []
    for turn in range(ARRANGEMENTS):
        (ball, box), (directions, radii) = random_things(rng), random_lights(rng)
        points, normals, own = random_points(rng, ball, box)
        stage = things.stage(things.solids(ball, box), points, normals, own)
        is_floor = turn % 3 != 2
        shares.append(_native.hidden_fractions(stage, directions, radii, is_floor))
        factors.append(_native.form_factors(stage))
        lights = np.hstack([directions, np.ones((LIGHTS, 3)), radii[:, None]]).tolist()
        rig = {"ambient": [[1, 1, 1]], "floor": is_floor, "lights": lights}
        rows = np.hstack([points, own[:, None] + 1]).tolist()
        same = {"ball": ball, "box": box, "rig": rig, "points": rows, "normals": normals.tolist()}
        jobs += [{**same, "column": column} for column in range(-2, LIGHTS)]
    found = np.array(run(page, HIDDEN, jobs)["result"], float)
    found = found.reshape(ARRANGEMENTS, LIGHTS + 2, POINTS, 4).transpose(0, 2, 1, 3)
    wrong = found[..., 1:, 0] - np.array(shares)
    assert np.isfinite(found).all()
    assert np.abs(wrong).max() < 1e-3
    assert np.sqrt((wrong**2).mean()) < 2e-4
    own = np.resize([things.FLOOR, things.BALL, things.BOX], POINTS)
    # The column of form factors serves the things, that of the ambient term the floor.
    on_floor = np.where((own == things.FLOOR)[:, None], found[:, :, 1, 1:3], found[:, :, 0, 1:3])
    is_other = own[:, None] != [things.BALL, things.BOX]
    assert np.abs(np.where(is_other, on_floor - np.array(factors), 0)).max() < 1e-5


def rig_of_page(rig):
    lights = np.hstack(
        [rig.lights.direction, rig.lights.irradiance, rig.lights.angular_radius[:, None]]
    )
    return {
        "ambient": np.atleast_2d(rig.ambient).tolist(),
        "floor": rig.floor,
        "lights": lights.tolist(),
    }


RIGS = {
    "discs": el.Rig(
        [0.3, 0.4, 0.5],
        el.Lights(
            [[0.6, 0.64, 0.48], [-0.6, 0.8, 0]], [[3, 2.8, 2.2], [0.5, 0.6, 0.9]], [0.005, 0.5]
        ),
        0.0,
        floor=True,
    ),
    "points": el.Rig(
        [0.3, 0.4, 0.5], el.Lights([[0.6, 0.64, 0.48]], [[3, 2.8, 2.2]]), 0.0, floor=True
    ),
    "without a floor": el.Rig(
        [0.3, 0.4, 0.5], el.Lights([[0.6, 0, 0.8]], [[3, 2.8, 2.2]], [0.3]), 0.0
    ),
}


def picture(page, rig, **options):
    """State of a page, and its linear picture under a rig, (pixels, 3)."""
    options = {
        "width": WIDTH,
        "height": HEIGHT,
        "flatFloor": True,
        "rig": rig_of_page(rig),
        **options,
    }
    state, pixels = run(page, RENDER, options)["result"]
    return {**state, **options}, np.reshape(pixels, (-1, 4))[:, :3]


def codes_apart(one, other):
    """Difference of two pictures in 8-bit codes, white where irradiance is 4."""
    return np.abs(np.round(255 * encode_srgb(one)) - np.round(255 * encode_srgb(other)))


@pytest.mark.parametrize("name", RIGS)
def test_things_without_neighbours_are_shaded_as_the_rig_says(page, name):
    rig = RIGS[name]
    state, found = picture(page, rig, bare=True, albedo=0.7)
    own, _, normals = things.visible(state, WIDTH, HEIGHT)
    on = own >= 0
    assert on.sum() > 1500
    assert codes_apart(found[on], 0.7 / np.pi * rig.probe(normals[on])).max() <= 1


@pytest.mark.parametrize("name", RIGS)
def test_floor_ball_and_box_together_are_those_of_the_kernel(page, name):
    rig = RIGS[name]
    state, found = picture(page, rig, albedo=0.7)
    own, points, normals = things.visible(state, WIDTH, HEIGHT)
    on = (own >= things.FLOOR) & things.inner(own, WIDTH)
    stage = things.stage(
        things.solids(state["ball"], state["box"]), points[on], normals[on], own[on]
    )
    lights = rig.lights
    lighting = things.SimpleNamespace(
        directions=lights.direction,
        radii=lights.angular_radius,
        irradiance=lights.irradiance,
        ambient=rig.ambient,
        albedo=[np.full(3, 0.7)] * 2,
        floor_albedo=np.array(state["floor"]),
        floor=rig.floor,
    )
    received = _native.reflected_irradiance(stage, lighting)
    shown = np.where((own[on] == things.FLOOR)[:, None], state["floor"], 0.7)
    apart = codes_apart(found[on], shown / np.pi * received)
    assert (apart <= 1).mean() > 0.999
    assert apart.max() <= 2, np.sort(apart.ravel())[-20:]


def is_dark(ball, box, points, direction):
    """True for each floor point whose ray to a light meets ball or box."""
    (x, z, radius), half = ball, np.array(box[2:5])
    away = np.array([x, radius, z]) - points
    along = away @ direction
    by_ball = (along > 0) & ((away**2).sum(axis=1) - along**2 < radius**2)
    turn = things.rotation(box[5])
    start, step = (points - [box[0], half[1], box[1]]) @ turn, direction @ turn
    near, far = (-np.sign(step) * half - start) / step, (np.sign(step) * half - start) / step
    entry, exit_ = near.max(axis=1), far.min(axis=1)
    return by_ball | ((entry < exit_) & (exit_ > 0))


@pytest.mark.parametrize("shadows", ["exact", "paper"])
@pytest.mark.parametrize("elevation", [20, 50])
def test_hard_shadows_end_within_a_pixel_of_their_geometry(page, shadows, elevation):
    up, around = np.deg2rad([elevation, 130])
    sun = np.array([np.cos(up) * np.sin(around), np.sin(up), np.cos(up) * np.cos(around)])
    rig = el.Rig([0.01] * 3, el.Lights([sun], [[3, 3, 3]]), 0.0, floor=True)
    state, found = picture(page, rig, albedo=0.0, shadows=shadows, azimuth=0, elevation=0.6)
    own, points, _ = things.visible(state, WIDTH, HEIGHT)
    expected = is_dark(state["ball"], state["box"], points, sun)
    lit = np.array(state["floor"]) / np.pi * 3 * sun[1]
    found = (found < lit / 2).all(axis=1)
    floor = own == things.FLOOR
    # A pixel is certain if it and its neighbours are floor of one light.
    sure = floor & things.inner(own, WIDTH) & things.inner(expected.astype(int), WIDTH)
    np.testing.assert_array_equal(found[sure], expected[sure])
    assert expected[sure].sum() > 100
    assert (~expected)[sure].sum() > 3000
