"""Lights in metres: positions, irradiance at other points, and refusals, in closed-form rooms."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

import envlights as el
from envlights import kernels
from envlights.placing.shading import _least
from tests.helpers import printed_by_threads
from tests.io.test_door import png, write_file
from tests.placing.rooms import OFFSETS, room, seen

NORMALS, WEIGHTS = kernels.icosphere(320)
KINDS = ("pendants", "panel", "downlights", "hole", "furnished")
#: Depth of each fourth pixel, none of them among every second row and column.
SPARSE = np.kron(np.linspace(2, 3, 128 * 256).reshape(128, 256), [[0, 0], [0, 1]])


def error(guess, truth):
    return kernels.relative_rms(guess, truth, WEIGHTS)


def placed_in(kind, **options):
    radiance, depth = seen(kind)
    return el.place(radiance, options.pop("depth", depth), **options)


def position_errors(placed, kind):
    """Distance of each light to the nearest lamp, relative to its own."""
    lamps = np.array([lamp.centre for lamp in room(kind).lamps])
    return [np.linalg.norm(lamps - each.position, axis=1).min() / each.distance for each in placed]


@pytest.mark.parametrize("kind", KINDS)
def test_lamps_and_walls_are_where_they_hang(kind):
    placed = placed_in(kind)
    assert len(placed) == len(room(kind).lamps)
    assert max(position_errors(placed, kind)) < 0.01
    points = [(0, 0, 0), *OFFSETS]
    truth = [room(kind).probe(point, NORMALS) for point in points]
    errors = [error(*pair) for pair in zip(placed.irradiance(points, NORMALS), truth, strict=True)]
    assert errors[0] < 0.005
    # Two points at each distance; behind the furniture, walls that the camera does not see.
    assert max(errors) < 0.016
    assert max(errors[1:3]) < 0.005
    at_infinity = [error(placed.irradiance(np.zeros(3), NORMALS), each) for each in truth[5:]]
    assert min(at_infinity) > 10 * min(errors[5:])


@pytest.mark.parametrize("kind", ["panel", "hole"])
def test_flat_lights_and_windows_are_planes_with_their_size_and_normal(kind):
    placed, lamps = placed_in(kind), [each for each in room(kind).lamps if hasattr(each, "u")]
    planes = [each for each in placed if each.kind == "plane"]
    assert len(planes) == len(lamps)
    for plane in planes:
        lamp = min(lamps, key=lambda each: np.linalg.norm(each.centre - plane.position))
        assert plane.normal @ lamp.normal > 0.9999
        sizes = 2 * np.linalg.norm([lamp.u, lamp.v], axis=1)
        np.testing.assert_allclose(sorted(plane.size), sorted(sizes), rtol=0.01)
        np.testing.assert_allclose(plane.radiance, lamp.radiance, rtol=0.06)


def test_a_rectangle_in_an_oblique_wall_lies_in_it_with_right_angles():
    plane, rays = np.array([0.25, 0.2, -0.35]), kernels.pixel_directions(128, 256)
    height = rays @ plane
    depth = np.divide(1, height, out=np.zeros_like(height), where=height > 0.02)
    picture = el.synthetic.Rectangle((0.3, 0.2, -1), 30.0, 20.0, (9, 9, 9))
    world = el.synthetic.scene(128, background=[0.2] * 3, shapes=[picture])
    (light,) = el.place(world.radiance, depth, reading="ray")
    corners = light.matrix @ [[0, 1, 1, 0], [0, 0, 1, 1], [1, 1, 1, 1]]
    np.testing.assert_allclose(plane @ corners, 1, rtol=1e-9)
    across, down = light.matrix[:, 0], light.matrix[:, 1]
    assert abs(across @ down) < 1e-9 * np.prod(light.size)


def test_hanging_lamps_are_spheres_of_their_radius():
    placed, lamps = placed_in("pendants"), room("pendants").lamps
    for light in placed:
        lamp = min(lamps, key=lambda each: np.linalg.norm(each.centre - light.position))
        assert light.kind == "sphere"
        assert light.radius == pytest.approx(lamp.radius, rel=0.01)
        np.testing.assert_allclose(light.radiance, lamp.radiance, rtol=0.03)


@pytest.mark.parametrize("kind", ["panel", "downlights", "hole"])
def test_a_rig_at_a_point_has_the_irradiance_there(kind):
    placed = placed_in(kind)
    for point in OFFSETS[2:5]:
        rig = placed.at(point)
        stated = error(rig.probe(NORMALS), placed.irradiance(point, NORMALS))
        assert stated < 0.005
        assert rig.error == pytest.approx(stated)
        assert len(rig.lights) <= 8


@pytest.mark.parametrize("kind", ["pendants", "hole"])
def test_a_map_at_a_point_is_the_panorama_there(kind):
    placed, point = placed_in(kind), OFFSETS[3]
    moved = placed.map_at(point)
    truth, _ = room(kind).panorama(256, point)
    assert error(moved.probe(NORMALS), el.EnvMap(truth).probe(NORMALS)) < 0.003
    difference = np.abs(np.asarray(moved.radiance) - truth).sum(axis=2)
    assert np.median(difference / truth.sum(axis=2)) < 0.01


def test_errors_where_other_maps_were_taken():
    placed, point = placed_in("pendants"), OFFSETS[4]
    truth, _ = room("pendants").panorama(128, point)
    found = placed.compare({point: truth, (0, 0, 0): seen("pendants")[0]})
    assert found.error[0] < 0.02 < 0.4 < found.error_at_infinity[0]
    assert found.error[1] < 0.003
    np.testing.assert_allclose(found.point, [point, (0, 0, 0)])


# Limits and symmetries


@pytest.mark.parametrize("kind", ["panel", "downlights"])
def test_far_lights_are_the_directional_ones(kind):
    radiance, depth = seen(kind)
    placed = el.place(radiance, 1e9 * depth, reading="ray")
    home, there = placed.irradiance([[0, 0, 0], [2, 0, 0]], NORMALS)
    assert error(there, home) < 1e-8
    assert "its unit is doubtful" in " ".join(placed.notes)
    cards = el.split(radiance, shapes=True).cards
    lamps = there - placed.remainder.probe(NORMALS)
    assert error(lamps, cards.probe(NORMALS)) < 0.005
    rig = placed.at((2, 0, 0))
    np.testing.assert_allclose(
        rig.lights.direction, placed.at((0, 0, 0)).lights.direction, atol=1e-8
    )


@pytest.mark.parametrize("kind", ["panel", "downlights"])
def test_lamps_have_the_irradiance_of_their_cards_at_the_camera(kind):
    placed = placed_in(kind)
    lamps = el.placing.PlacedLights(
        placed.lights, el.EnvMap(np.zeros((4, 8, 3))), placed.patches[:0]
    )
    cards = el.split(seen(kind)[0], shapes=True).cards
    for light, wanted in zip(placed, cards.irradiance, strict=True):
        one = el.placing.PlacedLights((light,), lamps.remainder, lamps.patches)
        received = one.irradiance(np.zeros(3), light.direction[None])[0]
        np.testing.assert_allclose(received, wanted, rtol=1e-12)


def test_a_room_of_twice_the_size_has_the_same_light_at_twice_the_distance():
    radiance, depth = seen("panel")
    one, two = el.place(radiance, depth), el.place(radiance, depth, scale=2.0)
    for small, large in zip(one, two, strict=True):
        np.testing.assert_allclose(large.position, 2 * small.position, rtol=1e-9)
    point = np.array([1.0, 0.3, -0.4])
    np.testing.assert_allclose(
        two.irradiance(2 * point, NORMALS), one.irradiance(point, NORMALS), rtol=1e-9
    )


def test_a_turned_room_is_the_room_turned():
    radiance, depth = seen("downlights")
    columns = 128  # a quarter turn
    turned = el.place(np.roll(radiance, columns, 1), np.roll(depth, columns, 1))
    quarter = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    points = {tuple((quarter @ light.position).round(3)) for light in placed_in("downlights")}
    assert {tuple(light.position.round(3)) for light in turned} == points


def test_the_same_bits_for_any_number_of_threads():
    code = """
