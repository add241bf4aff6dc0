"""Repair of clipped maps that show a part of the sphere."""

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights import kernels
from envlights.cli import main
from envlights.kernels.image import LUMINANCE
from tests.helpers import flux
from tests.test_repair import picture, upward

TOWARDS = kernels.pixel_directions(64, 128)
#: Without a part of the ground; with the sky, but without what is low behind; without half the sky.
NO_NADIR = (TOWARDS[..., 1] > -0.5).astype(np.float32)
HALF = (TOWARDS[..., 2] > -0.1).astype(np.float32)


def partial(seen, **options):
    return el.EnvMap(picture(**options) * seen[..., None], clip_level=1.0, coverage=seen)


def gain(env, **options):
    repaired = env.repaired(**options)
    np.testing.assert_array_equal(repaired.coverage, env.coverage)
    assert not repaired.radiance[env.coverage == 0].any()
    assert repaired.source == env.source
    return (flux(repaired.radiance) - flux(env.radiance)) @ LUMINANCE


def test_unseen_ground_is_no_dark_ground():
    whole = el.EnvMap(picture(ground=0.06), clip_level=1.0)
    assert gain(partial(NO_NADIR, ground=0.06)) == pytest.approx(
        (flux(whole.repaired().radiance) - flux(whole.radiance)) @ LUMINANCE, rel=1e-3
    )


@pytest.mark.parametrize("unseen", ["harmonic", "ground", 0.1])
def test_unseen_sky_is_no_dark_sky(unseen):
    whole = el.EnvMap(picture(ground=0.04), clip_level=1.0)
    expected = (flux(whole.repaired().radiance) - flux(whole.radiance)) @ LUMINANCE
    half = partial(HALF, ground=0.04)
    assert gain(half, fill=unseen) == pytest.approx(expected, rel=0.1)
    # Black gives a higher estimate: less light explains the ground.
    assert gain(half, fill="black") > 1.4 * expected


@pytest.mark.parametrize("unseen", ["harmonic", "ground", "black", 0.3])
def test_an_upward_surface_gets_the_measured_irradiance(unseen):
    env = partial(HALF).repaired(irradiance=2.0, fill=unseen)
    assert env.probe([[0, 1, 0]], fill=unseen)[0] @ LUMINANCE == pytest.approx(2.0, rel=1e-3)
    ratio = partial(HALF).repaired(ratio=5.0, fill=unseen)
    clipped = picture()[..., :1] == 1
    shaded = el.EnvMap(np.where(clipped, 0, partial(HALF).radiance), coverage=HALF)
    without = shaded.probe([[0, 1, 0]], fill="black") @ LUMINANCE
    filled = partial(HALF).filled(unseen)
    without = without + upward(filled) - upward(partial(HALF).filled("black"))
    got = ratio.probe([[0, 1, 0]], fill=unseen) @ LUMINANCE
    np.testing.assert_allclose(got, 5 * without, rtol=1e-3)


def test_the_notes_name_the_fill():
    *_, fill, factor = partial(NO_NADIR * (TOWARDS[..., 1] < 0.99)).repaired(irradiance=3).notes
    assert fill.startswith("for the irradiance of the surface, the 2")
    assert fill.endswith("was filled from its border by Laplace's equation")
    assert factor.startswith("the flux was raised by a factor of")


def test_half_a_sky_needs_a_choice():
    with pytest.raises(el.EnvLightsError, match="say what is there by fill="):
        partial(HALF).repaired()
    env = el.EnvMap(picture(sun_deg=0) * 0.5 * HALF[..., None], coverage=HALF, clip_level=1.0)
    assert env.repaired().notes[-1] == "nothing was added: no pixel is clipped"
    with pytest.raises(el.EnvLightsError, match="fill must be"):
        env.repaired(fill="white")


def test_ground_that_is_not_seen_gives_no_estimate():
    above = (TOWARDS[..., 1] > -0.05).astype(np.float32)
    note = partial(above).repaired().notes[-1]
    assert "the ground is not seen, so there is no estimate; give irradiance or ratio" in note


def test_the_command_line_takes_the_choice(tmp_path):
    image = np.concatenate([picture(), HALF[..., None]], axis=2)
    path, out = tmp_path / "half.png", tmp_path / "out.exr"
    cv2 = pytest.importorskip("cv2")
    codes = (255 * np.clip(image, 0, 1) ** [1 / 2.2, 1 / 2.2, 1 / 2.2, 1]).round().astype(np.uint8)
    cv2.imwrite(str(path), codes[..., [2, 1, 0, 3]])
    refused = CliRunner().invoke(main, ["repair", str(path), "-o", str(out)])
    assert refused.exit_code == 2
    done = CliRunner().invoke(main, ["repair", str(path), "-o", str(out), "--fill", "harmonic"])
    assert done.exit_code == 0, done.output
    assert "for the irradiance of the surface" in done.output


def test_a_lux_meter_in_sun_and_shade_counts_the_unseen_sky():
    env = partial(HALF).calibrated(lux=5000, shaded=1000, fill=0.1)
    # The unseen sky is as bright as the seen one, also after the calibration.
    unseen = float(env.radiance[1, 64, 0])
    received = env.probe([[0, 1, 0]], fill=unseen)[0] @ LUMINANCE
    assert received == pytest.approx(5000, rel=1e-3)
    assert not env.radiance[HALF == 0].any()
    with pytest.raises(el.EnvLightsError, match="say what is there by fill="):
        partial(HALF).calibrated(lux=5000, shaded=1000)
