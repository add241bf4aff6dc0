"""Published protocols: their tone, materials, camera and sums."""

import pickle
from dataclasses import replace

import numpy as np
import pytest

import envlights as el
from envlights.comparison import rays, spheres
from envlights.comparison.lighting import lighting_of
from envlights.comparison.protocol import Camera, Material, Protocol, tone
from tests.comparison.worlds import even, rooms
from tests.reference import spheres as reference

STYLELIGHT = Protocol.named("stylelight")
SMALL = Camera(size=24, rough_size=12)


def test_rough_reflections_are_the_sum_over_all_pixels():
    truth, guess = rooms(32)
    normals, views = reference.sides(60)
    stack = np.concatenate([truth.radiance, guess.radiance], axis=2)
    for roughness, specular in ((0.3271, 0.8), (0.364, 0.04), (1.0, 1.0)):
        out = el.kernels.rough_reflection(stack, normals, views, roughness, specular=specular)
        surface = {"base": 0, "specular": specular, "roughness": roughness}
        expected = reference.image(stack[..., :3], normals, views, **surface)
        np.testing.assert_allclose(out[:, :3], expected, rtol=1e-4)


def test_one_sun_pixel_is_reflected_to_1e_3():
    sky = np.ones((64, 128, 3), np.float32)
    sky[20, 31] = 1e5
    normals, views = reference.sides(40, seed=3)
    out = el.kernels.rough_reflection(sky, normals, views, 0.3271)
    surface = {"base": 0, "specular": 1, "roughness": 0.3271}
    np.testing.assert_allclose(out, reference.image(sky, normals, views, **surface), rtol=1e-3)


@pytest.mark.parametrize("name", ["diffuse", "matte"])
def test_spheres_of_a_camera_are_sums_over_all_pixels(name):
    truth, guess = (lighting_of(env, 32) for env in rooms(32))
    material = STYLELIGHT.materials[name]
    images = spheres.camera_images(truth, guess, material, SMALL)
    points = rays.of_camera(SMALL, is_mirror=False)
    surface = {
        "base": material.base,
        "specular": material.specular,
        "roughness": material.roughness,
    }
    for image, side in zip(images, (truth, guess), strict=True):
        # Points in place of pixels, as many as integrate the Lambertian base.
        fine = np.repeat(np.repeat(side.radiance, 3, 0), 3, 1)
        coarse = reference.image(side.radiance, points.normals, points.views, **surface)
        expected = coarse
        if material.base:
            base = {"base": material.base, "specular": 0, "roughness": 0}
            expected = coarse - reference.image(side.radiance, points.normals, points.views, **base)
            expected += reference.image(fine, points.normals, points.views, **base)
        assert np.sqrt(((image - expected) ** 2).mean() / (expected**2).mean()) < 1e-3


def test_the_mirror_shows_the_map_behind_the_camera_and_rises_to_1_at_the_rim():
    sky = even((1, 1, 1), 64)
    side = lighting_of(el.EnvMap(sky), 64)
    image, _ = spheres.camera_images(side, side, Material(specular=0.8), Camera(size=64))
    assert image.min() == pytest.approx(0.8, abs=1e-3)
    # Pixels are means over the last 3 % of the radius.
    assert 0.9 < image.max() <= 1
    # A lamp behind the camera is in the middle of the ball.
    camera = Camera(position=(0, 0, -16), size=65)
    points = rays.of_camera(camera, is_mirror=True)
    middle = points.mirrored()[(points.normals * points.views).sum(axis=1).argmax()]
    assert middle[2] == pytest.approx(-1, abs=0.02)


def test_the_ball_has_the_size_of_the_published_picture():
    """A lens of 85 mm on 36 mm shows the unit ball with a radius of 141 of 960 pixels."""
    points = rays.of_camera(STYLELIGHT.camera, is_mirror=True)
    distance = np.linalg.norm(STYLELIGHT.camera.position)
    radius = 960 * 85 / 36 / np.sqrt(distance**2 - 1)
    # Its mesh is 1 % smaller.
    assert STYLELIGHT.camera.size / 2 == pytest.approx(0.99 * radius, abs=1)
    pixels = len(np.unique(points.pixels))
    assert pixels / (960 * 540) == pytest.approx(STYLELIGHT.camera.coverage, rel=0.01)


