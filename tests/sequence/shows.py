"""Sequences of maps with a known motion of the lights, for tests and benchmarks."""

import numpy as np
from scipy.spatial.transform import Rotation

import envlights as el
from envlights.kernels import pixel_directions
from envlights.synthetic import Disc

#: Radiance of the walls around the lamps.
WALLS = (0.3, 0.32, 0.35)


def towards(azimuth_deg, elevation_deg):
    """Unit vector; azimuth from +z towards +x."""
    azimuth, elevation = np.deg2rad([azimuth_deg, elevation_deg])
    horizontal = np.cos(elevation)
    return np.array([horizontal * np.sin(azimuth), np.sin(elevation), horizontal * np.cos(azimuth)])


def room(lamps, height):
    """Map of disc lamps in a room of one radiance."""
    return el.EnvMap(el.synthetic.scene(height, background=WALLS, shapes=lamps).radiance)


def about_pole(degrees):
    return Rotation.from_euler("y", degrees, degrees=True).as_matrix()


def turning(env, frames, step_deg=0.5):
    """A map that turns about the pole."""
    for k in range(frames):
        yield env.rotated(about_pole(step_deg * k))


def switch(frames, on, off, height=64):
    """A lamp that burns in the frames from `on` to `off`, beside one that always burns."""
    steady, switched = (
        Disc(towards(30, 40), 6, (40, 38, 30)),
        Disc(towards(-60, 20), 5, (20, 25, 30)),
    )
    dark, lit = room([steady], height), room([steady, switched], height)
    for k in range(frames):
        yield lit if on <= k < off else dark


def crossing(frames, height=128):
    """Two lamps that cross 10 degrees above each other, by 1 degree of azimuth in a frame."""
    half = frames / 2
    for k in range(frames):
        yield room(
            [
                Disc(towards(k - half, 35), 5, (60, 50, 30)),
                Disc(towards(half - k, 25), 5, (30, 40, 60)),
            ],
            height,
        )


def exposure_noise(frames, relative=0.01, height=64):
    """A room whose exposure has independent noise in each frame."""
    lamps = [Disc(towards(30, 40), 6, (40, 38, 30)), Disc(towards(-60, 20), 5, (20, 25, 30))]
    env, rng = room(lamps, height), np.random.default_rng(0)
    for _ in range(frames):
        yield el.EnvMap(env.radiance * np.float32(1 + relative * rng.standard_normal()))


def sun_through_clouds(frames, height=128, drift=0.005):
    """A sun that rises through clouds, which drift by that many of their heights in a frame."""
    x, y, z = np.moveaxis(pixel_directions(height, 2 * height), -1, 0)
    flat, is_sky = np.maximum(y, 0.05), (y > 0)[..., None]
    for k in range(frames):
        sun = towards(20 + 0.05 * k, 15 + 0.1 * k)
        clear = el.synthetic.clear_sky(height, sun).radiance
        p, q = x / flat + drift * k, z / flat
        waves = np.sin(1.3 * p + 0.4 * q) + np.sin(0.7 * p - 1.1 * q + 1)
        thickness = np.clip(0.6 * (waves + 0.5 * np.sin(2.3 * p + 1.9 * q)), 0, 1)
        passed = np.exp(-2.5 * thickness**2 * (3 - 2 * thickness))[..., None]
        cloudy = clear * passed + 0.25 * (1 - passed)
        yield el.EnvMap(np.where(is_sky, cloudy, clear).astype(np.float32))
