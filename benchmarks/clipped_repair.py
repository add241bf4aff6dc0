"""Probe under 8-bit twins of real HDR maps, with and without a repair of the clipped light.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/clipped_repair.py [--width 1024] [--maps N]

The pictures are those of `clipped_maps.py`. Errors are relative RMS errors of the irradiance of a
white probe against that of the HDR map, at the best common scale: median and 90 % quantile.

as it is: the picture. repaired: `EnvMap.repaired`. irradiance: with that of an upward surface under
the HDR map, for linear tones, which have a scale. worse: pictures whose error the repair raises by
more than 0.05; they are named below. factor: true flux over the estimated one, for linear tones, by
its quantiles 1/6 and 5/6, where anything was added.
"""

import argparse
from dataclasses import dataclass

import numpy as np
from clipped_maps import HDR, TONES, reduce_width
from tests.helpers import NORMALS, SOLID_ANGLES, flux, paths_of_real_maps

import envlights as el
from envlights.kernels.image import LUMINANCE

#: Tones that keep ratios of luminance below white.
LINEAR = [tone for tone in TONES if not tone.startswith(("Reinhard", "ACES"))]

#: An error that rises by more than this is worse.
WORSE = 0.05


@dataclass(frozen=True)
class Outcome:
    """One picture of one map, before and after."""

    name: str
    tone: str
    as_it_is: float
    repaired: float
    with_irradiance: float
    flux_ratio: float
    """True flux over that of the repaired map; NaN where nothing was added."""
    note: str

    @property
    def is_worse(self):
        """True if the repair increases the error."""
        return self.repaired > self.as_it_is + WORSE


def error(probe, truth):
    """Relative RMS error at the best common scale."""
    weight = SOLID_ANGLES[:, None]
    scale = (weight * probe * truth).sum() / (weight * probe**2).sum()
    return float(np.sqrt((weight * (scale * probe - truth) ** 2).sum() / (weight * truth**2).sum()))


def outcomes(width, most=None):
    """All pictures of all maps."""
    for path in paths_of_real_maps(*HDR)[:most]:
        radiance = reduce_width(el.EnvMap.open(path).radiance, width)
        for tone, (curve, store) in TONES.items():
            yield outcome(path.stem, tone, radiance, curve(radiance), store)


def outcome(name, tone, radiance, exposed, store):
    # Linear tones only scale the map; others have no scale.
    original, picture = el.EnvMap(exposed), el.EnvMap(store(exposed))
    truth = el.EnvMap(radiance).probe(NORMALS)
    repaired = picture.repaired()
    is_linear, has_more = tone in LINEAR, not np.array_equal(repaired.radiance, picture.radiance)
    ratio = np.divide(*(flux(env.radiance) @ LUMINANCE for env in (original, repaired)))
    return Outcome(
        name,
        tone,
        error(picture.probe(NORMALS), truth),
        error(repaired.probe(NORMALS), truth),
        error(lit_as(original, picture).probe(NORMALS), truth) if is_linear else np.nan,
        float(ratio) if is_linear and has_more else np.nan,
        repaired.notes[-1],
    )


def lit_as(original, picture):
    """The picture with the irradiance of the original, where that is more."""
    upward = float(original.probe([[0, 1, 0]])[0] @ LUMINANCE)
    try:
        return picture.repaired(irradiance=upward)
    except el.EnvLightsError:
        return picture


def table(found):
    """Lines of the table, by tone, and the pictures that become worse."""
    yield f"{'':<20}{'as it is':>13}{'repaired':>13}{'irradiance':>13}{'worse':>8}{'factor':>13}"
    for tone in [*TONES, "all"]:
        yield f"{tone:<20}{line([each for each in found if tone in (each.tone, 'all')])}"
    for each in found:
        if each.is_worse:
            yield f"worse: {each.name}, {each.tone}: {each.as_it_is:.2f} to {each.repaired:.2f}"


def line(found):
    def quantiles(name, *at):
        values = np.array([getattr(each, name) for each in found])
        values = values[~np.isnan(values)]
        return "/".join(f"{value:.2f}" for value in np.quantile(values, at)) if len(values) else "-"

    errors = [quantiles(name, 0.5, 0.9) for name in ("as_it_is", "repaired", "with_irradiance")]
    worse = 100 * np.mean([each.is_worse for each in found])
    factor = quantiles("flux_ratio", 1 / 6, 5 / 6)
    return "".join(f"{each:>13}" for each in errors) + f"{worse:>6.0f} %{factor:>13}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--width", type=int, default=1024, help="columns of the pictures, at most")
    parser.add_argument("--maps", type=int, help="number of maps; all of them if left out")
    options = parser.parse_args()
    for text in table(list(outcomes(options.width, options.maps))):
        print(text)


if __name__ == "__main__":
    main()
