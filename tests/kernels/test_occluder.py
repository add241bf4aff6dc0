"""Light that solids hide, against rings of rays, closed forms and its limits."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from envlights.kernels.solids import Stage
from tests.helpers import printed_by_threads

UP = np.array([0.0, 1.0, 0.0])
BALL = el.scene.Ball((0.3, 0.5, 0.2), 0.5)
BOX = el.scene.Box((-0.5, 0.4, 0.1), (0.4, 0.4, 0.3), turn=0.6)
SOLIDS = {
    "ball": [BALL],
    "box": [BOX],
    "both": [BALL, BOX],
    "two boxes": [BOX, el.scene.Box((0.4, 0.6, -0.3), (0.3, 0.6, 0.3))],
}
NONE = np.zeros((0, 3)), np.zeros(0)


def direction(elevation, azimuth):
    e, a = np.deg2rad([elevation, azimuth])
    return np.array([np.cos(e) * np.sin(a), np.sin(e), np.cos(e) * np.cos(a)])


def is_hit(solid, point, rays):
    """Rays that meet a solid, by its equations: a ball, or the slabs of a box."""
    if isinstance(solid, el.scene.Ball):
        away = np.array(solid.centre) - point
        along = rays @ away
        return (along > 0) & (away @ away - along**2 < solid.radius**2)
    cos, sin = np.cos(solid.turn), np.sin(solid.turn)
    axes = np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
    origin, slopes = axes @ (point - np.array(solid.centre)), rays @ axes.T
    with np.errstate(divide="ignore", invalid="ignore"):
        ends = (np.array([-1, 1])[:, None, None] * solid.half_sides - origin) / slopes
    near, far = ends.min(axis=0).max(axis=-1), ends.max(axis=0).min(axis=-1)
    return (far > np.maximum(near, 0)) & (far > 0)


def limits(solid, point):
    """Vectors m and numbers c of all circles `m . w = c` on which the border of a solid lies."""
    if isinstance(solid, el.scene.Ball):
        away = np.array(solid.centre) - point
        distance = np.linalg.norm(away)
        return [(away / distance, np.sqrt(max(1 - (solid.radius / distance) ** 2, 0)))]
    corners = np.array(solid.vertices) - point
    pairs = {
        tuple(sorted((face[k - 1], face[k]))) for face in solid.faces for k in range(len(face))
    }
    return [(np.cross(corners[a], corners[b]), 0.0) for a, b in pairs]


def hidden_by_rings(solids, point, normal, axis, radius, floor, rings=2000):
    """Hidden irradiance of a disc of radiance 1, over pi sin^2 of its radius.

    On each ring around the axis, the integral over the angle is exact between all crossings of the
    ring with circles of borders; a ray in the middle shows what is hidden.
    """
    theta = (np.arange(rings) + 0.5) * radius / rings
    u = np.linalg.svd(axis[None])[2][1]
    v = np.cross(axis, u)
    circles = [(normal, 0.0)] + ([(UP, 0.0)] if floor else [])
    circles += [circle for solid in solids for circle in limits(solid, point)]
    roots = [np.zeros(rings), np.full(rings, 2 * np.pi)]
    for m, c in circles:
        reach, towards = np.hypot(m @ u, m @ v) * np.sin(theta), np.arctan2(m @ v, m @ u)
        with np.errstate(invalid="ignore", divide="ignore"):
            half = np.arccos((c - m @ axis * np.cos(theta)) / reach)
        roots += [np.where(np.isnan(half), 0, (towards + s * half) % (2 * np.pi)) for s in (1, -1)]
    ends = np.sort(roots, axis=0)
    low, high = ends[:-1], ends[1:]
    ray = lambda p: (  # noqa: E731
        np.cos(theta)[:, None] * axis
        + np.sin(theta)[:, None] * (np.cos(p)[..., None] * u + np.sin(p)[..., None] * v)
    )
    middle = ray((low + high) / 2)
    counts = np.any([is_hit(solid, point, middle.reshape(-1, 3)) for solid in solids], axis=0)
    counts = counts.reshape(low.shape) & (middle @ normal > 0)
    counts &= (middle[..., 1] > 0) | (not floor)
    along = normal @ axis * np.cos(theta) * (high - low)
    across = np.sin(theta) * (
        normal @ u * (np.sin(high) - np.sin(low)) - normal @ v * (np.cos(high) - np.cos(low))
    )
    total = ((along + across) * counts * np.sin(theta)).sum() * radius / rings
    return total / (np.pi * np.sin(radius) ** 2)


@pytest.mark.parametrize("things", SOLIDS)
@pytest.mark.parametrize("radius", np.deg2rad([0.1, 0.27, 5, 30, 80]))
def test_hidden_shares_are_those_of_rings_of_rays(things, radius):
    rng = np.random.default_rng(5)
    solids = SOLIDS[things]
    for elevation in (-5, 20, 70):
        point = np.array([*rng.uniform(-1.5, 1.5, 2), 0.0])[[0, 2, 1]]
        normal = UP if elevation == 20 else direction(60, rng.uniform(0, 360))
        # Lights behind the solids, so that their borders cross the disc.
        aim = np.array(solids[0].centre) - point + rng.uniform(-0.3, 0.3, 3)
        azimuth = np.rad2deg(np.arctan2(aim[0], aim[2]))
        axis = aim / np.linalg.norm(aim) if elevation == 70 else direction(elevation, azimuth)
        stage = Stage(solids, point[None], normal[None], [-1])
        seen = kernels.hidden_fractions(stage, [axis], [radius], floor=True)[0]
        disc = hidden_by_rings(solids, point, normal, axis, radius, False)
        sky = hidden_by_rings(solids, point, normal, normal, np.pi / 2, True)
        np.testing.assert_allclose(seen, [sky, disc], rtol=0, atol=1e-5)


@pytest.mark.parametrize("radius", [*np.deg2rad([0.27, 10, 75]), np.pi / 2])
@pytest.mark.parametrize("height", [0.9, 0.5, 0.1, -0.1])
def test_a_ball_in_the_middle_of_a_disc_hides_a_smaller_disc(radius, height):
    """Both are cut by the horizon of the surface, for which the probe has its own closed form."""
    axis = np.array([np.sqrt(1 - height**2), height, 0])
    for part in (1e-3, 0.5, 1.0):
        inner = part * radius
        ball = el.scene.Ball(3 * axis, 3 * np.sin(inner))
        stage = Stage(ball, [[0, 0, 0]], [UP], [-1])
        seen = kernels.hidden_fractions(stage, [axis], [radius])[0, 1]
        disc = kernels.rig_irradiance([UP], [0, 0, 0], [axis], [[1, 1, 1]], [inner])[0, 0]
        assert seen == pytest.approx(disc * (np.sin(inner) / np.sin(radius)) ** 2, abs=1e-9)


def test_at_the_point_of_contact_all_is_hidden():
    sun = direction(30, 50)
    stage = Stage.floor(
        [el.scene.Ball((0, 1, 0), 1), el.scene.Box((4, 1, 0), (1, 1, 1), 0.4)],
        [[0, 0, 0], [4, 0, 0.5]],
    )
    seen = kernels.hidden_fractions(stage, [sun, UP], [np.deg2rad(0.27), 1.3], floor=True)
    np.testing.assert_allclose(seen, np.tile([1, sun[1], 1], (2, 1)), rtol=0, atol=1e-9)


def test_a_wall_through_the_middle_hides_half():
    wall = el.scene.Box((50, 0, 0), (50, 100, 100))
    light = direction(40, 0)
    for degrees in (0.27, 10, 40):
        seen = kernels.hidden_fractions(
            Stage.floor(wall, [[0, 0, 0]]), [light], [np.deg2rad(degrees)]
        )
        assert seen[0, 1] == pytest.approx(light[1] / 2, abs=1e-9)


def test_a_floor_has_the_form_factors_of_its_solids():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-3, 3, 50), np.zeros(50), rng.uniform(-3, 3, 50)])
    away = np.array(BALL.centre) - points
    expected = 0.5 * 0.5**2 / np.linalg.norm(away, axis=1) ** 3
    factors = kernels.form_factors(Stage.floor([BALL, BOX], points))
    np.testing.assert_allclose(factors[:, 0], expected, atol=1e-12)
    alone = kernels.hidden_fractions(Stage.floor(BOX, points), *NONE, floor=True)[:, 0]
    np.testing.assert_allclose(factors[:, 1], alone, atol=1e-12)


def test_black_surfaces_reflect_nothing():
    rig = el.synthetic.rigs(1)[0]
    lights = rig.lights[rig.lights.direction[:, 1] > 0]
    stage = Stage.floor([BALL, BOX], [[1, 0, 0.3], [0.2, 0, -0.8]])
    discs = lights.direction, lights.irradiance, lights.angular_radius
    shares = kernels.hidden_fractions(stage, discs[0], discs[2], floor=True)
    seen = kernels.reflected_irradiance(
        stage, [1, 2, 3], *discs, albedo=np.zeros((2, 3)), floor_albedo=[1, 1, 1]
    )
    open_light = kernels.rig_irradiance(stage.normals, [1, 2, 3], *discs, floor=True)
    hidden = np.outer(shares[:, 0], np.pi * np.array([1, 2, 3])) + shares[:, 1:] @ discs[1]
    np.testing.assert_allclose(seen, open_light - hidden, rtol=1e-12, atol=1e-12)


def test_threads_give_the_same_bits():
    code = (
        "import numpy as np, envlights as el\n"
        "g = np.stack(np.meshgrid(np.linspace(-2, 2, 60), 0, np.linspace(-2, 2, 60)), -1)\n"
        "solids = el.scene.Ball((0, 0.5, 0), 0.5), el.scene.Box((1, 0.4, 0), (0.4,) * 3)\n"
        "s = el.kernels.solids.Stage.floor(solids, g.reshape(-1, 3))\n"
        "out = el.kernels.hidden_fractions(s, [[0.6, 0.8, 0], [0, 0.6, 0.8]], [0.3, 0.005])\n"
        "import hashlib; print(hashlib.sha256(out.tobytes()).hexdigest())"
    )
    assert len(set(printed_by_threads(code))) == 1


def test_points_on_a_solid_are_recognised():
    top, side = [-0.5, 0.8, 0.1], np.array(BALL.centre) + 0.5 * direction(20, 30)
    stage = Stage(
        [BALL, BOX], [top, side, [-0.5, 0, 0.1], [3, 0, 0]], [UP, direction(20, 30), UP, UP]
    )
    assert stage.own.tolist() == [1, 0, -1, -1]
    # What lies on a convex solid is not hidden by it, also by the general rule.
    other = Stage(stage.solids, stage.points, stage.normals, [-1] * 4)
    seen, expected = (kernels.hidden_fractions(each, [UP], [0.3]) for each in (other, stage))
    np.testing.assert_allclose(seen, expected, atol=1e-6)


def test_a_rotation_is_a_turn():
    turn = 0.6
    matrix = [[np.cos(turn), 0, np.sin(turn)], [0, 1, 0], [-np.sin(turn), 0, np.cos(turn)]]
    np.testing.assert_allclose(
        el.scene.Box(BOX.centre, BOX.half_sides, matrix).vertices, BOX.vertices
    )


CUBE = el.scene.Box((0, 0, 0), (1, 1, 1))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: el.scene.Ball((0, np.nan, 0), 1),
            r"centre must be three finite numbers; got \(0, nan, 0\)",
        ),
        (lambda: el.scene.Ball((0, 0), 1), "centre must be three finite numbers"),
        (lambda: el.scene.Ball((0, 0, 0), -1), "radius must be a finite number, 0 or more; got -1"),
        (lambda: el.scene.Ball((0, 0, 0), 0), "radius must be above 0; got 0"),
        (lambda: el.scene.Box((0, 0, 0), (1, 0, 1)), "half_sides must be above 0"),
        (lambda: el.scene.Box((0, 0, 0), (1, 1, 1), np.inf), "turn must be a finite number"),
        (lambda: el.scene.Box((0, 0, 0), (1, 1, 1), -np.eye(3)), "it is a reflection"),
        (
            lambda: el.scene.Polyhedron(CUBE.vertices, CUBE.faces[:5]),
            "each edge of a polyhedron must join",
        ),
        (
            lambda: el.scene.Polyhedron([*CUBE.vertices[:7], (0, 0, 0)], CUBE.faces),
            "must be convex",
        ),
        (
            lambda: el.scene.Polyhedron(CUBE.vertices, [[0, 1, 9]]),
            "faces must hold rows of vertices",
        ),
        (lambda: Stage("ball", [[0, 0, 0]], [[0, 1, 0]]), "solids must be Ball, Box or Polyhedron"),
        (
            lambda: Stage(BALL, [[0, 0, 0]], np.zeros((2, 3))),
            "normals must have the shape of points",
        ),
        (lambda: Stage.floor(BALL, [[0, np.inf, 0]]), "points must be finite; row 0 holds"),
        (lambda: kernels.hidden_fractions(BALL, *NONE), "stage must be a Stage"),
        (
            lambda: kernels.hidden_fractions(Stage.floor(BALL, [[0, 0, 0]]), [UP], [2.0]),
            "angular_radius must lie from 0 to pi / 2; got 2",
        ),
        (
            lambda: kernels.hidden_fractions(Stage(BALL, [UP], [UP], [4]), *NONE),
            "own must be from -1 to 0; got 4",
        ),
    ],
)
def test_what_is_not_possible_is_refused(make, message):
    with pytest.raises(el.EnvLightsError, match=message):
        make()
