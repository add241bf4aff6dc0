"""Radiance for what a map does not show, and detection in what it shows."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import envlights as el
from envlights import cli
from envlights.kernels.probe import relative_rms
from envlights.kernels.sphere import pixel_directions
from envlights.papers import madsen
from envlights.papers.loghin import Settings
from tests.helpers import DETECTORS, NORMALS, SOLID_ANGLES, paths_of_real_maps

HEIGHT, WIDTH = 64, 128
TOWARDS = pixel_directions(HEIGHT, WIDTH)
GREY = np.full((HEIGHT, WIDTH, 3), 0.5, np.float32)
ABOVE = (TOWARDS[..., 1] > 0).astype(np.float32)
NO_NADIR = (TOWARDS[..., 1] > -np.sin(np.deg2rad(60))).astype(np.float32)
REGISTRATIONS = ("cell-centred", "border-sampled")


def lamps(*directions, radius=6.0, radiance=(9, 8, 7), height=128):
    shapes = [el.synthetic.Disc(each, radius, radiance) for each in directions]
    scene = el.synthetic.scene(height, background=[0.1] * 3, shapes=shapes)
    return np.asarray(scene.radiance, np.float32)


@pytest.mark.parametrize("registration", REGISTRATIONS)
@pytest.mark.parametrize("fill", ["harmonic", 0.5, (0.5, 0.5, 0.5), np.float32(0.5)])
@given(seed=st.integers(0, 2**31), fraction=st.floats(0.02, 0.98))
def test_a_constant_map_is_filled_with_its_constant(registration, fill, seed, fraction):
    chance = np.random.default_rng(seed)
    seen = chance.random((HEIGHT, WIDTH)) < fraction
    seen[:20] &= seen[0, 0]  # a wide hole, or none
    seen[-1, 0] = True
    seen = (seen * chance.random(seen.shape)).astype(np.float32)
    env = el.EnvMap(
        GREY * seen[..., None], layout=el.io.Layout(registration=registration), coverage=seen
    )
    filled = env.filled(fill)
    np.testing.assert_allclose(filled.radiance, 0.5, rtol=1e-3)
    assert filled.coverage is None
    assert filled.registration == registration


@pytest.mark.parametrize("waves", [1, 2])
def test_a_harmonic_fill_continues_what_solves_laplaces_equation(waves):
    theta, phi = np.arccos(TOWARDS[..., 1]), 2 * np.pi * (np.arange(WIDTH) + 0.5) / WIDTH
    wave = np.tan(0.5 * np.minimum(theta, 2.0)) ** waves * np.cos(waves * phi)
    sky = np.repeat((5 + wave)[..., None], 3, axis=2).astype(np.float32)
    env = el.EnvMap(sky, coverage=1 - ABOVE)
    np.testing.assert_allclose(env.filled("harmonic").radiance, sky, atol=3e-3)


def test_seen_pixels_keep_their_bits_and_a_fill_lies_between_them():
    radiance = np.random.default_rng(3).uniform(0.2, 3, (HEIGHT, WIDTH, 3)).astype(np.float32)
    env = el.EnvMap(radiance, coverage=NO_NADIR)
    filled = env.filled()
    seen = NO_NADIR == 1
    np.testing.assert_array_equal(filled.radiance[seen], radiance[seen])
    assert 0.2 < filled.radiance[~seen].min() <= filled.radiance[~seen].max() < 3
    assert filled.notes == (
        "the 7.1 % of the sphere that is not seen was filled from its border by Laplace's equation",
    )
    assert filled.filled("black") is filled


@pytest.mark.parametrize("albedo", [0.0, 0.25, 0.8])
def test_ground_reflects_the_sky_that_is_seen(albedo):
    env = el.EnvMap(GREY * (1, 2, 3), coverage=ABOVE)
    ground = env.filled("ground", albedo=albedo)
    # Half a sphere of radiance L has the irradiance pi L.
    expected = np.where(ABOVE[..., None] == 1, 1, albedo) * env.radiance[0, 0]
    np.testing.assert_allclose(ground.radiance, expected, rtol=1e-4)


def test_ground_continues_no_lamp():
    sky = GREY.copy()
    sky[10, :20] = 1e4
    seen = np.ones((HEIGHT, WIDTH))
    seen[11:] = 0
    env = el.EnvMap(sky, coverage=seen)
    assert env.filled("harmonic").radiance[11:].max() > 1e3
    assert env.filled("ground").radiance[11:32].max() <= 8 * 0.5 * 1.001


def test_the_probe_is_that_of_the_filled_map():
    env = el.EnvMap(lamps((0, 1, 0.3)), coverage=np.repeat(np.repeat(ABOVE, 2, 0), 2, 1))
    for fill in ("black", "harmonic", "ground", 0.3, (1, 0, 2)):
        filled = env.filled(fill)
        np.testing.assert_array_equal(env.probe(NORMALS, fill=fill), filled.probe(NORMALS))
        with_choice, without = el.fit(env, lights=2, fill=fill), el.fit(filled, lights=2)
        assert with_choice.lights == without.lights
        assert with_choice.notes == filled.notes


@pytest.mark.parametrize(
    "use",
    [
        lambda env: env.probe([[0, 1, 0]]),
        lambda env: env.filled(),
        lambda env: el.fit(env),
        lambda env: madsen.fit(env),
    ],
)
def test_half_a_sphere_is_refused_without_a_choice(use):
    sentence = (
        "the map shows 50 % of the sphere, so the brightest light may be outside; say what is there"
        r" by fill='black', 'harmonic', 'ground' or a radiance \(a number or RGB\)"
    )
    with pytest.raises(el.EnvLightsError, match=sentence):
        use(el.EnvMap(GREY, coverage=ABOVE))
    el.detect(el.EnvMap(GREY, coverage=ABOVE))


@pytest.mark.parametrize(
    ("fill", "message"),
    [
        ("grey", "fill must be 'black' or 'harmonic' or 'ground'"),
        (-1.0, "fill must be"),
        (np.nan, "fill must be"),
        ([1, 2], r"fill must be three numbers; got the shape \(2,\)"),
        ([1, 2, -3], "fill must be"),
        (True, "fill must be"),
    ],
)
@pytest.mark.parametrize("seen", [None, ABOVE])
def test_other_choices_are_refused_for_every_map(fill, message, seen):
    env = el.EnvMap(GREY, coverage=seen)
    for use in (env.filled, lambda choice: el.fit(env, lights=1, fill=choice)):
        with pytest.raises(el.EnvLightsError, match=message):
            use(fill)
    with pytest.raises(el.EnvLightsError, match="albedo must be"):
        env.filled("ground", albedo=1.5)


def test_a_floor_hides_the_lower_half():
    radiance = lamps((0.2, 1, 0.3))
    seen = np.repeat(np.repeat(ABOVE, 2, 0), 2, 1)
    dome, whole = el.EnvMap(radiance, coverage=seen), el.EnvMap(radiance)
    rig, expected = (el.fit(env, lights=2, floor=True) for env in (dome, whole))
    np.testing.assert_allclose(rig.lights.direction, expected.lights.direction, atol=1e-5)
    assert rig.report.coverage_fraction == pytest.approx(1, abs=1e-6)
    assert rig.report.unseen_spread == pytest.approx(0, abs=1e-6)


def test_the_report_has_the_share_and_what_the_rest_may_change():
    env = el.EnvMap(GREY, coverage=NO_NADIR)
    report = el.fit(env, lights=1).report
    cap = (1 - np.sin(np.deg2rad(60))) / 2
    assert report.coverage_fraction == pytest.approx(1 - cap, abs=0.01)
    black, grey = (
        el.EnvMap(each.radiance).probe(NORMALS) for each in map(env.filled, ("black", "harmonic"))
    )
    assert report.unseen_spread == pytest.approx(relative_rms(black, grey, SOLID_ANGLES), rel=1e-2)
    assert f"{100 * report.coverage_fraction:.3g} % of the sphere is seen" in str(report)
    again = type(report).from_dict(json.loads(json.dumps(report.to_dict())))
    assert (again.coverage_fraction, again.unseen_spread) == (
        report.coverage_fraction,
        report.unseen_spread,
    )
    whole = el.fit(el.EnvMap(GREY), lights=1).report
    assert (whole.coverage_fraction, whole.unseen_spread) == (1.0, 0.0)
    assert "seen" not in str(whole)


def test_the_command_line_passes_the_choice(tmp_path):
    image = pytest.importorskip("PIL.Image")
    codes = np.full((32, 64, 4), 128, np.uint8)
    codes[..., 3] = np.repeat([255, 0], 16)[:, None]
    path = tmp_path / "dome.png"
    image.fromarray(codes).save(path)
    run = CliRunner().invoke
    refused = run(cli.main, ["fit", str(path)])
    assert refused.exit_code != 0
    for choice in ("ground", "0.2", "0.1,0.2,0.3"):
        done = run(cli.main, ["fit", str(path), "--fill", choice, "--json"])
        assert done.exit_code == 0, done.output
        report = json.loads(done.output)["report"]
        assert report["coverage_fraction"] == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("method", ["tree", "loghin"])
def test_a_share_of_one_changes_no_bit(method):
    radiance = lamps((0.2, 1, 0.3), (1, 0, 0))
    whole, seen = el.EnvMap(radiance), el.EnvMap(radiance, coverage=np.ones(radiance.shape[:2]))
    assert seen.coverage is None
    one, other = (DETECTORS[method](env) for env in (whole, seen))
    assert one.to_dict() == other.to_dict()
    assert not one.is_cut.any()
    np.testing.assert_array_equal(whole.probe(NORMALS), seen.probe(NORMALS))


@pytest.mark.parametrize("hidden", [slice(0, 64), slice(128, 192)])
def test_the_threshold_is_that_of_the_seen_part(hidden):
    # Every column has the same luminance, so any columns have the threshold of all.
    sky = np.repeat(np.geomspace(0.1, 3, 128)[:, None], 256, axis=1)[..., None] * np.ones(3)
    seen = np.ones((128, 256))
    seen[:, hidden] = 0
    whole, part = el.EnvMap(sky), el.EnvMap(sky, coverage=seen)
    thresholds = [el.detect(env).report.threshold for env in (whole, part)]
    assert thresholds[1] == pytest.approx(thresholds[0], rel=1e-3)


def test_a_lamp_at_the_border_is_cut_and_one_inside_is_not():
    env = el.EnvMap(
        lamps((1, 0.02, 0), (0, 1, 1)), coverage=np.repeat(np.repeat(ABOVE, 2, 0), 2, 1)
    )
    lights = el.detect(env)
    assert len(lights) == 2
    assert lights.is_cut.tolist() == (lights.elevation < 0.5).tolist()
    (cut,) = (light for light in lights if light.is_cut)
    whole = el.detect(env.radiance * 0 + lamps((1, 0.02, 0), (0, 1, 1)))
    assert cut.flux[0] < 0.9 * whole.flux[:, 0].max()
    assert "cut off" in str(lights)
    assert "cut off" in str(lights[int(np.argmax(lights.is_cut))])
    assert "1 light touches the border of what the map shows" in str(lights)
    assert lights[lights.is_cut].is_cut.tolist() == [True]


def test_the_background_of_a_light_at_the_border_is_what_is_seen(tmp_path):
    radiance = lamps((1, 0.12, 0))
    seen = np.repeat(np.repeat(ABOVE, 2, 0), 2, 1)
    part, whole = el.detect(el.EnvMap(radiance, coverage=seen)), el.detect(radiance)
    np.testing.assert_allclose(part.irradiance, whole.irradiance, rtol=1e-3)
    part.save(tmp_path / "lights.json")
    again = el.detection.DetectedLights.load(tmp_path / "lights.json")
    assert again.is_cut.tolist() == part.is_cut.tolist()
    data = json.loads((tmp_path / "lights.json").read_text())
    del data["is_cut"]
    (tmp_path / "lights.json").write_text(json.dumps(data))
    assert not el.detection.DetectedLights.load(tmp_path / "lights.json").is_cut.any()


@pytest.mark.parametrize("radiance", [0.2, 5.0])
@pytest.mark.parametrize("method", ["tree", "loghin"])
def test_an_even_sky_has_no_light_along_the_border(radiance, method):
    seen = (TOWARDS[..., 2] > 0.3) & (abs(TOWARDS[..., 0]) < 0.6)
    env = el.EnvMap(GREY * radiance * 2, coverage=seen)
    lights = DETECTORS[method](
        env, **({"settings": Settings(relative=True)} if method == "loghin" else {})
    )
    assert len(lights) == 0


@pytest.mark.slow
@pytest.mark.parametrize("path", paths_of_real_maps("hdr/*_1k.hdr"), ids=lambda path: path.stem)
def test_a_missing_nadir_adds_at_most_a_hundredth_to_the_error(path):
    env = el.EnvMap.open(path)
    towards = pixel_directions(env.height, env.width)
    part = el.EnvMap(env.radiance, coverage=towards[..., 1] > -np.sin(np.deg2rad(60)))
    truth = env.probe(NORMALS)
    whole, masked = (
        relative_rms(el.fit(each).probe(NORMALS), truth, SOLID_ANGLES) for each in (env, part)
    )
    assert masked < whole + 0.01
