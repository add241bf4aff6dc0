"""Cards in Mitsuba: colours at their corners, and irradiance at a great distance."""

import numpy as np
import pytest

import envlights as el
from envlights import kernels
from tests.export import cards
from tests.export.rigs import relative
from tests.helpers import NORMALS

pytest.importorskip("mitsuba")

from envlights.scene.mitsuba.renderer import mitsuba

SKY = el.EnvMap(np.full((32, 64, 3), [0.2, 0.3, 0.4], np.float32))


def load(path, mi):
    """A written scene; Mitsuba reads textures beside it."""
    (path.parent / "all.xml").write_text(
        f'<scene version="3.0.0"><include filename="{path.name}"/></scene>'
    )
    return mi.load_file(str(path.parent / "all.xml"))


def radiance_towards(scene, mi, directions):
    """Emission along rays from the origin, (n, 3)."""
    found = []
    for towards in directions:
        ray = mi.Ray3f(mi.Point3f(0, 0, 0), mi.Vector3f(*towards.tolist()))
        hit = scene.ray_intersect(ray)
        found.append(np.array(hit.emitter(scene).eval(hit)))
    return np.array(found).reshape(-1, 3)


def irradiance_in(scene, mi, samples=65536, point=(0.0, 0.0, 0.0)):
    """Irradiance at a point, from directions that Mitsuba picks on an even grid."""
    place = mi.SurfaceInteraction3f()
    place.p = mi.Point3f(*point)
    grid = kernels.hammersley(samples)
    seen = [scene.sample_emitter_direction(place, mi.Point2f(*each), True) for each in grid]
    towards = np.array([list(sample.d) for sample, _ in seen])
    strength = np.array([list(colour) for _, colour in seen])
    return np.maximum(NORMALS @ towards.T, 0) @ strength / samples


@pytest.mark.parametrize("name", ["window", "oblique"])
def test_each_corner_has_its_colour(name, tmp_path):
    card = cards.ALL[name]
    el.export.save(card, tmp_path / "scene.xml")
    with mitsuba() as mi:
        seen = radiance_towards(load(tmp_path / "scene.xml", mi), mi, cards.directions(card))
    np.testing.assert_allclose(seen, cards.CORNERS.reshape(-1, 3), atol=1e-4)


@pytest.mark.parametrize("name", cards.ALL)
def test_a_far_card_lights_as_one_at_infinity(name, tmp_path):
    """At 1000 radii, the limit is 0.3 %; the map behind the card is not lost."""
    card = cards.ALL[name]
    el.export.save(card, tmp_path / "scene.xml", SKY)
    with mitsuba() as mi:
        from_file = irradiance_in(load(tmp_path / "scene.xml", mi), mi)
        emitters = el.export.mitsuba(card, SKY)
        scene = mi.load_dict({"type": "scene", **emitters}, optimize=False)
        from_python = irradiance_in(scene, mi)
    wanted = cards.irradiance(card, NORMALS, SKY)
    assert relative(from_file, wanted) < 0.003
    assert relative(from_python, wanted) < 0.003


def test_the_distance_of_the_caller_counts():
    near = cards.WINDOW.at(2.5)
    with mitsuba() as mi:
        scene = mi.load_dict({"type": "scene", **el.export.mitsuba(near)})
        centre = mi.Vector3f(*near.direction[0].tolist())
        hit = scene.ray_intersect(mi.Ray3f(mi.Point3f(0, 0, 0), centre))
        assert float(hit.t) == pytest.approx(2.5, rel=1e-5)


def test_bright_cards_are_picked_often():
    both = el.export.mitsuba(
        el.Cards(
            ["rectangle"] * 2,
            [cards.WINDOW.matrix[0], cards.OBLIQUE.matrix[0]],
            [[3, 3, 3], [1, 1, 1]],
        )
    )
    weights = [each["emitter"]["sampling_weight"] for each in both.values()]
    np.testing.assert_allclose(weights, [1.5, 0.5])
