"""Sun of 8-bit pictures, against HDR maps with a sun, maps without one, and made skies.

Usage: python benchmarks/sun.py MAP... [--sunny NAME,...] [--doubt NAME,...] [--no-made] [--fast]

Each map becomes seven 8-bit pictures of 1024 columns (`sun_pictures.py`); Mitsuba makes eight clear
skies, again in seven tones. Sunny maps are those of `--sunny`, by file name without suffix; those
of `--doubt` count only in the last line on the printed intervals.

direction: error in degrees of all answers with a direction, by radius of the clipped part and by
tone. within: errors below 1.1 and 2 times the reported uncertainty. answers: precision and recall
of "sun" over pictures, and made skies that are "sun" with an error above 3 uncertainties. flux:
stops between the estimate and the HDR map, with the constant set on the other maps, and pictures
within the interval, set in the same way. probe, shadow: relative RMS error of a white probe and of
the floor around a ball, at the best common scale: the picture, `repaired`, and sky with disc,
median / 90 %. time: `find_sun` over `repaired`, the median.
"""

import argparse
import sys
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))
import sun_pictures
from sun_light import light_errors
from tests.helpers import angle_deg

import envlights as el
from envlights.kernels.image import LUMINANCE
from envlights.sun.brightness import FACTOR

#: Names of maps with a sun that this benchmark was read with; others by `--sunny`.
SUNNY = (
    *("blender_city", "blender_sunrise", "chinese_garden_1k", "hilly_terrain_01_1k"),
    *("kloppenheim_05_1k", "modern_buildings_2_1k", "narrow_moonlit_road_1k", "noon_grass_1k"),
    *("rooitou_park_1k", "san_giuseppe_bridge_2k", "pm_sky"),
)
#: A sun behind a veil, a cloud, leaves, or on the horizon; the last two have a damaged sun.
DOUBT = (
    *("immenstadter_horn_1k", "venice_sunset_1k", "aristea_wreck_puresky_1k", "blender_forest"),
    *("blender_sunset", "pmndrs_park_512", "pm_sunrise"),
)


@dataclass
class Row:
    """One picture and its answer."""

    kind: str
    name: str
    tone: tuple
    sun: el.sun.Sun
    error: float = np.nan
    """Degrees between the answer and the sun of the map."""
    stops: float = np.nan
    """Logarithm to base 2 of the true irradiance over the estimate."""
    lit: dict = field(default_factory=dict)
    """Errors of probe and shadow by name."""
    slower: float = np.nan

    @property
    def sigmas(self):
        """Error over the uncertainty."""
        uncertainty = np.degrees(self.sun.direction_uncertainty)
        return self.error / max(uncertainty, 1e-9)


def rows_of(kind, name, radiance, truth, fast):
    for tone in sun_pictures.TONES:
        picture = sun_pictures.picture(radiance, tone)
        env = el.EnvMap(picture.codes)
        start = perf_counter()
        sun = el.find_sun(env)
        middle = perf_counter()
        row = Row(kind, name, tone, sun)
        if kind in ("sunny", "made"):
            repaired = env.repaired()
            row.slower = (middle - start) / (perf_counter() - middle)
        if truth is not None and sun.direction is not None:
            row.error = float(angle_deg(sun.direction, truth.direction))
            row.stops = stops(env, sun, picture, truth)
            if not fast:
                row.lit = light_errors(env, repaired, sun, radiance)
        yield row


def stops(env, sun, picture, truth):
    """Logarithm to base 2 of the true irradiance over the estimate.

    A film curve has no scale, so both are divided by the horizontal irradiance of their sky there.
    """
    estimate = float(sun.irradiance @ LUMINANCE)
    if picture.is_film:
        sky = float(env.probe([[0.0, 1.0, 0.0]])[0] @ LUMINANCE)
        return float(np.log2(truth.flux / truth.sky / (estimate / sky)))
    return float(np.log2(truth.flux * picture.scale / estimate))


def quantiles(values, at=(0.5, 0.9)):
    values = np.array([value for value in values if np.isfinite(value)])
    if not len(values):
        return "-"
    return " / ".join(f"{value:.2f}" for value in np.quantile(values, at))


def share(flags):
    flags = list(flags)
    return f"{np.mean(flags):.2f} of {len(flags)}" if flags else "-"


def directions(title, rows):
    """Lines on the errors of direction."""
    rows = [row for row in rows if np.isfinite(row.error)]
    if not rows:
        return
    yield f"{title}: {len(rows)} pictures with a direction"
    radii = np.array([np.degrees(row.sun.plateau_radius) for row in rows])
    for name, low, high in (("< 4", 0, 4), ("4 to 15", 4, 15), ("> 15", 15, 180), ("all", 0, 180)):
        some = [row for row, at in zip(rows, radii, strict=True) if low <= at < high]
        yield (
            f"  part {name:>8}  n {len(some):3}  error {quantiles(row.error for row in some)}  "
            f"within 1.1: {share(row.sigmas < 1.1 for row in some)}, "
            f"2: {share(row.sigmas < 2 for row in some)}"
        )
    for tone in sun_pictures.TONES:
        yield f"  {tone!s:<20} error {quantiles(r.error for r in rows if r.tone == tone)}"


