"""Merged series of exposures against their HDR original, with OpenCV's two merges as peers.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/exposures.py [--maps N] [--stops 2]

Each HDR map becomes 8-bit sRGB pictures, `--stops` apart, until the shortest is not
clipped. All methods know the times and the response, sRGB; the peers get the best scale.

seen: share of all samples that some exposure shows from a quarter of white up to white. error:
relative errors there, the median and the 99 % quantile, the largest; share of the samples that are
more than 1 % off. The last column is the relative error of the flux of the whole map.
"""

import argparse

import cv2
import numpy as np
from clipped_maps import HDR, reduce_width
from tests.helpers import flux, paths_of_real_maps

import envlights as el
from envlights._srgb import decode_srgb, encode_srgb
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


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--maps", type=int, help="number of maps; all of them if left out")
    parser.add_argument("--stops", type=float, default=2.0, help="between two exposures")
    options = parser.parse_args()
    print(f"{'':<48}   seen   median     99 %   largest    > 1 %      flux")
    for path in paths_of_real_maps(*HDR)[: options.maps]:
        radiance = reduce_width(el.EnvMap.open(path).radiance, 512)
        pictures, times = series(radiance, options.stops)
        for name, method in METHODS.items():
            label = f"{path.stem[:20]}, {len(times)} exposures, {name}"
            print(f"{label:<48}{line(method(pictures, times), radiance, times)}", flush=True)


if __name__ == "__main__":
    main()
