"""Maps back in the layout of their source."""

import numpy as np
import pytest

import envlights as el
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.faces import arranged_faces, upright_faces
from tests.helpers import NORMALS

WORLD = el.EnvMap(
    el.synthetic.scene(
        128,
        background=[0.2, 0.3, 0.4],
        shapes=[el.synthetic.Disc((0.3, 0.5, 1), 6.0, (90, 60, 30))],
    ).radiance
)


def smooth(height, width):
    """A picture without an edge, the same at its left and right."""
    rows = np.sin(3 * np.arange(height) / height)[:, None, None]
    columns = np.cos(2 * np.pi * np.arange(width) / width)[:, None]
    return (1 + 0.3 * rows * columns * np.ones(3)).astype(np.float32)


def cube(arrangement, order="opengl"):
    """Smooth cube in an arrangement."""
    faces = el.EnvMap(smooth(128, 256)).to(el.io.Layout.cube(faces="pannellum"), width=32).array
    upright = upright_faces(faces.reshape(6, 32, 32, 3), "pannellum")
    return np.ascontiguousarray(arranged_faces(upright, order, arrangement))


CUBES = [
    *((cube("stack", order), {"projection": "cube", "faces": order}) for order in CONVENTIONS),
    (cube("strip"), {"projection": "cube", "faces": "opengl"}),
    *((cube(name), {"projection": "cube", "faces": name}) for name in CROSSES),
]
WHOLE = [
    *CUBES,
    (smooth(32, 32), {"projection": "octahedral", "forward": (1, 0.2, 0.3)}),
    (smooth(32, 32), {"projection": "octahedral-equal-area"}),
    (smooth(101, 200), {}),
]
PARTS = [
    (smooth(30, 60), {"projection": "cylinder", "fov": 360, "horizon": 12}),
    (smooth(20, 30), {"projection": "planar", "fov": 50, "forward": (1, 0.2, -0.5)}),
    (smooth(31, 45), {"projection": "equirectangular", "fov": 90, "horizon": 12}),
]


@pytest.mark.parametrize(("picture", "options"), [*WHOLE, *PARTS])
def test_a_picture_comes_back_in_its_own_layout(picture, options):
    env = el.EnvMap(picture, layout=el.io.Layout(**options))
    again = env.to("source")
    assert np.asarray(again).shape == again.shape == picture.shape
    assert again.layout == env.source.layout
    assert again.coverage is None
    # Pixels are means over cells of their size: smooth radiance changes by a part of a step.
    difference = np.abs(again.array - picture)
    assert np.quantile(difference, 0.95) < 0.03
    np.testing.assert_allclose(again.array.mean(), picture.mean(), rtol=3e-3)


@pytest.mark.parametrize("circle", [None, (21, 14, 12)])
@pytest.mark.parametrize("options", [{"projection": "mirror-ball"}, {"mapping": "equisolid"}])
def test_a_disc_comes_back_as_a_disc(options, circle):
    if "mapping" in options:
        options = {**options, "projection": "fisheye", "fov": 200}
    picture = smooth(30, 40 if circle else 30)
    again = el.EnvMap(picture, layout=el.io.Layout(circle=circle, **options)).to("source")
    y, x = np.ogrid[: picture.shape[0], : picture.shape[1]]
    centre_x, centre_y, radius = circle or (15, 15, 15)
    distance = np.hypot(x + 0.5 - centre_x, y + 0.5 - centre_y)
    inside, outside = distance < radius - 2, distance > radius + 1
    assert np.quantile(np.abs(again.array - picture)[inside], 0.95) < 0.05
    assert not again.array[outside].any()


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_a_panorama_comes_back_bit_by_bit(registration, tmp_path):
    seen = np.ones((32, 64), np.float32)
    seen[20:, :9] = 0.25
    env = el.EnvMap(
        WORLD.resized(64).radiance * seen[..., None],
        layout=el.io.Layout(registration=registration),
        coverage=seen,
    )
    again = env.to("source")
    np.testing.assert_array_equal(again.array, env.radiance)
    np.testing.assert_array_equal(again.coverage, seen)
    again.save(tmp_path / "again.exr")
    assert el.EnvMap.open(tmp_path / "again.exr").registration == registration
    # After a rotation samples are no longer on the border.
    turn = [[0.6, 0, 0.8], [0, 1, 0], [-0.8, 0, 0.6]]
    assert not env.rotated(turn).to("source").layout.border_sampled


def test_a_part_of_a_panorama_comes_back_bit_by_bit():
    picture = WORLD.radiance[40:90, 90:150]
    env = el.EnvMap(picture, layout=el.io.Layout.equirectangular(fov=60 / 256 * 360, horizon=24))
    np.testing.assert_array_equal(env.radiance[40:90, 98:158], picture)
    np.testing.assert_array_equal(env.to("source").array, picture)


def test_the_rest_of_a_split_comes_back_as_the_cube_it_was():
    cross = arranged_faces(
        upright_faces(WORLD.to("cube", width=64).array.reshape(6, 64, 64, 3), "opengl"),
        "opengl",
        "horizontal-cross",
    )
    env = el.EnvMap(np.ascontiguousarray(cross))
    lights, rest = el.split(env)
    assert len(lights) == 1
    assert rest.source == env.source
    again = rest.to("source")
    assert again.shape == cross.shape
    filled = again.array[again.array.any(axis=2)]
    np.testing.assert_allclose(filled, np.broadcast_to([0.2, 0.3, 0.4], filled.shape), rtol=1e-3)
    opened = el.EnvMap(again.array)
    np.testing.assert_allclose(opened.probe(NORMALS), rest.probe(NORMALS), rtol=1e-3)


def test_the_border_of_a_photograph_does_not_come_back_darker():
    env = el.EnvMap(np.full((40, 60, 3), 0.5, np.float32), layout=el.io.Layout.planar(fov=70))
    assert ((env.coverage > 0) & (env.coverage < 0.9)).any()
    np.testing.assert_allclose(env.to("source").array, 0.5, rtol=1e-4)


def test_all_that_keeps_the_world_keeps_its_source():
    env = el.EnvMap(WORLD.to("cube", width=32).array, layout=el.io.Layout.cube(faces="opengl"))
    part = el.EnvMap(smooth(20, 30), layout=el.io.Layout.planar(fov=80))
    for kept in (
        el.split(env).remainder,
        el.limit(env, 30).remainder,
        env.limited(30),
        env.repaired(),
        env.resized(32),
        env.rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]]),
        env.filled(),
        env.calibrated(lux=9),
    ):
        assert kept.source == env.source
    for kept in (part.filled("harmonic"), el.split(part).remainder, part.repaired(fill="black")):
        assert kept.source == part.source


@pytest.mark.parametrize("option", [{"width": 64}, {"fov": 90}, {"forward": (0, 0, 1)}])
def test_the_source_takes_no_other_argument(option):
    with pytest.raises(el.EnvLightsError, match="is no argument of the layout 'source'"):
        WORLD.to("source", **option)
