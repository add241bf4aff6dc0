"""Cards in pbrt-v4, by the formulas of its source: bilinear patches, and images of area lights."""

import re

import numpy as np
import pytest

import envlights as el
from envlights.cards import geometry
from envlights.export import AXES
from tests.export import cards

THERE = AXES["pbrt"]


def numbers(text, name):
    return np.array(re.search(rf'"{name}" \[([^\]]*)\]', text).group(1).split(), float)


@pytest.mark.parametrize("name", ["window", "oblique"])
def test_each_corner_of_a_patch_has_its_colour(name, tmp_path):
    card = cards.ALL[name]
    el.export.save(card, tmp_path / "scene.pbrt")
    text = (tmp_path / "scene.pbrt").read_text()
    points, uv = numbers(text, "point3 P").reshape(4, 3), numbers(text, "point2 uv").reshape(4, 2)
    # A patch interpolates p00, p10, p01, p11; its normal is that of the derivatives.
    assert np.cross(points[1] - points[0], points[2] - points[0]) @ points.mean(axis=0) < 0
    affine, *_ = np.linalg.lstsq(np.insert(uv, 2, 1, axis=1), points, rcond=None)
    picture = el.io.read_image(tmp_path / "scene.card_0.pbrt.exr").pixels
    height, width, _ = picture.shape
    towards = THERE.to_target(cards.directions(card))
    for direction, colour in zip(towards, cards.CORNERS.reshape(-1, 3), strict=True):
        u, v, scale = np.linalg.solve(affine.T, direction)
        u, v = u / scale, 1 - v / scale  # DiffuseAreaLight::L turns v
        np.testing.assert_array_equal(picture[int(v * height), int(u * width)], colour)


def test_a_disk_faces_the_origin(tmp_path):
    el.export.save(cards.LAMP.at(4.0), tmp_path / "scene.pbrt")
    text = (tmp_path / "scene.pbrt").read_text()
    matrix = np.array(re.search(r"ConcatTransform \[([^\]]*)\]", text).group(1).split(), float)
    matrix = matrix.reshape(4, 4).T
    assert np.linalg.det(matrix) == pytest.approx(1)
    np.testing.assert_allclose(matrix[:3, 3], 4 * THERE.to_target(cards.LAMP.direction)[0])
    np.testing.assert_allclose(matrix[:3, 2], -geometry.unit(matrix[:3, 3]), atol=1e-8)
    radius = float(re.search(r'"float radius" (\S+)', text).group(1))
    assert radius == pytest.approx(4 * np.tan(np.radians(10)))
    np.testing.assert_allclose(numbers(text, "rgb L"), [3, 2, 1], rtol=2e-3)


def test_an_ellipse_keeps_its_axes(tmp_path):
    """Triangles that shine to the origin, with vertices on the ellipse in the card."""
    matrix = cards.facing(100, 15, 50, 20, turn=20)
    card = cards.card("disc", matrix, np.full((8, 8, 3), [3, 2, 1], np.float32))
    el.export.save(card, tmp_path / "scene.pbrt")
    text = (tmp_path / "scene.pbrt").read_text()
    points = numbers(text, "point3 P").reshape(-1, 3) @ THERE.matrix
    triangles = numbers(text, "integer indices").reshape(-1, 3).astype(int)
    corners = numbers(text, "point3 P").reshape(-1, 3)[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert (np.einsum("ij,ij->i", normals, corners[:, 0]) < 0).all()
    a, b, c = np.linalg.solve(matrix, points.T)
    np.testing.assert_allclose((2 * a / c - 1) ** 2 + (2 * b / c - 1) ** 2, 1, rtol=1e-5)
    area = np.linalg.norm(normals, axis=1).sum() / 2
    u, v, _ = card.far().matrix[0].T
    assert area == pytest.approx(np.pi / 4 * np.linalg.norm(np.cross(u, v)), rel=0.002)


def test_a_disc_hides_the_map_behind_it_and_not_the_map_beside_it(tmp_path):
    """The corners of the square around a disc are bright; its own colour does not hold them."""
    towards, size = cards.LAMP.direction[0], np.cos(np.radians(10.5))
    sky = np.where(el.kernels.pixel_directions(256, 512) @ towards > size, 0.2, 5.0)
    around = el.EnvMap(np.repeat(sky[..., None], 3, axis=2).astype(np.float32))
    el.export.save(cards.LAMP, tmp_path / "scene.pbrt", around)
    seen = numbers((tmp_path / "scene.pbrt").read_text(), "rgb L")
    np.testing.assert_allclose(seen, [3.2, 2.2, 1.2], rtol=2e-3)
