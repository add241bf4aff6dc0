"""Maps, lights and rigs, turned."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import envlights as el
from envlights import kernels
from tests.helpers import NORMALS, angle_deg, flux, printed_by_threads
from tests.reference import rotation

TURNS = Rotation.random(4, random_state=5).as_matrix()
HALL = el.EnvMap(el.synthetic.hall(128).radiance)


def about_the_pole(angle):
    return Rotation.from_rotvec([0, angle, 0]).as_matrix()


def relative(seen, wanted):
    return np.linalg.norm(seen - wanted) / np.linalg.norm(wanted)


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_whole_columns_about_the_pole_are_exact(registration):
    rng = np.random.default_rng(2)
    radiance = rng.random((16, 32, 3)).astype(np.float32)
    columns = 32
    if registration == "border-sampled":
        radiance[:, -1] = radiance[:, 0]
        columns = 31
    env = el.EnvMap(radiance, layout=el.io.Layout(registration=registration))
    for k in (0, 1, 5, columns - 1):
        turn = about_the_pole(-2 * np.pi * k / columns)
        turned = env.rotated(turn)
        assert turned.registration == registration
        np.testing.assert_allclose(turned.probe(NORMALS @ turn.T), env.probe(NORMALS), rtol=2e-6)
        np.testing.assert_array_equal(
            np.sort(turned.radiance[:, :columns], axis=1), np.sort(radiance[:, :columns], axis=1)
        )
        np.testing.assert_array_equal(turned.rotated(turn.T).radiance, radiance)


@pytest.mark.parametrize("turn", TURNS)
def test_other_turns_keep_flux_and_turn_the_probe(turn):
    turned = HALL.rotated(turn)
    np.testing.assert_allclose(flux(turned.radiance), flux(HALL.radiance), rtol=1e-7)
    assert relative(turned.probe(NORMALS @ turn.T), HALL.probe(NORMALS)) < 3e-4


@pytest.mark.parametrize("shape", [(64, 128), (33, 66), (2, 4)])
@pytest.mark.parametrize("turn", TURNS)
def test_turned_maps_are_those_of_the_reference(shape, turn):
    """Among them pixels that are brighter than all others, and wide lamps.

    The reference integrates centroids on a grid, so that bright pixels differ by 1e-4.
    """
    radiance = np.random.default_rng(3).gamma(0.3, 1, (*shape, 3)).astype(np.float32)
    radiance[0, 1] = [1e5, 10, 0]
    radiance[shape[0] // 2 :, :3] *= 1000
    turned = el.EnvMap(radiance).rotated(turn).radiance
    np.testing.assert_allclose(turned, rotation.rotate(radiance, turn), rtol=2e-4)


def test_the_threads_change_no_bit_of_a_turned_map():
    code = """