def test_each_map_is_scaled_to_its_own_median():
    truth, guess = rooms(32)
    for env in (truth, guess):
        toned, factor = tone(env.radiance, STYLELIGHT)
        assert np.median(toned[toned > 0]) == pytest.approx(0.5, rel=1e-6)
        np.testing.assert_allclose(toned, factor * env.radiance ** (1 / 2.4), rtol=1e-5)
    c = el.compare(truth, 2 * truth.radiance, STYLELIGHT)
    assert all(each.relative < 1e-5 for each in c.spheres.values())
    assert any("a brighter guess scores the same" in note for note in c.notes)
    # Errors without images are those of the linear maps.
    assert c.probe_error == pytest.approx(1, rel=1e-6)


def test_the_published_sum_over_channels_is_sqrt_3_of_the_mean():
    truth, guess = rooms(32)
    small = replace(STYLELIGHT, camera=SMALL)
    one = el.compare(truth, guess, small)
    other = el.compare(truth, guess, replace(small, channels="mean"))
    for name, each in one.spheres.items():
        assert each.rmse == pytest.approx(np.sqrt(3) * other.spheres[name].rmse, rel=1e-9)
        assert each.si_rmse == pytest.approx(np.sqrt(3) * other.spheres[name].si_rmse, rel=1e-9)
        assert each.angle == other.spheres[name].angle
    assert any("1.73 times the usual one" in note for note in one.notes)
    assert not any("1.73" in note for note in other.notes)


def test_the_published_formulas_give_the_same_numbers():
    """The code of StyleLight on whole pictures with alpha: sums over pixels and channels."""
    truth, guess = rooms(32)
    protocol = replace(Protocol.named("diffusionlight"), camera=SMALL)
    c = el.compare(truth, guess, protocol)
    sides = [lighting_of(el.EnvMap(tone(env.radiance, protocol)[0]), 32) for env in (truth, guess)]
    gt, pred = spheres.camera_images(*sides, protocol.materials["matte"], SMALL)
    errors = c.spheres["matte"]
    assert errors.rmse == pytest.approx(np.sqrt(((pred - gt) ** 2).sum() / len(gt)), rel=1e-6)
    a, b, d = (pred**2).sum(), -2 * (pred * gt).sum(), (gt**2).sum()
    si_rmse = np.sqrt((4 * a * d - b**2) / (4 * a) / len(gt))
    assert errors.si_rmse == pytest.approx(si_rmse, rel=1e-6)
    cosine = (gt * pred).sum(1) / np.linalg.norm(gt, axis=1) / np.linalg.norm(pred, axis=1)
    angle = np.degrees(np.arccos(np.clip(cosine, 0, 1))).mean()
    assert errors.angle == pytest.approx(angle, rel=1e-5)


def test_normalised_pictures_are_divided_by_their_percentile():
    truth, guess = rooms(32)
    protocol = replace(Protocol.named("diffusionlight"), camera=replace(SMALL, rough_size=64))
    errors = el.compare(truth, guess, protocol).spheres["matte"]
    sides = [lighting_of(el.EnvMap(tone(env.radiance, protocol)[0]), 32) for env in (truth, guess)]
    images = spheres.camera_images(*sides, protocol.materials["matte"], protocol.camera)
    scaled = []
    for image in images:
        # The whole picture, black around the ball.
        whole = np.zeros((round(len(image) / protocol.camera.coverage), 3))
        whole[: len(image)] = image
        low, high = np.percentile(whole, [0.01, 99.9])
        scaled.append((image - low) / (high - low))
    expected = np.sqrt(((scaled[1] - scaled[0]) ** 2).sum() / len(images[0]))
    assert errors.normalised_rmse == pytest.approx(expected, rel=1e-3)
    assert el.compare(truth, guess, STYLELIGHT).spheres["matte"].normalised_rmse is None


