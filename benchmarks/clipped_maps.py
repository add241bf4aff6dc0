"""Detection on 8-bit versions of HDR maps, compared with the lights of the HDR maps.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/clipped_maps.py [--width 1024] [--maps N]

Each HDR map below the folder becomes eleven 8-bit sRGB pictures. The truth is what detection finds
in the HDR map. A light is found where a light of the picture points within 3 degrees of it, or
within its radius where that is more, up to 20 degrees.

found: pictures in which the brightest HDR light is found. empty: pictures without a light, of maps
with one. flux: share of the HDR lights' flux that is found. angle: from the brightest HDR light to
the nearest light of the picture, the median over all pictures. false: lights of a picture that hold
no HDR light, by number and by their flux in the picture. time: processor time of `detect` on the
picture over that on the HDR map of the same size, as float32; the geometric mean over the maps, and
the largest. Only ratios of one run mean anything, with one thread: RAYON_NUM_THREADS=1.

Then generated pictures, by `synthetic`; and one JPEG from its file to its lights.
"""

import argparse
import io
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from time import process_time

import numpy as np
from detectors import sphere
from PIL import Image

sys.path.insert(0, str(Path(__file__).parents[1]))
from tests.helpers import paths_of_real_maps

import envlights as el
from envlights import synthetic
from envlights._common.srgb import encode_srgb
from envlights.kernels.image import LUMINANCE

#: HDR maps in the folder `ENVLIGHTS_MAPS`.
HDR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/Stage*LatLong.exr")

#: Times that each detection is timed; the least counts.
_LAPS = 7

#: What counts as found, in degrees.
LEAST_DEG, MOST_DEG = 3.0, 20.0


# Tone curves: from linear radiance to values that clip at 1.


def median_at(level):
    """Linear, with the median luminance at `level`."""
    return lambda radiance: radiance * (level / quantile(radiance, 0.5))


def clipped(share):
    """Linear, with this fraction of the sphere above the clip level."""
    return lambda radiance: radiance / quantile(radiance, 1 - share)


def expose(radiance, key=0.18):
    """The logarithmic mean of luminance at the middle grey of a photograph."""
    luminance = radiance @ LUMINANCE
    _, solid_angles = sphere(*luminance.shape)
    logarithm = np.log(luminance + 1e-6 * luminance.mean())
    return radiance * (key / np.exp(np.average(logarithm, weights=solid_angles)))


def reinhard(radiance):
    """Reinhard et al. (2002), equation 3."""
    scaled = expose(radiance)
    return scaled / (1 + scaled)


def aces(radiance):
    """The fit of Narkowicz (2016) to the film curve of the Academy."""
    x = expose(radiance)
    return x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)


def quantile(radiance, share):
    luminance = radiance @ LUMINANCE
    _, solid_angles = sphere(*luminance.shape)
    value = np.quantile(luminance, share, weights=solid_angles, method="inverted_cdf")
    return max(float(value), 1e-6 * float(luminance.mean()))


def eight_bits(linear):
    return np.round(255 * encode_srgb(linear)).astype(np.uint8)


def jpeg(linear):
    file = io.BytesIO()
    Image.fromarray(eight_bits(linear)).save(file, "JPEG", quality=90)
    return np.asarray(Image.open(file))


TONES = {
    "median 0.05": (median_at(0.05), eight_bits),
    "median 0.12": (median_at(0.12), eight_bits),
    "median 0.12, JPEG": (median_at(0.12), jpeg),
    "median 0.25": (median_at(0.25), eight_bits),
    "median 0.4": (median_at(0.4), eight_bits),
    "1 % clipped": (clipped(0.01), eight_bits),
    "5 % clipped": (clipped(0.05), eight_bits),
    "5 % clipped, JPEG": (clipped(0.05), jpeg),
    "Reinhard": (reinhard, eight_bits),
    "ACES": (aces, eight_bits),
    "ACES, JPEG": (aces, jpeg),
}


@dataclass(frozen=True)
class Score:
    """Agreement of the lights of one picture with those of its HDR map."""

    found: bool
    empty: bool
    flux: float
    angle_deg: float
    lights: int
    false: int
    flux_of_all: float
    flux_of_false: float
    time: float = np.nan


def score(truth, lights, time):
    """Compare the lights of a picture with those of the HDR map, brightest first."""
    flux, seen = truth.flux @ LUMINANCE, lights.flux @ LUMINANCE
    if not len(lights):
        return Score(False, True, 0.0, 180.0, 0, 0, 0.0, 0.0, time)
    chords = np.linalg.norm(truth.direction[:, None] - lights.direction[None], axis=2)
    angles = np.rad2deg(2 * np.arcsin(np.clip(chords / 2, 0, 1)))
    reach, held = tolerance(truth.angular_radius), np.rad2deg(lights.angular_radius)
    is_found = (angles <= reach[:, None]).any(axis=1)
    is_false = ~(angles <= np.maximum(reach[:, None], held[None])).any(axis=0)
    return Score(
        found=bool(is_found[0]),
        empty=False,
        flux=float(flux[is_found].sum() / flux.sum()),
        angle_deg=float(angles[0].min()),
        lights=len(lights),
        false=int(is_false.sum()),
        flux_of_all=float(seen.sum()),
        flux_of_false=float(seen[is_false].sum()),
        time=time,
    )


