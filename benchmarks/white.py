"""Clip levels that are missed and false ones, of 8-bit pictures whose clip level is known.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/white.py [--held-out FOLDER] [--seeds N]

Each HDR map becomes pictures by several exposures, curves, clip levels and qualities of JPEG. A
picture is clipped if values beyond its clip level cover 2e-5 of the sphere and 8 pixels, and not
clipped if there are none; others do not count. A clipped picture is missed if the level is more
than 2 codes off, where all from 254 on are one level; a false level is any below 254.

The settings of `src/kernels/image/white.rs` were chosen on the maps of `ENVLIGHTS_MAPS`, which are
listed as `tuning`. Held out are the maps of another folder, and generated ones.
"""

import argparse
import itertools
import pickle
from collections import Counter
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from clipped_maps import HDR, reduce_width
from tests.helpers import paths_of_real_maps
from tests.reference.camera_curves import filmic, shoulder

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.environment.clip_level import CodeHistogram

COLUMNS = 512
#: Linear value of the median of the sphere in each exposure.
EXPOSURES = (0.1, 0.35)
#: Curves of linear values, where 1 and more is clipped.
CURVES = {
    "sRGB": encode_srgb,
    "gamma 2.2": lambda x: np.clip(x, 0, 1) ** (1 / 2.2),
    "shoulder": shoulder,
    "filmic": lambda x: filmic(x / 6),
}
#: Curves that reach 1 nowhere.
OPEN = {
    "x / (1 + x)": lambda x: encode_srgb(x / (1 + x)),
    "1 - exp(-x)": lambda x: encode_srgb(np.minimum(1 - np.exp(-x), 0.998)),
}
LEVELS = (235, 250, 254, 255)
#: Qualities of JPEG with halved colour; 0 is a file without loss.
QUALITIES = (0, 100, 90, 80)
#: Largest value of a map that is exposed so that nothing is clipped.
PEAKS = (0.5, 0.7, 0.85, 0.95)
LEAST_FRACTION, LEAST_PIXELS = 2e-5, 8


class Picture(NamedTuple):
    """Histogram of a picture, and what is known of it."""

    maps: str
    name: str
    curve: str
    level: int
    """Clip level; 0 if nothing is clipped."""
    quality: int
    histogram: np.ndarray


def compress(codes, quality):
    """Codes after JPEG compression with halved colour."""
    if not quality:
        return codes
    sampling = cv2.IMWRITE_JPEG_SAMPLING_FACTOR_420
    options = [cv2.IMWRITE_JPEG_QUALITY, quality, cv2.IMWRITE_JPEG_SAMPLING_FACTOR, sampling]
    _, data = cv2.imencode(".jpg", codes[..., ::-1], options)
    return np.ascontiguousarray(cv2.imdecode(data, cv2.IMREAD_COLOR)[..., ::-1])


def histogram_of(codes):
    """Solid angle of each code."""
    histogram = CodeHistogram(len(codes))
    histogram.add(codes)
    return histogram.sums


def is_clipped(is_beyond):
    """True, False, or None for a few pixels."""
    if not is_beyond.any():
        return False
    edges = np.cos(np.linspace(0, np.pi, len(is_beyond) + 1))
    fraction = (edges[:-1] - edges[1:]) @ is_beyond.mean(axis=1) / 2
    is_enough = fraction > LEAST_FRACTION and is_beyond.sum() >= LEAST_PIXELS
    return True if is_enough else None


def renderings(radiance):
    """Curve, level and codes of each picture of a map; level 0 if nothing is clipped."""
    middle = np.median(radiance.max(axis=2)) or radiance.mean()
    for exposure, (curve, level) in itertools.product(EXPOSURES, itertools.product(CURVES, LEVELS)):
        coded = CURVES[curve](radiance * (exposure / middle))
        # Every other picture is scaled to its level, the rest cut off there.
        scale = level if (exposure == EXPOSURES[0]) == (curve == "sRGB") else 255
        clipped = is_clipped((coded * scale > level - 0.5).any(axis=2))
        if clipped is not None:
            codes = np.minimum(np.round(coded * scale), level)
            yield curve, level if clipped else 0, codes
    for exposure, curve in itertools.product(EXPOSURES, OPEN):
        yield curve, 0, np.round(255 * OPEN[curve](radiance * (exposure / middle)))
    for peak in PEAKS:
        yield f"peak {peak}", 0, np.round(255 * encode_srgb(radiance * (peak / radiance.max())))


def pictures(maps, name, radiance):
    """All pictures of a map."""
    for curve, level, codes in renderings(radiance):
        codes = codes.astype(np.uint8)
        for quality in QUALITIES:
            histogram = histogram_of(compress(codes, quality))
            yield Picture(maps, name, curve, level, quality, histogram)


def all_maps(folder, seeds):
    """Set, name and radiance of each map."""
    for path in paths_of_real_maps(*HDR):
        radiance = reduce_width(el.EnvMap.open(path).radiance, COLUMNS)
        yield "tuning", path.stem, radiance
        yield "halves of tuning", path.stem, radiance[:, : len(radiance)]
    for path in sorted(Path(folder).rglob("*.[eh][xd]r")) if folder else ():
        yield "held out", path.stem, reduce_width(el.EnvMap.open(path).radiance, COLUMNS)
    for family, seed in itertools.product(("plain", "hard", "openings"), range(1000, 1000 + seeds)):
        scene = getattr(el.synthetic, family)(seed, height=256)
        if "clip" not in scene.note and "bit" not in scene.note:
            yield f"generated, {family}", str(seed), scene.radiance.astype(np.float64)


def verdict(picture):
    """Kind of a picture, and True if its level is wrong."""
    histogram = CodeHistogram(2)
    histogram.sums = picture.histogram
    code = histogram.white_code()
    if not picture.level:
        return "unclipped", code < 254
    wanted = 255 if picture.level >= 254 else picture.level
    return f"clipped at {picture.level}", abs(code - wanted) > 2


def table(found, keys):
    """Print wrong ones of all, by set and by a key."""
    counts, wrong = Counter(), Counter()
    for picture in found:
        kind, is_wrong = verdict(picture)
        for key in keys(picture, kind):
            counts[key] += 1
            wrong[key] += is_wrong
    for key in sorted(counts):
        percent = 100 * wrong[key] / counts[key]
        print(f"| {' | '.join(key)} | {wrong[key]} of {counts[key]} | {percent:.1f} % |")


def main():
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--held-out", metavar="FOLDER", help="folder of other HDR maps")
    parser.add_argument("--seeds", type=int, default=12, help="generated maps of each family")
    parser.add_argument("--store", metavar="FILE", help="keep the histograms, or use those kept")
    options = parser.parse_args()
    if options.store and Path(options.store).exists():
        found = pickle.loads(Path(options.store).read_bytes())
    else:
        maps = all_maps(options.held_out, options.seeds)
        found = [picture for one in maps for picture in pictures(*one)]
        if options.store:
            Path(options.store).write_bytes(pickle.dumps(found))
    print("| maps | pictures | wrong | |\n|---|---|---|---|")
    table(found, lambda picture, kind: [(picture.maps, kind[:9])])
    print("\n| pictures | curve or quality | wrong | |\n|---|---|---|---|")
    table(found, lambda picture, kind: [(kind, picture.curve), (kind, f"{picture.quality:3}")])


if __name__ == "__main__":
    main()
