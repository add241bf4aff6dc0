"""Real maps with a hidden part: the probe of each fill, and detection in the seen part.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/unseen.py

First table: relative RMS error of the probe of the filled map against that of the whole one, median
and (worst) over the maps. Spread: `rig.report.unseen_spread`. Second table: error of a fit with 4
lights against the probe of the whole map, without the part below -60 degrees. Third table:
threshold and lights in a view of 90 degrees, of the whole map and of the view alone.
"""

import argparse

import numpy as np
from tests.helpers import NORMALS, SOLID_ANGLES, paths_of_real_maps

import envlights as el
from envlights.kernels.probe import relative_rms
from envlights.kernels.sphere import pixel_directions

MAPS = (
    *("kloppenheim_05_1k", "rooitou_park_1k", "studio_small_03_1k", "lebombo_1k"),
    *("st_peters_square_night_1k", "empty_warehouse_01_1k", "potsdamer_platz_1k"),
    "venice_sunset_1k",
)
FILLS = ("black", "harmonic", "ground")


def view(towards, elevation, width, height=None):
    """Mask of a photograph: width and height are angles of view in degrees."""
    up, turn = np.deg2rad(elevation), np.deg2rad(towards)
    forward = np.array([np.sin(turn) * np.cos(up), np.sin(up), np.cos(turn) * np.cos(up)])
    right = np.array([-np.cos(turn), 0.0, np.sin(turn)])
    above = np.cross(right, forward)
    slopes = [np.tan(np.deg2rad(angle) / 2) for angle in (width, height or width)]

    def mask(directions):
        depth = directions @ forward
        x, y = abs(directions @ right), abs(directions @ above)
        return (depth > 0) & (x < slopes[0] * depth) & (y < slopes[1] * depth)

    return mask


def band(lowest, highest, azimuth=180.0):
    """Mask of all between two elevations, up to an azimuth from the middle, in degrees."""
    low, high = np.sin(np.deg2rad([lowest, highest]))

    def mask(directions):
        around = abs(np.arctan2(directions[..., 0], directions[..., 2]))
        inside = (directions[..., 1] > low) & (directions[..., 1] < high)
        return inside & (around <= np.deg2rad(azimuth))

    return mask


PARTS = {
    "no nadir": band(-60, 91),
    "upper half": band(0, 91),
    "front half": band(-91, 91, 90),
    "crop 180x90": band(-45, 45, 90),
    "strip 360x60": band(-30, 30),
    "photograph 65x40": view(0, 0, 65, 40),
}


def hide(env, mask):
    """The part of a map inside a mask."""
    directions = pixel_directions(env.height, env.width, border_sampled=env.is_border_sampled)
    seen = mask(directions).astype(np.float32)
    return el.EnvMap(
        env.radiance,
        layout=el.io.Layout(registration=env.registration),
        coverage=seen,
        clip_level=env.clip_level,
    )


def probe_error(env, truth):
    """Relative RMS error of the probe."""
    return relative_rms(env.probe(NORMALS), truth, SOLID_ANGLES)


def table_of_fills(maps):
    print("error of the probe    seen", *(f"{fill:>14}" for fill in FILLS), f"{'spread':>14}")
    for name, mask in PARTS.items():
        parts = [hide(env, mask) for env in maps]
        columns = {
            fill: [
                probe_error(part.filled(fill), env.probe(NORMALS))
                for part, env in zip(parts, maps, strict=True)
            ]
            for fill in FILLS
        }
        columns["spread"] = [
            el.fit(part, lights=0, fill="black").report.unseen_spread for part in parts
        ]
        cells = (f"{np.median(each):.3f} ({max(each):.3f})" for each in columns.values())
        print(f"{name:20}  {parts[0].coverage_fraction:.2f}", *(f"{cell:>14}" for cell in cells))


def table_of_fits(maps):
    print("\nfit without nadir  whole map  part  difference")
    for name, env in maps.items():
        truth = env.probe(NORMALS)
        errors = [
            relative_rms(el.fit(each).probe(NORMALS), truth, SOLID_ANGLES)
            for each in (env, hide(env, PARTS["no nadir"]))
        ]
        print(f"{name:26} {errors[0]:.4f}  {errors[1]:.4f}  {errors[1] - errors[0]:+.4f}")


def table_of_views(maps):
    print("\nview of 90 degrees          whole: threshold  lights in view  view: threshold  lights")
    for name, env in maps.items():
        whole = el.detect(env)
        for towards in (0, 90, 180, 270):
            mask = view(towards, 35, 90)
            part = el.detect(hide(env, mask))
            inside = int(mask(whole.direction).sum()) if len(whole) else 0
            print(
                f"{name:26} {towards:3} {whole.report.threshold:10.3g} {inside:15}"
                f" {part.report.threshold:16.3g} {len(part):7}, {int(part.is_cut.sum())} cut"
            )


def main():
    argparse.ArgumentParser(description=__doc__.splitlines()[0]).parse_args()
    maps = {
        path.stem: el.EnvMap.open(path)
        for path in paths_of_real_maps(*(f"hdr/{name}.hdr" for name in MAPS))
    }
    table_of_fills(list(maps.values()))
    table_of_fits(maps)
    table_of_views(maps)


if __name__ == "__main__":
    main()
