"""Merged series of exposures against their HDR original, with OpenCV's two merges as peers.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/exposures.py [--maps N] [--stops 2]

Each HDR map becomes 8-bit sRGB pictures, `--stops` apart, until the shortest is not
clipped. All methods know the times and the response, sRGB; the peers get the best scale.

seen: share of all samples that some exposure shows from a quarter of white up to white. error:
relative errors there, the median and the 99 % quantile, the largest; share of the samples that are
more than 1 % off. The last column is the relative error of the flux of the whole map.

Then five exposures as cameras write them, JPEG with halved colour: numbers of maps whose irradiance
facing the sun is within 5 %, whose probe is within 2 % (luminance, then RGB), and median errors.
"""

import argparse
import tempfile
from pathlib import Path

import cv2
import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
from clipped_maps import HDR, reduce_width
from numpy.linalg import norm
from tests.helpers import NORMALS, flux, paths_of_real_maps
from tests.reference.camera_curves import filmic, rec709, shoulder

import envlights as el
from envlights import kernels
from envlights._common.srgb import decode_srgb, encode_srgb
from envlights.environment.exposures import alignment
from envlights.kernels.image import LUMINANCE

#: The median luminance in the longest exposure.
LONGEST = 0.5

#: The response of sRGB for OpenCV: the exposure of each code.
RESPONSE = np.repeat(np.maximum(decode_srgb(np.arange(256) / 255), 1e-5)[:, None, None], 3, axis=2)


def series(radiance, stops):
    """Pictures and times."""
    times = [LONGEST / np.median(radiance)]
    while times[-1] * radiance.max() > 0.95:
        times.append(times[-1] / 2**stops)
    return [np.round(255 * encode_srgb(radiance * time)).astype(np.uint8) for time in times], times


def ours(pictures, times):
    return el.EnvMap.from_exposures(pictures, times).radiance


def opencv(merge):
    def method(pictures, times):
        return merge().process(pictures, np.array(times, np.float32), RESPONSE)

    return method


METHODS = {
    "ours": ours,
    "OpenCV, Debevec": opencv(cv2.createMergeDebevec),
    "OpenCV, Robertson": opencv(cv2.createMergeRobertson),
}


def line(found, radiance, times):
    exposed = [radiance * time for time in times]
    seen = np.any([(each > 0.25) & (each < 0.98) for each in exposed], axis=0)
    found = np.nan_to_num(found.astype(np.float64), posinf=0.0)
    found *= np.median(radiance[seen] / np.maximum(found[seen], 1e-30))
    error = np.abs(found / np.maximum(radiance, 1e-30) - 1)[seen]
    total = (flux(found) @ LUMINANCE) / (flux(radiance) @ LUMINANCE) - 1
    median, most = np.quantile(error, [0.5, 0.99])
    return (
        f"{100 * seen.mean():>5.1f} %{100 * median:>8.2f} %{100 * most:>8.2f} %"
        f"{100 * error.max():>9.2f} %{100 * (error > 0.01).mean():>8.2f} %{100 * total:>9.2f} %"
    )


# Series as cameras write them.


def rotate(radiance, pixels):
    turn = np.random.default_rng(7).normal(size=3)
    turn *= pixels * 2 * np.pi / radiance.shape[1] / np.linalg.norm(turn)
    return el.EnvMap(radiance).rotated(alignment.rotation(turn)).radiance


#: Columns and rows that each picture is shifted by.
SHIFTS = ((3, 0), (-1, 0), (0, 0), (2, 0), (1, 0))
BOTH = ((3, -2), (-1, 1), (0, 0), (2, 2), (1, -1))

#: Kinds of series: options of `camera_series`.
KINDS = {
    "quality 90": {},
    "quality 80": {"quality": 80},
    "quality 100": {"quality": 100},
    "quality 90, 4:4:4": {"sampling": "4:4:4"},
    "white at 250": {"white": 250},
    "white at 235": {"white": 235},
    "Rec.709": {"curve": rec709},
    "gamma 1.8 with shoulder": {"curve": shoulder},
    "filmic": {"curve": filmic},
    "columns shifted": {"shifts": SHIFTS},
    "columns and rows shifted": {"shifts": BOTH},
    "rotated by 0 to 3 pixels": {"turns": (2, 0, 1, 3, 0)},
    "second time doubled": {"wrong": (1, 2.0)},
    "fourth time times 0.4": {"wrong": (3, 0.4)},
    "filmic, third time times 1.5": {"curve": filmic, "wrong": (2, 1.5)},
}


