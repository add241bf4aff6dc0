"""Cubes whose faces are wider than 90 degrees."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.layouts import recognise
from envlights.environment.layouts.faces import arranged_faces
from tests.layouts.worlds import BASES, grid, smooth

N = 128
Layout = el.io.Layout


def directions(fov, n=N, border=False):
    """Unit vectors of the pixels of six wide faces, (6, n, n, 3)."""
    a, b = np.tan(np.radians(fov) / 2) * np.array(grid(n, border))
    forward, right, up = BASES.transpose(1, 0, 2)[:, :, None, None]
    there = forward + a[..., None] * right + b[..., None] * up
    return there / np.linalg.norm(there, axis=-1, keepdims=True)


def strip(faces, order="opengl"):
    return arranged_faces(faces, order, "strip")


@pytest.mark.parametrize("border", [False, True])
@pytest.mark.parametrize("fov", [90, 95, 100, 120, 150])
def test_a_world_of_wide_faces_is_that_world(fov, border):
    image = strip(smooth(directions(fov, border=border)))
    registration = "border-sampled" if border else "cell-centred"
    layout = Layout.cube(faces="opengl", registration=registration, fov=fov)
    env = el.EnvMap(image, layout=layout)
    truth = smooth(el.kernels.pixel_directions(env.height, env.width))
    error = np.abs(env.radiance / truth - 1)
    # Pixels at a distance of tan(fov / 2) see the world coarser.
    assert np.median(error) < 0.005 * np.tan(np.radians(fov) / 2) ** 2
    assert error.max() < 0.15 * np.tan(np.radians(fov) / 2) ** 2
    normals, _ = el.kernels.icosphere(80)
    exact = el.EnvMap(smooth(el.kernels.pixel_directions(256, 512)))
    np.testing.assert_allclose(env.probe(normals), exact.probe(normals), rtol=2e-3)


@pytest.mark.parametrize("order", ["opengl", "openexr", "pannellum"])
@pytest.mark.parametrize("fov", [95, 100, 120])
def test_the_seams_of_wide_faces_decide_on_their_order(fov, order):
    faces = smooth(directions(fov))
    found = recognise(strip(faces, order), layout=Layout.cube(fov=fov))
    assert (found.source.faces, found.source.recognised_by) == (order, "seams")
    np.testing.assert_array_equal(found.samples.reshape(faces.shape), faces)


@pytest.mark.parametrize("fov", [95, 100, 120])
def test_lamps_at_edges_and_in_margins_are_where_they_are(fov):
    lamps = np.array([(1.02, 0.4, 1), (-1, -0.2, 1.04), (0.1, 1, -1.03), (0.1, 1, 0.05)])
    lamps /= np.linalg.norm(lamps, axis=1, keepdims=True)
    there = directions(fov, 256)
    image = np.full(there.shape, 0.1, np.float32)
    for lamp in lamps:
        image[(there @ lamp) > np.cos(np.radians(1.5))] = 50
    env = el.EnvMap(strip(image), layout=Layout.cube(faces="opengl", fov=fov))
    found = el.detect(env)
    assert len(found) == len(lamps)
    angles = np.degrees(np.arccos(np.clip(lamps @ found.direction.T, -1, 1)))
    # A pixel is 0.5 to 0.8 degrees wide.
    assert angles.min(axis=1).max() < 0.15
    expected = 49.9 * 2 * np.pi * (1 - np.cos(np.radians(1.5)))
    np.testing.assert_allclose(found.irradiance[:, 0], expected, rtol=0.12)


@pytest.mark.parametrize("fov", [60, 89, 175, 360])
def test_faces_that_leave_gaps_or_end_at_infinity_are_refused(fov):
    with pytest.raises(el.EnvLightsError, match="fov must be"):
        el.EnvMap(strip(smooth(directions(95))), layout=Layout.cube(faces="opengl", fov=fov))


def test_wide_faces_are_read_and_come_back_with_90_degrees():
    image = strip(smooth(directions(100)))
    env = el.EnvMap(image, layout=Layout.cube(faces="opengl", fov=100))
    back = env.to("source")
    assert back.array.shape == image.shape
    plain = smooth(directions(90))
    np.testing.assert_allclose(back.array, strip(plain), rtol=0.15)
    with pytest.raises(el.EnvLightsError, match="fov is no argument of a cube map"):
        env.to(Layout.cube(fov=100))


def test_the_command_takes_the_field_of_view(tmp_path):
    import OpenImageIO as oiio  # noqa: N813, its own name for itself

    image = np.ascontiguousarray(strip(smooth(directions(100))))
    path = tmp_path / "wide.exr"
    file = oiio.ImageOutput.create(str(path))
    assert file.open(str(path), oiio.ImageSpec(*image.shape[1::-1], 3, "float"))
    file.write_image(image)
    file.close()
    out = tmp_path / "out.exr"
    given = ["--projection", "cube", "--faces", "opengl", "--fov", "100"]
    result = CliRunner().invoke(main, ["convert", str(path), str(out), *given])
    assert result.exit_code == 0, result.output
    expected = el.EnvMap(image, layout=Layout.cube(faces="opengl", fov=100)).radiance
    np.testing.assert_allclose(el.EnvMap.open(out).radiance, expected, rtol=1e-3)


def test_a_wide_strip_without_its_field_of_view_names_it():
    env = el.EnvMap(strip(smooth(directions(110))), layout=Layout.cube(faces="opengl"))
    assert any("wider than 90 degrees (fov=)" in note for note in env.notes)
