"""Split maps beside the maps themselves: closure, images, noise and time.

    ENVLIGHTS_MAPS=folder python benchmarks/split.py

Images are of a ball and a box on a floor, by Mitsuba, in 60 x 40 pixels. The error is that of
lights and rest together, without the noise. Then comes the noise of the map alone, and of both at a
quarter and at a half of its paths: with three bounces, and of the direct light alone. Lights and
rest are rendered apart and added; they share the paths in proportion to their noise.
"""

from pathlib import Path
from time import perf_counter

import numpy as np
from tests.helpers import EQUIRECTANGULAR, paths_of_real_maps

import envlights as el
from envlights.scene.mitsuba.path_traced import Still
from envlights.scene.still_life import still_life

#: Paths of the images for the error, and of those for the noise, over four.
_EXACT, _NOISY = 200, 128
_NORMALS, _SOLID_ANGLES = el.kernels.icosphere(5120)
#: Rows of the map in which the lights are drawn as discs.
_ROWS = 1024


def main():
    print(
        f"{'map':>24} {'removed':>9} {'flux':>6} {'closure':>8} {'colour':>8} {'again':>6}"
        f" {'probe':>7} {'image':>7} {'noise':>7}   noise: map, 1/4, 1/2 of paths; direct light"
    )
    for path in paths_of_real_maps(*EQUIRECTANGULAR):
        env = el.EnvMap.open(path)
        env = env if env.registration == "cell-centred" else el.EnvMap(env.radiance)
        rows = {"sun": el.split(env, 1), "all": el.split(env)}
        truth = None
        for name, parts in rows.items():
            if len(parts.lights) and (name == "sun" or len(parts.lights) > 1):
                truth = truth or _image(env, parts)
                print(_row(path, env, name, parts, truth), flush=True)
    _times()


def _image(env, parts):
    """Azimuth of the brightest light, from which the scene is viewed, and its image."""
    azimuth = 2 * np.pi * el.kernels.direction_to_uv(parts.lights.direction[:1])[0, 0]
    return azimuth, _still(env, azimuth, _EXACT, 1)


def _still(env, azimuth, paths, seed, bounces=3):
    """The scene under a map; four pixels are averaged to one, which halves the noise."""
    still = still_life(env, azimuth, paths, seed, bounces)
    return Still(*(image.reshape(40, 2, 60, 2, 3).mean(axis=(1, 3)) for image in still))


def _row(path, env, name, parts, truth):
    azimuth, exact = truth
    lights, rest = parts
    discs = lights.to_map(_ROWS)
    apart = [_still(light, azimuth, _EXACT, 3 + seed) for seed, light in enumerate((rest, discs))]
    together = _sum(*apart)
    noise = [_noise(env, (rest, discs), azimuth, bounces) for bounces in (3, 1)]
    closed, colour = _closure(env, lights, rest)
    again = el.detect(rest)
    seen = rest.probe(_NORMALS) + discs.probe(_NORMALS)
    probe = el.kernels.relative_rms(seen, env.probe(_NORMALS), _SOLID_ANGLES)
    return (
        f"{Path(path).stem[:24]:>24} {name} {len(lights):>5} {lights.flux_fraction.sum():>6.1%}"
        f" {closed:>8.1e} {colour:>8.1e} {len(again) if name == 'all' else '':>6} {probe:>7.2%}"
        f" {together.error(exact):>7.2%} {max(exact.noise, together.noise):>7.2%}"
        f"   {noise[0]}   {noise[1]}"
    )


def _noise(env, parts, azimuth, bounces):
    """Noise of the map alone, and of both parts at a quarter and at a half of its paths."""
    pilot = [_still(light, azimuth, _NOISY // 4, 3, bounces) for light in parts]
    first = _norm_of_noise(pilot[0]) / sum(map(_norm_of_noise, pilot))
    map_alone = _still(env, azimuth, _NOISY, 4, bounces).noise
    stills = []
    for fours in (_NOISY // 8, _NOISY // 4):
        # Paths come in fours for each of two images.
        own = min(max(round(fours * first), 1), fours - 1)
        shares = zip(parts, (own, fours - own), (5, 6), strict=True)
        halves = (_still(light, azimuth, 2 * own, seed, bounces) for light, own, seed in shares)
        stills.append(_sum(*halves))
    return ", ".join(f"{noise:.2%}" for noise in (map_alone, *(still.noise for still in stills)))


def _sum(rest, discs):
    return Still(rest.one + discs.one, rest.two + discs.two)


def _norm_of_noise(still):
    return still.noise * np.linalg.norm(still.image)


def _closure(env, lights, rest):
    """Largest relative difference where each light is whole or hidden: luminance, channels."""
    cosine = _NORMALS @ lights.direction.T
    # A light that reaches a right angle from its direction is seen whole by no surface.
    whole = (np.abs(cosine) > np.sin(np.minimum(lights.reach, np.pi / 2))).all(axis=1)
    if not whole.any():
        return np.nan, np.nan
    truth = env.probe(_NORMALS[whole])
    seen = rest.probe(_NORMALS[whole]) + np.maximum(cosine[whole], 0) @ lights.irradiance
    luminance = el.kernels.image.LUMINANCE
    closed = np.abs(seen @ luminance / (truth @ luminance) - 1).max()
    return closed, np.abs(seen / truth - 1).max()


def _times():
    """A map of 4096 x 2048 pixels with a sun: `split` beside `detect` and a copy."""
    sky = el.synthetic.hard(3).radiance
    env = el.EnvMap(
        np.ascontiguousarray(sky.repeat(2048 // len(sky), 0).repeat(2048 // len(sky), 1))
    )

    def best(work):
        laps = []
        for _ in range(7):
            start = perf_counter()
            work()
            laps.append(perf_counter() - start)
        return 1e3 * min(laps)

    detect, copy = best(lambda: el.detect(env)), best(env.radiance.copy)
    whole = best(lambda: el.split(env))
    print(
        f"4096x2048: detect {detect:.0f} ms, copy {copy:.0f} ms, split {whole:.0f} ms,"
        f" {(whole - copy) / detect:.1f} times detect beside the copy"
    )


if __name__ == "__main__":
    main()
