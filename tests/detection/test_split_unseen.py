"""Lights removed from maps that show a part of the sphere."""

import numpy as np
import pytest

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from envlights.synthetic import Disc
from tests.conftest import real_maps
from tests.detection.worlds import SKY, world

HEIGHT = 256
TOWARDS = pixel_directions(HEIGHT, 2 * HEIGHT)
#: Shares with a sharp and with a soft border, which the lights below touch.
SHARES = {
    "upper half": (TOWARDS[..., 1] > 0).astype(np.float32),
    "soft border": np.clip(20 * TOWARDS[..., 1] + 0.5, 0, 1).astype(np.float32),
    "front": (TOWARDS[..., 2] > 0.2).astype(np.float32),
    "translucent": np.where(TOWARDS[..., 1] > 0, 0.4, 0).astype(np.float32),
}
LAMPS = [(0.3, 0.0, 1), (0.3, 0.05, 1), (0.3, 0.12, 1), (1, 0.02, 0.25), (0.2, 0.5, 1)]


def partial(radiance, seen, registration="cell-centred"):
    return el.EnvMap(
        radiance * seen[..., None], layout=el.io.Layout(registration=registration), coverage=seen
    )


@pytest.mark.parametrize("seen", SHARES.values(), ids=SHARES)
@pytest.mark.parametrize("direction", LAMPS)
def test_a_disc_at_the_border_leaves_the_sky_that_is_seen(seen, direction):
    scene = world([Disc(direction, 4.0, (90, 60, 30))], HEIGHT)
    env = partial(scene.radiance, seen)
    lights, rest = el.split(env)
    assert len(lights) == 1
    expected = SKY.astype(np.float32) * seen[..., None]
    np.testing.assert_allclose(rest.radiance, expected, rtol=1e-4, atol=1e-7)
    np.testing.assert_array_equal(rest.coverage, seen)
    assert not rest.radiance[seen == 0].any()
    # Flux, irradiance and direction are those of the part that is seen.
    removed = (env.radiance.astype(float) - rest.radiance) * pixel_solid_angles(HEIGHT, 2 * HEIGHT)[
        ..., None
    ]
    np.testing.assert_allclose(lights.flux[0], removed.sum(axis=(0, 1)), rtol=1e-6)
    vector = np.einsum("hwc,hwk->ck", removed, TOWARDS)
    np.testing.assert_allclose(lights.vector_irradiance[0], vector, rtol=1e-4, atol=1e-4)
    whole = (env.radiance @ LUMINANCE * pixel_solid_angles(HEIGHT, 2 * HEIGHT)).sum()
    np.testing.assert_allclose(
        lights.flux_fraction[0], removed.sum((0, 1)) @ LUMINANCE / whole, 1e-6
    )
    assert len(el.split(rest).lights) == 0


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_a_gradient_is_continued_from_what_is_seen(registration):
    """The logarithm of tan(theta / 2) solves Laplace's equation on the sphere."""
    last = HEIGHT - 1 if registration == "border-sampled" else HEIGHT
    first = 0.0 if registration == "border-sampled" else 0.5
    theta = np.pi * np.clip(np.arange(HEIGHT) + first, 30, last - 30) / last
    sky = 5 + np.log(np.tan(theta / 2))[:, None, None] * np.ones((1, 2 * HEIGHT, 3))
    lamp = world([Disc((0.3, 0.04, 1), 4.0, (900, 800, 700))], HEIGHT, (0, 0, 0)).radiance
    seen = SHARES["upper half"]
    lights, rest = el.split(partial((sky + lamp).astype(np.float32), seen, registration))
    assert len(lights) == 1
    # A fill from black would be off by the sky itself.
    np.testing.assert_allclose(rest.radiance[seen == 1], sky[seen == 1], rtol=0.03)


def test_the_note_names_lights_at_the_border():
    scene = world([Disc((0.3, 0.0, 1), 4.0, (90, 60, 30))], HEIGHT).radiance
    _, cut = el.split(partial(scene, SHARES["upper half"]))
    note = "1 removed light lies at the border of what the map shows, so only the seen part was"
    assert cut.notes[-1].startswith(note)
    _, whole = el.split(el.EnvMap(scene))
    assert "border" not in " ".join(whole.notes)


def test_a_map_of_share_one_is_split_as_a_whole_one():
    scene = world([Disc((0.3, 0.2, 1), 4.0, (90, 60, 30))], HEIGHT).radiance
    seen = np.ones(scene.shape[:2], np.float32)
    seen[-1, 0] = 0
    some, whole = el.split(partial(scene, seen)), el.split(el.EnvMap(scene))
    np.testing.assert_array_equal(some.remainder.radiance[:-1], whole.remainder.radiance[:-1])
    np.testing.assert_array_equal(some.lights.irradiance, whole.lights.irradiance)


# Not the overcast sky of Potsdamer Platz: without a half, another part of it is the light.
@real_maps("hdr/[!p]*_1k.hdr")
def test_the_seen_half_of_a_real_map_is_split_as_in_the_whole_map(path):
    env = el.EnvMap.open(path)
    towards = pixel_directions(env.height, env.width, border_sampled=env.is_border_sampled)
    lights, rest = el.split(env, 1)
    # The border lies 3 degrees below the brightest light.
    centre = lights.direction[0]
    below = np.array([0, -1, 0]) - centre * -centre[1]
    below /= np.linalg.norm(below)
    seen = (towards @ below < np.sin(np.deg2rad(3))).astype(np.float32)
    half = partial(env.radiance, seen, env.registration)
    (_, remains) = el.split(half, el.detect(half, rise=2.25, min_worth=0.0)[:1])
    luminance, expected = ((each.radiance @ LUMINANCE)[seen == 1] for each in (remains, rest))
    weights = pixel_solid_angles(env.height, env.width)[seen == 1]
    assert np.abs(luminance - expected) @ weights < 0.1 * (expected @ weights)