def answers(rows, made):
    """Lines on answers."""
    scored = [row for row in rows if row.kind in ("sunny", "none")]
    said = [row for row in scored if row.sun.answer == "sun"]
    sunny = [row for row in scored if row.kind == "sunny"]
    yield f"precision {share(row.kind == 'sunny' for row in said)}"
    yield f"recall {share(row.sun.answer == 'sun' for row in sunny)}"
    yield f"suns answered no: {share(row.sun.answer == 'no' for row in sunny)}"
    wrong = [row for row in made if row.sun.answer == "sun" and row.sigmas > 3]
    yield f"made skies answered sun: {share(row.sun.answer == 'sun' for row in made)}"
    yield f"made skies answered sun with an error above 3 uncertainties: {len(wrong)}"
    for row in [*wrong, *(row for row in said if row.kind == "none")]:
        yield f"  wrong: {row.name} {row.tone} error {row.error:.1f} {row.sun!r}"


def flux(rows):
    """Lines on the irradiance, with the constant and the interval set on the other maps."""
    rows = [row for row in rows if np.isfinite(row.stops)]
    if not rows:
        return
    names = sorted({row.name for row in rows})
    left_out, within, within_wide = [], [], []
    for name in names:
        others = np.array([row.stops for row in rows if row.name != name])
        shift = np.median(others)
        low, high = np.quantile(others - shift, (1 / 6, 5 / 6))
        lowest, highest = np.quantile(others - shift, (0.05, 0.95))
        own = np.array([row.stops for row in rows if row.name == name]) - shift
        left_out += list(np.abs(own))
        within += list((own >= low) & (own <= high))
        within_wide += list((own >= lowest) & (own <= highest))
        yield f"  {name:<28} stops {quantiles(own, (0, 0.5, 1))}"
    stops = np.array([row.stops for row in rows])
    yield f"constant on all maps {FACTOR * 2 ** np.median(stops):.2f}, used {FACTOR}"
    yield f"error in stops, constant from the other maps: {quantiles(left_out)}"
    yield f"interval from the other maps holds: two of three {share(within)}"
    yield f"interval from the other maps holds: nine of ten {share(within_wide)}"
    factors = 2 ** np.quantile(stops, (1 / 6, 5 / 6, 0.05, 0.95))
    yield f"factors of all maps: {' '.join(f'{value:.2f}' for value in factors)}"


def intervals(title, rows):
    """A line on the intervals of the answers themselves."""
    rows = [row for row in rows if np.isfinite(row.stops)]
    holds = [row.sun.interval[0] <= 2**row.stops <= row.sun.interval[1] for row in rows]
    twice = share(abs(row.stops) <= 1 for row in rows)
    yield f"{title}: printed interval holds {share(holds)}, within a factor of 2 {twice}"


def light(rows):
    """Lines on probe and shadow, at the best common scale."""
    rows = [row for row in rows if row.lit]
    for what in ("probe", "shadow"):
        parts = [
            f"{name} {quantiles(row.lit[what, name] for row in rows)}"
            for name in ("raw", "repaired", "disc")
        ]
        worse = share(row.lit[what, "disc"] > row.lit[what, "repaired"] + 0.05 for row in rows)
        yield f"{what}: {'   '.join(parts)}   worse than repaired by 0.05: {worse}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("maps", nargs="*", type=Path)
    parser.add_argument("--sunny", type=lambda text: tuple(text.split(",")), default=SUNNY)
    parser.add_argument("--doubt", type=lambda text: tuple(text.split(",")), default=DOUBT)
    parser.add_argument("--no-made", action="store_true", help="without the skies of Mitsuba")
    parser.add_argument("--fast", action="store_true", help="without probe and shadow")
    options = parser.parse_args()
    rows = []
    for path in options.maps:
        name = path.stem
        kind = "sunny" if name in options.sunny else "doubt" if name in options.doubt else "none"
        radiance = sun_pictures.read(path)
        truth = None if kind == "none" else sun_pictures.truth_of(radiance)
        rows += rows_of(kind, name, radiance, truth, options.fast)
    made = []
    for turbidity, elevation in () if options.no_made else sun_pictures.SKIES:
        radiance, truth = sun_pictures.made_sky(turbidity, elevation)
        made += rows_of("made", f"made {turbidity} {elevation}", radiance, truth, options.fast)
    sunny = [row for row in rows if row.kind == "sunny"]
    lines = [*directions("sunny maps", sunny)]
    lines += directions('sunny maps, "sun"', [row for row in sunny if row.sun.answer == "sun"])
    lines += [*directions("made skies", made), *answers(rows, made), *flux(sunny), *light(sunny)]
    lines += intervals("sunny maps", sunny)
    lines += intervals("maps in doubt", [row for row in rows if row.kind == "doubt"])
    lines += [f"time over repaired: {quantiles(row.slower for row in rows + made)}"]
    print("\n".join(lines))


if __name__ == "__main__":
    main()