import hashlib
import envlights as el
env = el.EnvMap(el.synthetic.hard(3, 128).radiance)
turned = env.rotated([[0.36, 0.48, -0.8], [-0.8, 0.6, 0], [0.48, 0.64, 0.6]])
print(hashlib.sha256(turned.radiance.tobytes()).hexdigest())
"""
    assert len(printed_by_threads(code)) == 1


@pytest.mark.parametrize("turn", TURNS)
@pytest.mark.parametrize("pixel", [(0, 3), (31, 100), (63, 0), (40, 127)])
def test_one_bright_pixel_keeps_its_flux_and_its_direction(turn, pixel):
    """Wherever it was, and wherever it comes to stand."""
    radiance = np.zeros((64, 128, 3), np.float32)
    radiance[pixel] = [1e4, 100, 1]
    turned = el.EnvMap(radiance).rotated(turn)
    np.testing.assert_allclose(flux(turned.radiance), flux(radiance), rtol=1e-6)
    cells = np.argwhere(turned.radiance[..., 0])
    moments = [turned.radiance[y, x, 0] * rotation.moment(y, x, 64, 128) for y, x in cells]
    centre = np.sum(moments, axis=0)
    source = rotation.moment(*pixel, 64, 128)
    size = np.degrees(np.sqrt(kernels.pixel_solid_angles(64, 128)[pixel]))
    off = angle_deg(centre / np.linalg.norm(centre), turn @ source / np.linalg.norm(source))
    assert off < 0.01 * size


def test_an_even_map_stays_even():
    env = el.EnvMap(np.full((32, 64, 3), 0.25, np.float32))
    np.testing.assert_array_equal(env.rotated(TURNS[0]).radiance, env.radiance)


def test_a_black_map_stays_black():
    env = el.EnvMap(np.zeros((32, 64, 3), np.float32))
    assert not env.rotated(TURNS[0]).radiance.any()


def test_two_small_turns_of_the_pole_are_no_turns_about_it():
    turn = Rotation.from_rotvec([1e-3, 0, 0]).as_matrix()
    assert not np.array_equal(HALL.rotated(turn).radiance, HALL.radiance)


@pytest.mark.parametrize("height", [24, 400])  # in one block of rows, and in several
def test_borders_become_cells_of_the_same_flux(height):
    rng = np.random.default_rng(7)
    radiance = rng.gamma(0.5, 1, (height, 2 * height, 3)).astype(np.float32)
    env = el.EnvMap(radiance, layout=el.io.Layout(registration="border-sampled"))
    own = kernels.pixel_solid_angles(height, 2 * height, border_sampled=True)[..., None]
    np.testing.assert_allclose(flux(env.cells()), (radiance * own).sum(axis=(0, 1)), rtol=1e-6)
    assert relative(el.EnvMap(env.cells()).probe(NORMALS), env.probe(NORMALS)) < 3e-3
    even = el.EnvMap(np.ones_like(radiance), layout=el.io.Layout(registration="border-sampled"))
    np.testing.assert_allclose(even.cells(), 1, rtol=1e-6)
    assert HALL.cells() is HALL.radiance


RIGS = {
    "discs": el.fit(HALL, lights=4),
    "harmonics": el.fit(HALL, lights=1, ambient="sh2", sizes=False),
}


@pytest.mark.parametrize("rig", RIGS.values(), ids=RIGS)
@pytest.mark.parametrize("turn", TURNS)
def test_a_rig_turns_with_its_probe(rig, turn):
    turned = rig.rotated(turn)
    np.testing.assert_allclose(turned.probe(NORMALS @ turn.T), rig.probe(NORMALS), rtol=1e-12)
    again = turned.rotated(turn.T)
    np.testing.assert_allclose(again.lights.direction, rig.lights.direction, atol=1e-14)
    np.testing.assert_allclose(again.ambient, rig.ambient, atol=1e-12 * np.abs(rig.ambient).max())
    assert (turned.error, turned.report) == (rig.error, rig.report)


def test_a_rig_and_its_map_turn_the_same_way():
    turn = TURNS[1]
    rig = RIGS["discs"].rotated(turn)
    turned = RIGS["discs"].to_map(128).rotated(turn)
    assert relative(turned.probe(NORMALS), rig.probe(NORMALS)) < 1e-3


def test_detected_lights_turn_with_all_their_directions():
    turn = TURNS[2]
    found = el.detect(HALL)
    turned = found.rotated(turn)
    for name in ("direction", "peak_direction", "orientation"):
        np.testing.assert_allclose(getattr(turned, name), getattr(found, name) @ turn.T, atol=1e-14)
    np.testing.assert_array_equal(turned.irradiance, found.irradiance)
    np.testing.assert_array_equal(turned.members.light, found.members.light)


def test_over_a_floor_only_turns_about_the_pole_are_possible():
    rig = el.Rig([0.1, 0.1, 0.1], RIGS["discs"].lights, 0.0, floor=True)
    turn = about_the_pole(0.3)
    np.testing.assert_allclose(rig.rotated(turn).probe(NORMALS @ turn.T), rig.probe(NORMALS))
    with pytest.raises(el.EnvLightsError, match="can only be rotated about the pole"):
        rig.rotated(TURNS[0])


@pytest.mark.parametrize(
    ("matrix", "sentence"),
    [
        (np.eye(4), r"the shape \(3, 3\); got \(4, 4\)"),
        (2 * np.eye(3), "must be a rotation; its rows must be orthonormal"),
        (np.diag([-1, 1, 1]), "must be a rotation; it is a reflection"),
        (np.full((3, 3), np.nan), "must be a rotation; its rows"),
        ("turn", "must hold real numbers"),
    ],
)
@pytest.mark.parametrize("turned", [HALL, RIGS["discs"], RIGS["discs"].lights])
def test_what_is_no_rotation_is_refused(turned, matrix, sentence):
    with pytest.raises(el.EnvLightsError, match=sentence):
        turned.rotated(matrix)
