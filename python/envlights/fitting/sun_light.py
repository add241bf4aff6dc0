"""Fit of a rig that contains the sun as a light; all other lights are fitted to the remaining sky.

Rig and truth have the same sun, so the difference of their irradiance is that of the fit to the
sky. The errors against sky and sun are therefore those of the fit, times the ratio of the RMS
irradiance of the sky alone to that of sky and sun.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, flag
from envlights._native import EnvLightsError
from envlights.environment.envmap import EnvMap
from envlights.environment.fill import Fill
from envlights.export.targets import shown_by, target_names
from envlights.fitting.map_fit import fit_map
from envlights.fitting.reduction import above_horizon, fill_for_fit
from envlights.fitting.request import FitArguments, Request, request_for
from envlights.kernels import gloss
from envlights.kernels.sphere import pixel_directions, pixel_solid_angles
from envlights.rigs.lights import Lights, brightest_first
from envlights.rigs.report import FitReport
from envlights.rigs.rig import Rig, error_of
from envlights.sun.sun_split import SunSplit

#: Columns of the sky for ratios of RMS irradiance. Without the sun, 64 columns are accurate to 0.1
#: %.
_COLUMNS = 64

_NOTE = (
    "the sun is fixed in direction, size and irradiance; the other lights and the ambient term are"
    " fitted to the sky without it, and errors are against sky and sun"
)


class Ratios(NamedTuple):
    """Ratios of the RMS irradiance of the sky to that of sky and sun."""

    probe: float
    """Ratio for a white probe."""

    channels: tuple[float, ...]
    """Ratio for a probe in red, green and blue."""

    shadows: float
    """Ratio with the light behind a plane blocked, averaged over all planes."""


class SkyPixels(NamedTuple):
    """Pixels of the sky as light sources."""

    flux: NDArray[np.float64]
    """Radiance times solid angle, (n, 3)."""

    towards: NDArray[np.float64]
    """Unit vectors to the pixels, (n, 3)."""


def fit_with_sun(parts: SunSplit, arguments: FitArguments) -> Rig:
    """Rig of the sun and of a fit to the remaining sky; without a sun, a fit to the map."""
    if not len(parts.lights):
        return fit_map(parts.remainder, arguments)
    shows = shown_by(target_names(arguments.target))
    request = request_for(arguments)
    sky = pixels_of(_sky(parts.remainder, arguments.floor, arguments.fill))
    ratios = ratios_of(sky, parts.lights)
    of_sky = replace(
        arguments,
        lights=_lights_of_sky(request, arguments.lights, shows.lights),
        error=_of_sky(arguments.error, ratios.probe),
        shadow_error=_of_sky(arguments.shadow_error, ratios.shadows),
        gloss_error=_gloss_of_sky(parts, arguments, sky, request.roughness),
    )
    rig, sun = fit_map(parts.remainder, of_sky), parts.lights
    if not arguments.sizes or shows.sizes != "spread":
        sun = replace(sun, angular_radius=np.zeros(len(sun)))
    return _with_sun(rig, sun, ratios, sky)


def _gloss_of_sky(
    parts: SunSplit, arguments: FitArguments, sky: SkyPixels, roughness: float
) -> float | None:
    """Gloss error to accept in the fit of the sky, from energies of a fit without lights."""
    if arguments.gloss_error is None:
        return None
    alone = replace(
        arguments,
        lights=0,
        error=None,
        shadow_error=None,
        gloss_error=None,
        start="greedy",
        fixed=None,
    )
    (energies, _) = fit_map(parts.remainder, alone).report.gloss_bands
    factors = gloss.factors(roughness, "metal", len(energies) - 1)
    both = bands_with_sun(np.array(energies), sky, parts.lights)
    ratio = math.sqrt(float(factors @ energies) / float(factors @ both))
    return _of_sky(arguments.gloss_error, ratio)


def _sky(remainder: EnvMap, floor: bool, fill: Fill) -> EnvMap:
    """Filled sky for a fit; over a floor, only its upper hemisphere."""
    filled = fill_for_fit(remainder, flag("floor", floor), fill).env
    return above_horizon(filled) if floor else filled


def pixels_of(sky: EnvMap) -> SkyPixels:
    """Pixels of the sky, reduced to 64 columns."""
    small = sky.resized(_COLUMNS) if sky.width > _COLUMNS else sky
    size = {"border_sampled": small.is_border_sampled}
    angles = pixel_solid_angles(small.height, small.width, **size)
    flux = (small.radiance * angles[..., None]).reshape(-1, 3).astype(np.float64)
    return SkyPixels(flux, pixel_directions(small.height, small.width, **size).reshape(-1, 3))


def ratios_of(sky: SkyPixels, sun: Lights) -> Ratios:
    """Ratios of RMS irradiance of the sky to sky and sun, from the closed form for two sources.

    Integrated over all normals, the product of the irradiance of two directions at the angle g is
    G = 2/3 (sin g + (pi - g) cos g) (Cho and Saul 2009); with shadows it is G (1 - g / pi) / 2.
    """
    to_sun, between = _angles(sky.towards, sun.direction), _angles(sky.towards, sky.towards)
    probe, shadows = (_energies(to_sun, between, sky.flux, sun, shadow) for shadow in (False, True))
    channels = np.sqrt(probe[0] / np.where(probe[1] > 0, probe[1], 1))
    of_probe, of_shadows = (float(np.sqrt(e[0].sum() / e[1].sum())) for e in (probe, shadows))
    return Ratios(of_probe, tuple(channels.tolist()), of_shadows)


def bands_with_sun(
    energies: NDArray[np.float64], sky: SkyPixels, sun: Lights
) -> NDArray[np.float64]:
    """Energy per degree of sky and sun, from that of the sky, summed over channels.

    By the addition theorem a point of flux E in the direction w adds (2 l + 1) / (4 pi) times
    E (2 s_l + E) to the degree l, where s_l is the integral of the sky times P_l of the angle to w.
    """
    (strength,), degrees = sun.irradiance, np.arange(len(energies))
    cosines = sky.towards @ sun.direction[0]
    sums = np.polynomial.legendre.legvander(cosines, len(energies) - 1).T @ sky.flux
    return np.asarray(
        energies + (2 * degrees + 1) / (4 * np.pi) * ((2 * sums + strength) @ strength)
    )


def _angles(one: NDArray[np.float64], other: NDArray[np.float64]) -> NDArray[np.float64]:
    """Angles between the rows of two arrays of unit vectors."""
    return np.asarray(np.arccos(np.clip(one @ other.T, -1, 1)))


def _energies(
    to_sun: NDArray[np.float64],
    between: NDArray[np.float64],
    flux: NDArray[np.float64],
    sun: Lights,
    shadow: bool,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Squared irradiance by channel over all normals: of the sky, and of sky and sun."""
    (strength,) = sun.irradiance
    alone = (flux * (_kernel(between, shadow) @ flux)).sum(axis=0)
    both = 2 * strength * (_kernel(to_sun, shadow)[:, 0] @ flux)
    of_sun = strength**2 * _kernel(np.zeros(1), shadow)[0]
    return alone, alone + both + of_sun