import numpy as np, envlights as el
from tests.placing.rooms import seen
placed = el.place(*seen("panel", 64))
print(placed.irradiance(np.eye(3), np.eye(3)).tobytes().hex())
"""
    assert len(printed_by_threads(code, (1, 2))) == 1


# Windows and suns


def test_a_window_lies_in_its_wall_and_a_sun_in_it_stays_at_infinity():
    radiance, depth = (each.copy() for each in seen("hole"))
    rays = kernels.pixel_directions(256, 512)
    towards = np.array([-1, 0.12, 0.1]) / np.linalg.norm([-1, 0.12, 0.1])
    radiance[rays @ towards > np.cos(0.015)] = 4000
    assert not np.isfinite(depth[rays @ towards > np.cos(0.05)]).any()
    placed = el.place(radiance, depth)
    sun, point = placed[0], OFFSETS[4]
    assert sun.kind == "sun"
    assert sun.direction @ towards > np.cos(0.005)
    assert not np.isfinite(sun.position).any()
    rays = el.Lights(sun.direction[None], sun.irradiance[None], [sun.angular_radius])
    sky = placed.irradiance(point, NORMALS) - el.Rig([0, 0, 0], rays, 0.0).probe(NORMALS)
    # The window is no card beside the sun, but its light is in the wall, as patches.
    assert error(sky, room("hole").probe(point, NORMALS)) < 0.05
    far = placed.remainder.probe(NORMALS)
    assert error(far, room("hole").probe(point, NORMALS)) > 0.3


def test_a_sky_without_depth_stays_at_infinity():
    radiance, depth = seen("pendants")
    open_sky = depth.copy()
    open_sky[:128] = np.nan
    placed = el.place(radiance, open_sky)
    assert "unknown for 50 % of the pixels" in " ".join(placed.notes)
    assert {light.kind for light in placed if light.direction[1] > 0.2} == {"sun"}


# Depth


@pytest.mark.parametrize("noise", ["none", "smooth", "each pixel"])
@pytest.mark.parametrize("stored", ["ray", "horizontal", "cube axis", "inverse"])
def test_the_reading_of_a_depth_is_measured(stored, noise):
    radiance, depth = seen("furnished", 128)
    rays, rng = kernels.pixel_directions(128, 256), np.random.default_rng(0)
    wave = rng.standard_normal(depth.shape)
    if noise == "smooth":
        wave = gaussian_filter(wave, 7, mode=("nearest", "wrap"))
    depth = depth * np.exp((noise != "none") * 0.05 * wave / wave.std())
    values = {
        "ray": depth,
        "horizontal": depth * np.hypot(rays[..., 0], rays[..., 2]),
        "cube axis": depth * np.abs(rays).max(axis=2),
        "inverse": 1 / depth,
    }[stored]
    placed = el.place(radiance, values)
    assert f"read as '{stored}'" in placed.notes[0]
    np.testing.assert_allclose(
        placed.irradiance(OFFSETS[0], NORMALS),
        el.place(radiance, depth, reading="ray").irradiance(OFFSETS[0], NORMALS),
        rtol=1e-9,
    )
    if noise == "none":
        other = "ray" if stored != "ray" else "horizontal"
        with pytest.raises(el.EnvLightsError, match=f"contradicts reading='{other}'.*'{stored}'"):
            el.place(radiance, values, reading=other)


@pytest.mark.parametrize("kind", ["pendants", "hole"])
def test_smooth_noise_moves_lights_no_more_than_the_depth(kind):
    radiance, depth = seen(kind)
    errors = []
    for seed in range(4):
        wave = np.random.default_rng(seed).standard_normal(depth.shape)
        wave = gaussian_filter(wave, 14, mode=("nearest", "wrap"))
        noisy = el.place(radiance, depth * np.exp(0.05 * wave / wave.std()))
        errors += position_errors(noisy, kind)
    assert np.sqrt(np.mean(np.square(errors))) < 0.05


def test_a_depth_of_one_value_is_a_sphere_around_the_camera():
    placed = placed_in("pendants", depth=np.full((64, 128), 2.0))
    assert placed.notes == ()
    assert [light.distance for light in placed] == pytest.approx([2] * 4, rel=0.02)


@pytest.mark.parametrize("kind", ["panel", "downlights", "pendants"])
def test_the_uncertainty_is_the_median_deviation_of_the_depth(kind):
    """Half of normal noise of 1 % is below 0.6745 %; the front of a sphere has few pixels."""
    radiance, depth = seen(kind)
    noise = np.random.default_rng(0).standard_normal(depth.shape)
    for light in el.place(radiance, depth * (1 + 0.01 * noise), reading="ray"):
        allowed = 0.15 if light.kind == "plane" else 0.4
        assert light.uncertainty == pytest.approx(0.006745, rel=allowed)
    assert max(light.uncertainty for light in placed_in(kind)) < 2e-4


def test_files_of_depth(tmp_path):
    radiance, depth = seen("pendants", 64)
    wanted = el.place(radiance, np.float32(depth)).irradiance(OFFSETS[0], NORMALS)
    exr = write_file(tmp_path / "a.exr", np.dstack([depth, depth]).astype("f4"), ("A", "Z"))
    np.save(tmp_path / "a.npy", depth)
    codes = png(tmp_path / "a.png", np.rint(1000 * depth[..., None]).astype(np.uint16))
    grey = np.float32(np.where(depth > 0.9 * depth.max(), np.nan, depth))[..., None].repeat(3, 2)
    same = write_file(tmp_path / "grey.exr", grey, ("R", "G", "B"))
    assert el.place(radiance, same).notes == el.place(radiance, grey[..., 0]).notes
    for path, options in ((exr, {}), (tmp_path / "a.npy", {}), (codes, {"scale": 0.001})):
        found = el.place(radiance, path, **options).irradiance(OFFSETS[0], NORMALS)
        np.testing.assert_allclose(found, wanted, rtol=2e-3)
    with pytest.raises(el.EnvLightsError, match=r"a\.png holds whole numbers without a unit"):
        el.place(radiance, codes)
    colours = write_file(tmp_path / "b.exr", np.ones((64, 128, 4), "f4"), ("R", "G", "B", "A"))
    with pytest.raises(el.EnvLightsError, match=r"b\.exr has no channel of depth, such as Z"):
        el.place(radiance, colours)
    colours = write_file(tmp_path / "b.exr", np.float32(radiance), ("R", "G", "B"))
    with pytest.raises(el.EnvLightsError, match=r"b\.exr has .* and is not grey; it has R, G, B"):
        el.place(radiance, colours)
    with pytest.raises(FileNotFoundError):
        el.place(radiance, tmp_path / "none.exr")


def npy(header):
    """Bytes of a .npy file with this header and few samples."""
    return b"\x93NUMPY\x01\x00" + len(header).to_bytes(2, "little") + header + bytes(100)


@pytest.mark.parametrize(
    "content",
    [
        b"nothing",
        b"PK\x03\x04",  # a .npz file by its first bytes
        npy(b"(" * 9000),
        npy(b"{'descr': '<f4', 'fortran_order': False, 'shape': (50000, 100000)}"),  # 20 GB
        npy(b"{'descr': '|O', 'fortran_order': False, 'shape': (2, 4)}"),
    ],
)
def test_a_damaged_array_of_depth_is_refused(content, tmp_path):
    (tmp_path / "c.npy").write_bytes(content)
    with pytest.raises(el.EnvLightsError, match="cannot read the depth"):
        el.place(np.ones((16, 32, 3)), tmp_path / "c.npy")


def test_a_point_behind_a_wall_is_noted(tmp_path):
    placed = placed_in("panel")
    with pytest.warns(UserWarning, match=r"lies behind a surface at 2\.5 m"):
        placed.save(tmp_path / "room.usda", at=(0, 0, 2.6))
    hidden = [placed.at((0, 0, 2.6)), placed.map_at((0, 0, 2.6))]
    assert [each.notes[-1].code for each in hidden] == ["depth-doubt"] * 2
    assert all("lies behind a surface at 2.5 m" in each.notes[-1] for each in hidden)
    assert placed.remainder.notes[-1].code == "removed"
    assert all(placed.at((0, 0, z)).notes == placed.notes for z in (0, 2.4))


def test_what_the_map_does_not_show_is_filled_everywhere_and_noted():
    radiance, _ = seen("panel", 64)
    coverage = np.ones(radiance.shape[:2])
    coverage[56:] = 0
    env = el.EnvMap(radiance * coverage[..., None], coverage=coverage).calibrated(ev100=3)
    placed = el.place(env, room=(6, 3, 5))
    here = placed.map_at((0, 0, 0))
    truth = placed.irradiance((0, 0, 0), NORMALS)
    assert error(here.probe(NORMALS), truth) < 0.01
    assert error(placed.at((0, 0, 0)).probe(NORMALS), truth) < 0.05
    words = "sphere that is not seen was filled"
    assert [sum(words in note for note in each.notes) for each in (placed, here)] == [1, 1]
    assert any("calibrated to cd/m2" in note for note in here.notes)
    assert len(set(here.notes)) == len(here.notes)


def test_positions_need_no_fill_and_light_at_a_point_does():
    radiance, _ = seen("panel", 64)
    coverage = np.ones(radiance.shape[:2])
    coverage[40:] = 0
    env = el.EnvMap(radiance * coverage[..., None], coverage=coverage)
    placed = el.place(env, room=(6, 3, 5))
    assert len(placed) == len(placed_in("panel"))
    for light in (placed.map_at, placed.at):
        for point in ((0, 0, 0), (0.5, 0, 0)):
            with pytest.raises(el.EnvLightsError, match=r"shows 69 %.*fill="):
                light(point)
    dim, bright = (
        el.place(env, room=(6, 3, 5), fill=fill).map_at((0, 0, 0)).probe(NORMALS)
        for fill in ("black", 0.5)
    )
    filled = el.EnvMap(0.5 * np.repeat(1 - coverage[..., None], 3, axis=2)).probe(NORMALS)
    np.testing.assert_allclose(bright - dim, filled, atol=1e-3)


def test_a_point_in_a_sphere_has_the_light_of_its_surface():
    placed = placed_in("pendants")
    lamp = placed[0]
    beside = lamp.position + 0.5 * lamp.radius * np.array([0, 1, 0])
    for point in (lamp.position, beside):
        direction, irradiance, radius = lamp.seen_from(point)
        assert np.linalg.norm(direction) == pytest.approx(1)
        np.testing.assert_allclose(irradiance, np.pi * lamp.radiance, rtol=1e-6)
        assert radius == pytest.approx(np.pi / 2)
        assert np.isfinite(placed.at(point).error)
    np.testing.assert_allclose(lamp.seen_from(beside)[0], [0, -1, 0], atol=1e-12)


def test_a_depth_of_another_size_gives_the_same_positions():
    radiance, _ = seen("panel")
    for height in (128, 400):
        _, depth = room("panel").panorama(height)
        assert max(position_errors(el.place(radiance, depth), "panel")) < 0.012


def walls_alone(low=(-3, -1.5, -2.5), high=(3, 1.5, 2.5)):
    """Distance of the walls of an empty room."""
    rays = kernels.pixel_directions(256, 512)
    return np.maximum(np.array(high) / rays, np.array(low) / rays).min(axis=-1)


@pytest.mark.parametrize("kind", KINDS)
def test_the_light_on_the_walls_shows_how_far_lamps_hang(kind):
    placed, alone = (
        placed_in(kind, depth=None, room=(6, 3, 5)),
        placed_in(kind, depth=walls_alone()),
    )
    # The walls have a texture of 10 %, and the furniture is unknown.
    assert max(position_errors(placed, kind)) < 0.035
    assert max(position_errors(alone, kind)) > 0.2
    kinds = {"plane" if hasattr(lamp, "u") else "sphere" for lamp in room(kind).lamps}
    assert {light.kind for light in placed} == kinds
    truth = [room(kind).probe(point, NORMALS) for point in OFFSETS]
    errors, without = (
        [error(*pair) for pair in zip(each.irradiance(OFFSETS, NORMALS), truth, strict=True)]
        for each in (placed, alone)
    )
    assert max(errors) < 0.3 * max(without)
    assert (np.array(errors) < np.add(without, 0.002)).all()
    (note,) = placed.notes
    assert note.code == "depth-doubt"
    lamps = [light for light in placed if light.is_disc]
    hanging = sum(light.kind == "sphere" for light in lamps)
    assert f"{hanging} of {len(lamps)} round lamps hang" in note


def test_the_light_on_even_walls_gives_positions_to_a_percent():
    plain = replace(room("pendants"), texture=0.0)
    placed = el.place(plain.panorama(256)[0], room=(6, 3, 5))
    errors = position_errors(placed, "pendants")
    assert max(errors) < 0.01
    assert all(each.uncertainty < 0.03 for each in placed)
    assert float(re.search(r"fits to (.*) %", placed.notes[0])[1]) < 2


@pytest.mark.parametrize("at", [0, 0.4, 20.3, 41, 59])
def test_the_least_loss_is_found_between_distances_and_at_the_ends(at):
    """Roots have their least value at an end and no curvature there, parabolas a vertex."""
    steps = np.abs(np.arange(60) - at)
    relative, _ = _least(np.sqrt(1 + steps) if at in (0, 59) else 1 + steps**2)
    assert relative == pytest.approx(0.98 * (0.2 / 0.98) ** (at / 59), rel=1e-9)


def test_a_lamp_without_a_clear_trace_on_the_walls_stays_there():
    lamp = el.synthetic.Disc((0.2, 1, 0.3), 6.0, (90, 90, 90))
    even = el.synthetic.scene(128, background=[0.2] * 3, shapes=[lamp])
    split = el.split(even.radiance, shapes=True)
    for grey in (0.1, 0.2, 0.7, 3.0):
        parts = split._replace(remainder=el.EnvMap(np.full((128, 256, 3), grey)))
        placed = el.place(parts, room=(6, 3, 5))
        assert [each.kind for each in placed] == ["plane"]
        assert "0 of 1 round lamps hang" in placed.notes[0]
        assert "1 may hang or not, and stay on their wall" in placed.notes[0]
    # A texture of 90 % hides the light of lamps.
    rough = replace(room("pendants"), texture=0.9)
    placed = el.place(rough.panorama(256)[0], room=(6, 3, 5))
    assert "may hang or not" in placed.notes[0]
    black = split._replace(remainder=el.EnvMap(np.zeros((128, 256, 3))))
    for env in (black, np.zeros((64, 128, 3)), np.full((64, 128, 3), 0.2)):
        assert el.place(env, room=(6, 3, 5)).notes[0].endswith("0 of 0 round lamps hang")


def test_the_size_of_a_room_is_a_depth():
    placed = placed_in("panel", depth=None, room=(6, 3, 5), camera=(3, 1, 2.5))
    assert placed[0].position[1] == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda depth: depth[:, :-1], "must have the shape"),
        (lambda depth: depth[None], "must have the shape"),
        (lambda depth: 0 * depth, "less than 1 %"),
        (lambda depth: np.nan * depth, "less than 1 %"),
        (lambda depth: depth - 2, "must not be negative"),
        (lambda depth: (1000 * depth).astype(int), "whole numbers without a unit"),
        (lambda depth: "text.txt", "text.txt"),
    ],
)
def test_depth_that_is_refused(change, words):
    radiance, depth = seen("pendants", 64)
    with pytest.raises(el.EnvLightsError, match=words):
        el.place(radiance, change(depth))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda depth: 1000 * depth, "15.. m below the camera.*give scale=0.001"),
        (lambda depth: 6 - depth, "read as 'inverse' in 1 / m"),
        (lambda depth: np.random.default_rng(0).uniform(1, 9, depth.shape), "no flat surfaces"),
    ],
)
def test_depth_that_is_noted(change, words):
    radiance, depth = seen("pendants", 64)
    notes = el.place(radiance, change(np.minimum(depth, 5.9))).notes
    assert any(re.search(words, note) for note in notes), notes


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "needs depth=, room="),
        ({"room": (6, 3)}, "room must be three"),
        ({"room": (6, -3, 5)}, "room must have positive sides"),
        ({"room": (6, 3, 5), "camera": (7, 1, 1)}, "camera must lie in the room"),
        ({"camera": (1, 1, 1), "depth": np.ones((16, 32))}, "give room= as well"),
        ({"room": (6, 3, 5), "scale": 2}, "room replaces depth"),
        ({"depth": np.ones((16, 32)), "reading": "disparity"}, "reading must be"),
        ({"depth": np.ones((16, 32)), "scale": -1}, "scale must be"),
        ({"depth": [[1, 2], [3]]}, "depth must be an array of real numbers"),
        ({"depth": [[1] * 32] * 16}, "whole numbers without a unit"),
        ({"depth": SPARSE}, "unknown around nearly every pixel.*give reading="),
    ],
)
def test_arguments_that_are_refused(options, words):
    with pytest.raises(el.EnvLightsError, match=words):
        el.place(seen("pendants", 64)[0], **options)


def test_a_split_without_shapes_is_refused():
    with pytest.raises(el.EnvLightsError, match="shapes=True"):
        el.place(el.split(seen("pendants", 64)[0]), room=(6, 3, 5))


# Two maps


@pytest.mark.parametrize("kind", KINDS[:4])
def test_two_maps_place_their_lights(kind):
    first = el.split(seen(kind)[0], shapes=True)
    errors, lost = [], 0
    for point in OFFSETS[2:]:
        other, _ = room(kind).panorama(256, point)
        placed = el.place([(first, (1, 1, 1)), (other, np.add(point, 1))])
        near = [each for each in placed if each.kind != "sun"]
        lost += len(placed) - len(near)
        assert len(placed.notes) == 1 + (len(near) < len(placed))
        errors += position_errors(near, kind)
        assert all(each.uncertainty < np.radians(0.1) for each in near)
    # One lamp and one window of 64 lights have 1.4 and 1.7 %.
    assert lost <= 1
    assert sorted(errors)[-2] < 0.01 > np.quantile(errors, 0.9)
    assert max(errors) < 0.02


def test_a_lamp_that_only_one_map_shows_stays_at_infinity():
    radiance, _ = seen("pendants")
    other, _ = room("pendants").panorama(256, (0.8, 0, 0.6))
    first = el.split(radiance, shapes=True)
    placed = el.place([(first, (0, 0, 0)), (el.split(other, 3, shapes=True), (0.8, 0, 0.6))])
    assert [light.kind for light in placed].count("sun") == 1
    assert "1 light without a partner" in placed.notes[1]
    with pytest.raises(el.EnvLightsError, match="must have different positions"):
        el.place([(first, (0, 0, 0)), (first, (0, 0, 0))])
    with pytest.raises(el.EnvLightsError, match="depth or several maps"):
        el.place([(first, (0, 0, 0)), (other, (1, 0, 0))], room=(6, 3, 5))


def test_what_belongs_to_a_depth_and_maps_of_two_scales_are_refused():
    env = el.EnvMap(seen("pendants", 64)[0])
    for other, options, words in (
        (env, {"reading": "ray"}, "belong to a depth"),
        (env, {"scale": 2.0}, "belong to a depth"),
        (env, {"camera": (1, 1, 1)}, "give room= as well"),
        (env.calibrated(ev100=3), {}, "the same units"),
    ):
        with pytest.raises(el.EnvLightsError, match=words):
            el.place([(env, (0, 0, 0)), (other, (1, 0, 0))], **options)
    with pytest.raises(el.EnvLightsError, match="the same units"):
        el.place(env, room=(6, 3, 5)).compare({(0, 0, 0): env.calibrated(ev100=3)})


def test_without_depth_the_surfaces_of_another_point_are_a_guess(tmp_path):
    first, (other, _) = seen("pendants")[0], room("pendants").panorama(256, (0.8, 0, 0.6))
    placed = el.place([(first, (0, 0, 0)), (other, (0.8, 0, 0.6))])
    with pytest.warns(UserWarning, match="there is no depth"):
        placed.save(tmp_path / "a.usda", at=(0.5, 0, 0))
    assert "the map is that of (0 0 0)" in (tmp_path / "a.usda").read_text()
    assert placed.map_at((0.5, 0, 0)).notes[-1].code == "depth-doubt"
    assert placed.at((0, 0, 0)).notes[-1].code != "depth-doubt"


# Results


def test_texts_cards_and_numbers_of_placed_lights():
    placed = placed_in("panel")
    assert placed.in_short() == "2 planes, 2 spheres, and 512 patches"
    assert str(placed).splitlines()[1].split()[1] == "plane"
    assert "more light" not in str(placed)
    assert "\n4 more lights\n" in f"{replace(placed, lights=4 * placed.lights)}\n"
    assert placed.cards.is_placed
    assert placed.cards.shape == ("rectangle", "rectangle", "sphere", "sphere")
    positions = [each.position for each in placed]
    np.testing.assert_allclose(placed.cards.matrix @ [0.5, 0.5, 1], positions)
    numbers = placed.to_dict()["lights"]
    assert [each["kind"] for each in numbers] == ["plane", "plane", "sphere", "sphere"]
    sphere, ball = numbers[2], room("panel").lamps[2]
    candela = np.pi * ball.radius**2 * ball.radiance
    np.testing.assert_allclose(sphere["intensity"], candela, rtol=0.02)
    panel, lamp = numbers[0], room("panel").lamps[0]
    np.testing.assert_allclose(panel["intensity"], lamp.radiance * 0.72, rtol=0.02)
    assert panel["up"] @ np.array(panel["normal"]) == pytest.approx(0, abs=1e-9)