def test_the_coat_is_named_and_can_be_removed():
    truth, guess = rooms(32)
    coated = replace(STYLELIGHT, camera=SMALL)
    bare = {**STYLELIGHT.materials, "diffuse": Material(base=0.8)}
    one, other = (el.compare(truth, guess, p) for p in (coated, replace(coated, materials=bare)))
    assert any("'diffuse' is not Lambertian" in note for note in one.notes)
    assert not any("not Lambertian" in note for note in other.notes)
    assert one.spheres["diffuse"].rmse > other.spheres["diffuse"].rmse


def test_a_camera_on_linear_maps_agrees_with_all_sides():
    """Under an even sky all sides are alike, so that one camera is enough."""
    truth = even((1, 1, 1), 32)
    guess = even((2, 1, 1), 32)
    protocol = replace(Protocol.named("exact"), camera=SMALL)
    one, exact = el.compare(truth, guess, protocol), el.compare(truth, guess)
    assert one.spheres["diffuse"].rmse == pytest.approx(exact.spheres["diffuse"].rmse, rel=1e-4)
    assert one.spheres["mirror"].rmse == pytest.approx(exact.spheres["mirror"].rmse, rel=1e-4)
    # A camera at a finite distance sees less of the rim.
    assert one.spheres["matte"].rmse == pytest.approx(exact.spheres["matte"].rmse, rel=0.02)


def test_a_published_protocol_without_a_camera_is_a_closed_form():
    truth, guess = rooms(32)
    sides = replace(STYLELIGHT, camera=None)
    c = el.compare(truth, guess, sides)
    toned = [tone(env.radiance, STYLELIGHT)[0] for env in (truth, guess)]
    normals, views = reference.sides(1200, seed=1)
    material = {"base": 0.8, "specular": 0.04, "roughness": 0.364}
    images = [reference.image(map_, normals, views, **material) for map_ in toned]
    expected = np.sqrt(3) * reference.numbers(*images)[0]
    assert c.spheres["diffuse"].rmse == pytest.approx(expected, rel=4 / np.sqrt(1200))


def test_black_pixels_of_a_published_protocol_count_as_perfect():
    truth = even((1, 0, 0), 16)
    truth[:, :16] = 0
    guess = even((0, 1, 0), 16)
    perfect = replace(Protocol.named("exact"), black="perfect")
    left_out = el.compare(truth, guess).spheres["mirror"].angle
    assert left_out == pytest.approx(90, rel=1e-6)
    counted = el.compare(truth, guess, perfect).spheres["mirror"].angle
    assert counted == pytest.approx(45, rel=1e-6)


def test_maps_of_published_protocols_have_128_rows():
    env = el.EnvMap(np.ones((160, 320, 3)))
    c = el.compare(env, env, replace(STYLELIGHT, camera=SMALL))
    assert "truth: reduced from 320x160 to 256x128 pixels by area means" in c.notes


def test_protocols_can_be_pickled():
    assert pickle.loads(pickle.dumps(STYLELIGHT)) == STYLELIGHT


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"channels": "median"}, "channels must be 'mean' or 'sum'; got 'median'"),
        ({"black": "grey"}, "black must be"),
        ({"gamma": 0}, "gamma must be"),
        ({"median": -1}, "median must be"),
        ({"rows": 1}, "rows must be"),
        ({"camera": (0, 0, 1)}, "camera must be a Camera or None"),
        ({"materials": {}}, "materials must be a mapping"),
        ({"materials": {"a": 1}}, "materials must be a mapping"),
        ({"normalised": True, "camera": None}, "normalised needs a camera"),
    ],
)
def test_impossible_protocols_are_refused(change, message):
    with pytest.raises(el.EnvLightsError, match=message):
        replace(STYLELIGHT, **change)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: Material(specular=1, roughness=0.1), "roughness must be 0, or 0.2 to 1"),
        (lambda: Material(base=1.5), "base must be"),
        (lambda: Material(base=0.5, specular=0.5), "needs rough microfacets"),
        (lambda: Camera(position=(0, 0.5, 0)), "outside of the ball"),
        (lambda: Camera(size=2), "size must be"),
    ],
)
def test_impossible_parts_are_refused(call, message):
    with pytest.raises(el.EnvLightsError, match=message):
        call()