def camera_series(
    radiance,
    folder,
    *,
    curve=encode_srgb,
    quality=90,
    sampling="4:2:0",
    clip_level=255,
    shifts=None,
    turns=None,
    wrong=None,
):
    """Files and stated times of five exposures."""
    times = np.geomspace(0.8 / radiance.max(), 0.5 / np.median(radiance), 5)
    paths = []
    for place, time in enumerate(times):
        moved = radiance
        if shifts:
            moved = np.roll(radiance, shifts[place], (1, 0))
        if turns and turns[place]:
            moved = rotate(radiance, turns[place])
        codes = np.minimum(np.round(255 * curve(moved * time)), clip_level).astype(np.uint8)
        spec = oiio.ImageSpec(*codes.shape[1::-1], 3, "uint8")
        spec.attribute("Compression", f"jpeg:{quality}")
        spec.attribute("jpeg:subsampling", sampling)
        paths.append(str(Path(folder) / f"{place}.jpg"))
        file = oiio.ImageOutput.create(paths[-1])
        file.open(paths[-1], spec)
        file.write_image(codes)
        file.close()
    if wrong:
        times[wrong[0]] *= wrong[1]
    return paths, list(times)


def errors(env, radiance):
    """Relative errors of irradiance facing the sun, and of the probe, both luminance and RGB."""
    luminance = radiance @ LUMINANCE
    place = np.unravel_index(np.argmax(luminance), luminance.shape)
    sun = kernels.pixel_directions(*luminance.shape)[place]
    # Exposures say nothing about the scale: the median is made equal.
    middle = (luminance > np.quantile(luminance, 0.4)) & (luminance < np.quantile(luminance, 0.9))
    scale = np.median((luminance / np.maximum(env.radiance @ LUMINANCE, 1e-30))[middle])
    normals = np.vstack([sun, NORMALS])
    right, found = el.EnvMap(radiance).probe(normals), env.probe(normals) * scale
    grey = [each @ LUMINANCE for each in (right, found)]
    facing = grey[1][0] / grey[0][0] - 1
    return facing, *(norm(f[1:] - r[1:]) / norm(r[1:]) for r, f in (grey, (right, found)))


def camera_table(maps):
    """Print the share of the maps within 5 % and 2 %, and the medians, for each kind of series."""
    print(f"\n{'':<30}  maps refused  sun 5 %  probe 2 %  RGB 2 %    medians")
    for kind, options in KINDS.items():
        rows, refused = [], 0
        for radiance in maps:
            with tempfile.TemporaryDirectory() as folder:
                try:
                    env = el.EnvMap.from_exposures(*camera_series(radiance, folder, **options))
                    rows.append(np.abs(errors(env, radiance)))
                except el.EnvLightsError:
                    refused += 1
        limits = (np.array(rows) <= [0.05, 0.02, 0.02]).sum(axis=0)
        medians = "".join(f"{100 * each:>8.2f} %" for each in np.median(rows, axis=0))
        counts = "".join(f"{count:>9}" for count in limits)
        print(f"{kind:<30}{len(maps):>6}{refused:>8}{counts} {medians}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, help="number of maps; all of them if left out")
    parser.add_argument("--stops", type=float, default=2.0, help="between two exposures")
    parser.add_argument("--cameras", action="store_true", help="only the second table")
    options = parser.parse_args()
    paths = paths_of_real_maps(*HDR)[: options.maps]
    maps = {path: reduce_width(el.EnvMap.open(path).radiance, 512) for path in paths}
    if not options.cameras:
        peers_table(maps, options.stops)
    camera_table([np.maximum(radiance, 1e-6) for radiance in maps.values()])


def peers_table(maps, stops):
    print(f"{'':<48}   seen   median     99 %   largest    > 1 %      flux")
    for path, radiance in maps.items():
        pictures, times = series(radiance, stops)
        for name, method in METHODS.items():
            label = f"{path.stem[:20]}, {len(times)} exposures, {name}"
            print(f"{label:<48}{line(method(pictures, times), radiance, times)}", flush=True)


if __name__ == "__main__":
    main()
