"""Lights of real maps in views of them: photographs with linear values and with 8 bits.

Usage: python benchmarks/photographs.py [--elevation DEGREES] [--turn DEGREES] [--each]

The maps are those of the folder `ENVLIGHTS_MAPS`. Each gives four views of 90 degrees, 1024x576
pixels, by a pinhole camera that looks `--elevation` degrees up. A light of the map that lies
wholly in a view is found if a light of the photograph is within one degree. `near` is the
fraction of the photograph's lights within two degrees, or its radius, of a light of the map. For
8 bits, the view is exposed so that 2 % of its pixels are white.

Defaults of `detect_photograph` were chosen on the views of `hdr/` at 20 degrees without a turn.
"""

import argparse
import sys
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

import envlights as el
from envlights._common.srgb import encode_srgb

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.helpers import angle_deg, paths_of_real_maps
from tests.reference import photograph

SIZE, FOV = (576, 1024), 90
ARTICLE = {
    "relative": False,
    "move_to_maximum": False,
    "samples_per_pixel": 0.006,
    "window_px": 12,
    "suppression_px": 20.0,
}
WAYS = {
    "article, Halton": ARTICLE,
    "article, Hammersley": {**ARTICLE, "sampling": "hammersley"},
    "default, Halton": {},
    "default, Hammersley": {"sampling": "hammersley"},
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--elevation", type=float, default=20.0)
    parser.add_argument("--turn", type=float, default=0.0)
    parser.add_argument("--each", action="store_true", help="also a line for each map")
    options = parser.parse_args()
    for folder in ("hdr/*.hdr", "exr/*.exr"):
        paths = paths_of_real_maps(folder)
        views = [view for path in paths for view in views_of(path, options)]
        print(f"\n{folder}: {sum(len(d) for _, _, d, _ in views)} lights in {len(views)} views")
        print(f"{'':<24}{'values':>8}{'< 1°':>7}{'median':>9}{'lights':>8}{'near':>7}{'time':>10}")
        for name, settings in WAYS.items():
            for values, picture in (("linear", np.asarray), ("8 bits", codes)):
                print(row(name, values, views, picture, settings), flush=True)
        if options.each:
            for path in paths:
                own = [view for view in views if view[0] == path.name]
                print(row(path.name[:23], "linear", own, np.asarray, {}))


def views_of(path, options):
    """Name of the map, picture, and directions and radii of the lights in view."""
    try:
        env = el.EnvMap.open(path)
    except el.EnvLightsError as refusal:
        print(f"skipped: {refusal}")
        return
    lights = el.detect(env)
    for azimuth in (0, 90, 180, 270):
        axes = photograph.axes_of_view(azimuth + options.turn, options.elevation)
        image = photograph.view(env.cells(), axes, *SIZE, FOV, places=2)
        d, inside = photograph.directions_in_view(lights, axes, *SIZE, FOV)
        yield path.name, image, d[inside], np.rad2deg(lights.angular_radius[inside])


def codes(image):
    white = np.percentile(image.max(axis=2), 98) or 1.0
    return np.round(255 * encode_srgb(image / white)).astype(np.uint8)


def row(name, values, views, picture, changes):
    nearest, lights, near, seconds = [], 0, 0, []
    for _, image, d, radii in views:
        given = picture(image)
        start = time.perf_counter()
        settings = replace(el.papers.loghin.PHOTOGRAPH, **changes)
        found = el.detect_photograph(given, FOV, settings=settings)
        seconds.append(time.perf_counter() - start)
        angles = angle_deg(d[:, None], found.direction[None])
        nearest += angles.min(axis=1, initial=180.0).tolist()
        lights += len(found)
        near += (angles < np.maximum(radii, 2)[:, None]).any(axis=0).sum()
    nearest = np.array(nearest or [np.nan])
    return (
        f"{name:<24}{values:>8}{np.mean(nearest < 1):>7.3f}{np.median(nearest):>8.2f}°"
        f"{lights:>8}{near / max(lights, 1):>7.2f}{1e3 * np.median(seconds):>7.1f} ms"
    )


if __name__ == "__main__":
    main()