def _kernel(angle: NDArray[np.float64], shadow: bool) -> NDArray[np.float64]:
    product = 2 / 3 * (np.sin(angle) + (np.pi - angle) * np.cos(angle))
    return product * (1 - angle / np.pi) / 2 if shadow else product


def _lights_of_sky(request: Request, lights: int | None, most_lights: int | None) -> int:
    """Largest number of lights besides the sun."""
    if lights is not None:
        if count("lights", lights) < 1:
            raise EnvLightsError("lights must be at least 1 with a sun, which is one; got 0")
        return lights - 1
    placed = len(request.fixed) + len(request.start_directions)
    most = request.lights + bool(placed)
    return (most if most_lights is None else min(most, most_lights)) - 1


def _of_sky(error: float | None, ratio: float) -> float | None:
    return None if error is None else min(error / (ratio or 1.0), 1.0)


def _with_sun(rig: Rig, sun: Lights, ratios: Ratios, pixels: SkyPixels) -> Rig:
    sky = rig.lights
    irradiance = np.concatenate([sky.irradiance, sun.irradiance])
    order = brightest_first(irradiance)
    lights = Lights(
        np.concatenate([sky.direction, sun.direction]),
        irradiance,
        np.concatenate([sky.angular_radius, sun.angular_radius]),
        units=sun.units,
        notes=sun.notes,
    )
    # The lights mention the sun already.
    own = tuple(note for note in rig.notes if not note.endswith(sun.notes[0]))
    report = _report(rig.report, order, ratios)
    energies, difference = rig.report.gloss_bands
    both = bands_with_sun(np.array(energies), pixels, sun)
    report = replace(report, gloss_bands=(tuple(both.tolist()), difference))
    error = ratios.probe * error_of(rig)
    return replace(rig, lights=lights, error=error, report=report, notes=(*own, _NOTE))


def _report(report: FitReport, order: NDArray[np.intp], ratios: Ratios) -> FitReport:
    """Report for sky and sun; the sun is the last row before reordering by `order`."""

    def times(error: float | None, ratio: float = ratios.probe) -> float | None:
        return None if error is None else ratio * error

    scale, row = ratios.probe, order.argsort()
    tolerances = (*report.direction_tolerances, 0.0)
    has_tolerances = len(tolerances) == len(order)
    return replace(
        report,
        search_errors={n + 1: scale * error for n, error in report.search_errors.items()},
        sized_error=times(report.sized_error),
        ambients={name: (n + 1, scale * error) for name, (n, error) in report.ambients.items()},
        channel_errors=tuple(np.multiply(report.channel_errors, ratios.channels).tolist()),
        max_error=scale * report.max_error,
        shadow_error=times(report.shadow_error, ratios.shadows),
        objective_error=None,
        points_error=times(report.points_error),
        fitted_points_error=times(report.fitted_points_error),
        direction_tolerances=tuple(tolerances[j] for j in order) if has_tolerances else (),
        fixed=tuple(int(row[j]) for j in (*report.fixed, len(order) - 1)),
        fewer_lights=f"beside the sun, {report.fewer_lights}" if report.fewer_lights else "",
        measured_on=f"{report.measured_on} under the sky, relative to sky and sun",
    )
