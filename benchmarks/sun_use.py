"""Irradiance under 8-bit pictures of made skies, repaired without and with their sun.

`python benchmarks/sun_use.py` prints the table of docs/lab/sun.md, and draws docs/sun.png.
"""

from pathlib import Path

import numpy as np
from tests.helpers import NORMALS
from tests.sun.suns import photograph

import envlights as el

#: Elevation of the sun in degrees, and white share of the sphere.
PICTURES = ((50, 0.01), (50, 0.05), (30, 0.001), (30, 0.05), (10, 0.05))
AZIMUTH, RATIO, ROWS = np.radians(140), 4.0, 512


def towards(elevation):
    """Unit vector towards the sun."""
    flat = np.cos(elevation)
    return np.array([flat * np.sin(AZIMUTH), np.sin(elevation), -flat * np.cos(AZIMUTH)])


def errors(env, white, truth):
    """Relative error at the best common scale, and at the scale of the picture."""
    seen = white * env.probe(NORMALS)
    best = (seen * truth).sum() / (seen**2).sum()
    return [np.linalg.norm(k * seen - truth) / np.linalg.norm(truth) for k in (best, 1.0)]


def main():
    """Print the table, and draw the picture."""
    print("| elevation, white | picture | `repaired()` | `repaired(sun='auto')` | and `ratio` |")
    print("|---|---|---|---|---|")
    for degrees, share in PICTURES:
        sun = towards(np.radians(degrees))
        radiance = el.synthetic.clear_sky(ROWS, sun, ratio=RATIO).radiance
        truth = el.EnvMap(radiance).probe(NORMALS)
        env, white = photograph(radiance, share)
        ratio = 1 + RATIO * sun[1]
        maps = (
            env,
            env.repaired(),
            el.with_sun(env, "auto").to_map(),
            el.with_sun(env, "auto", ratio=ratio).to_map(),
        )
        cells = ("{:.2f} ({:.2f})".format(*errors(each, white, truth)) for each in maps)
        print(f"| {degrees}°, {100 * share:g} % | {' | '.join(cells)} |")
    env, _ = photograph(el.synthetic.clear_sky(ROWS, (0.5, 0.6, 0.62)).radiance, 0.05)
    el.plot.save(el.plot.sun(env), Path(__file__).parents[1] / "docs/sun.png")


if __name__ == "__main__":
    main()