def tolerance(radius):
    return np.clip(np.rad2deg(radius), LEAST_DEG, MOST_DEG)


def reduce_width(radiance, width):
    """Mean of whole blocks, so that the map has about `width` columns."""
    block = max(radiance.shape[1] // width, 1)
    height, columns = (size // block for size in radiance.shape[:2])
    height, columns = min(height, columns // 2), 2 * min(height, columns // 2)
    blocks = radiance[: height * block, : columns * block].astype(np.float64)
    return blocks.reshape(height, block, columns, block, 3).mean(axis=(1, 3))


def twins(width, most=None):
    """For each map its name, the HDR map and its lights, and its pictures by tone."""
    for path in paths_of_real_maps(*HDR)[:most]:
        radiance = reduce_width(el.EnvMap.open(path).radiance, width)
        truth = el.detect(radiance)
        if len(truth):
            pictures = {tone: store(curve(radiance)) for tone, (curve, store) in TONES.items()}
            yield path.stem, radiance.astype(np.float32), truth, pictures


def seconds(detect, maps):
    """Least processor time of `detect` on each map; they take turns."""
    laps = np.empty((_LAPS, len(maps)))
    for lap in laps:
        for place, radiance in enumerate(maps):
            start = process_time()
            detect(radiance)
            lap[place] = process_time() - start
    return laps.min(axis=0)


def table(detect, worlds):
    """Lines of the table, by tone."""
    by_tone = {tone: [] for tone in TONES}
    for _, radiance, truth, pictures in worlds:
        of_map, *of_pictures = seconds(detect, [radiance, *pictures.values()])
        for (tone, picture), of_picture in zip(pictures.items(), of_pictures, strict=True):
            by_tone[tone].append(score(truth, detect(picture), of_picture / of_map))
    by_tone["all"] = [each for scores in list(by_tone.values()) for each in scores]
    heads = f"{'found':>7}{'empty':>7}{'flux':>7}{'angle':>8}{'false':>8}{'by flux':>9}"
    yield f"{'':<20}{heads}{'time':>7}{'worst':>7}"
    for tone, scores in by_tone.items():
        yield f"{tone:<20}{line(scores)}"


def line(scores):
    def mean(name):
        return np.mean([getattr(each, name) for each in scores])

    shares = [each.flux_of_false / each.flux_of_all for each in scores if each.lights]
    false = sum(each.false for each in scores) / max(sum(each.lights for each in scores), 1)
    angle = np.median([each.angle_deg for each in scores])
    times = [each.time for each in scores]
    return (
        f"{100 * mean('found'):>5.0f} %{sum(each.empty for each in scores):>7}{mean('flux'):>7.2f}"
        f"{angle:>7.2f}°{100 * false:>6.0f} %{100 * np.mean(shares or [0.0]):>7.0f} %"
        f"{np.exp(np.mean(np.log(times))):>7.2f}{max(times):>7.2f}"
    )


def families():
    """Lines on the generated maps as clipped 8-bit pictures."""
    for name in ("plain", "hard"):
        worlds = [getattr(synthetic, name)(seed) for seed in synthetic.EVALUATION]
        worlds = [world for world in worlds if "clipped" in world.note or "8 bit" in world.note]
        found = [el.detect(eight_bits(world.radiance)) for world in worlds]
        results = zip(worlds, found, strict=True)
        score = synthetic.evaluate([(world, e.direction, e.flux) for world, e in results])
        yield (
            f"{name}: {len(worlds)} maps, precision {score.precision:.2f}, recall"
            f" {score.recall:.2f}, {score.false_on_lightless} false on maps without lights"
        )


def from_file():
    """A line on a JPEG of 8192x4096 pixels: from file to lights, and the share of its decoding."""
    picture = eight_bits(synthetic.hard(3).radiance.repeat(8, axis=0).repeat(8, axis=1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "map.jpg"
        Image.fromarray(picture).save(path, quality=90)
        whole, decoded, found = (
            seconds(work, [path])[0]
            for work in (el.detect, el.io.read_image, lambda _: el.detect(picture))
        )
    height, width, _ = picture.shape
    return (
        f"{width}x{height} JPEG from file to lights: {1e3 * whole:.0f} ms of processor time,"
        f" {decoded / whole:.0%} to decode the file; detect on its array {1e3 * found:.0f} ms"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--width", type=int, default=1024, help="columns of the pictures, at most")
    parser.add_argument("--maps", type=int, help="number of maps; all of them if left out")
    options = parser.parse_args()
    for text in table(el.detect, twins(options.width, options.maps)):
        print(text)
    print("\ngenerated maps that are clipped at white")
    for text in families():
        print(text)
    print(f"\n{from_file()}")


if __name__ == "__main__":
    main()
