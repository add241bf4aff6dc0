"""Split of a map into its lights and the remaining map."""

from __future__ import annotations

from dataclasses import fields, replace
from time import perf_counter
from typing import Any, Literal, NamedTuple, overload

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._common.check import amount, count, describe, flag, named_arguments
from envlights._common.former import former_attributes
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.cards.card_split import CardSplit
from envlights.cards.cut import cut
from envlights.detection.detect import detect, detect_with_luminance
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.environment.envmap import EnvMap
from envlights.environment.reading import AnyMap, as_envmap
from envlights.export.links import LinkedParts
from envlights.kernels.image import LUMINANCE
from envlights.rigs.lights import Lights
from envlights.splitting.relight import RemovedRadiance, relight
from envlights.splitting.removed_lights import RemovedLights

#: Options of `detect` for splitting. Without the removed lights the threshold would be lower (by
#: less than a tenth for most maps), so weak lights would be detected in the remainder. Remove them
#: too.
_OPTIONS: dict[str, Any] = {"rise": 2.25, "min_worth": 0.0}

#: Largest relative difference between a light's peak and the map, due to rounding in files.
_PEAK_TOLERANCE = 1e-3
#: Smallest number of columns of a map for cards: a single pixel of 16 columns as a card missed 6 %
#: of the irradiance, of 4 columns 58 %.
_LEAST_COLUMNS = 32
_TOO_SMALL = (
    f"a map of less than {_LEAST_COLUMNS} columns has no cards, because a light is one pixel"
    " without an outline there; its lights stay in the map; without shapes they are discs"
)


class LightPixels(NamedTuple):
    """Pixels of lights in the map averaged over square blocks, as input of the kernel."""

    pixel: NDArray[np.int64]
    """Row and column of each pixel, shape (k, 2)."""

    light_of_pixel: NDArray[np.int64]
    """Index of the light of each pixel; an index without a direction means that the light stays."""

    direction: NDArray[np.float64]
    """Unit vectors to the lights to remove, shape (n, 3)."""

    block: int
    """Block size in pixels of the map."""

    threshold: float
    """Luminance above which a pixel is bright."""

    luminance: NDArray[np.float32]
    """Mean luminance of each block, in row order."""


class _SplitFields(NamedTuple):
    """Fields of a `Split`."""

    lights: RemovedLights
    """Lights that were removed, brightest first."""

    remainder: EnvMap
    """Map without the lights, of the same size, never negative."""


@former_attributes(rest="remainder")
class Split(_SplitFields, LinkedParts):
    """Lights, and the map without them."""

    _removed: RemovedRadiance | None = None

    def __str__(self) -> str:
        return f"{self.lights}\n\nthe map without these lights: {self.remainder}"

    def with_lights(self, lights: Lights) -> EnvMap:
        """Draw changed lights into the map: moved, dimmed, coloured, removed or added.

        Parameters
        ----------
        lights : Lights
            Lights of this split after `Lights.moved`, `dimmed`, `coloured`, `resized`, `without`
            or `with_light`, or a choice of them.

        Returns
        -------
        EnvMap
            Map of the same size. A light of its old size is drawn with its own pixels, turned along
            its meridian and about the pole, so that it stays upright; another one as a disc of
            uniform radiance, a point as in `Lights.to_map`. A surface that faces all of a light
            receives its irradiance. Unchanged lights give back the map. Where a light was, the fill
            of the split remains.

        Raises
        ------
        EnvLightsError
            If a light comes from another split; if one is moved, resized or added in a map that is
            border-sampled or shows a part of the sphere; or this split was not made by `split`.

        Examples
        --------
        >>> import envlights as el
        >>> env = el.EnvMap(el.synthetic.plain(0, 128).radiance)
        >>> parts = el.split(env, 1)
        >>> np.allclose(parts.with_lights(parts.lights).radiance, env.radiance, rtol=1e-6)
        True
        >>> lower = parts.with_lights(parts.lights.moved(0, elevation=0.2).dimmed(0, 0.5))
        >>> np.allclose(el.split(lower, 1).lights.elevation, 0.2, atol=0.01)
        True
        """
        if self._removed is None:
            raise EnvLightsError("only a split by `el.split` can have other lights")
        return relight(self.remainder, self._removed, self.lights, lights)


@overload
def split(
    env: AnyMap,
    lights: int | DetectedLights | None = None,
    *,
    fraction: float | None = None,
    shapes: Literal[False] = False,
    **options: Any,
) -> Split: ...


@overload
def split(
    env: AnyMap,
    lights: int | DetectedLights | None = None,
    *,
    fraction: float | None = None,
    shapes: Literal[True],
    **options: Any,
) -> CardSplit: ...


@named_arguments(detect)
def split(
    env: AnyMap,
    lights: int | DetectedLights | None = None,
    *,
    fraction: float | None = None,
    shapes: bool = False,
    **options: Any,
) -> Split | CardSplit:
    r"""Split a map into lights and the remaining map, for example a sun and the sky without it.

    Each light is removed with its rim and its glare. Its pixels are filled smoothly from around
    it, by Laplace's equation on the sphere; a pixel that is darker than the fill stays. In every
    pixel, the map is the remainder plus the removed radiance. A surface that faces the whole light
    receives the same luminance from the light as from the removed pixels, up to rounding. One
    channel may differ by `RemovedLights.off_axis` of the light.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    lights : int or DetectedLights, optional
        Largest number of lights to remove, the brightest first: 1 for the sun. Or lights of
        `detect` for this map, such as ``detected[[0, 2]]``. By default, all lights.
    fraction : float, optional
        Remove the fewest lights, the brightest first, that have this fraction of the flux of all
        lights.
    shapes : bool
        True: the lights leave the map as `Cards` (rectangles, tubes, discs) with textures. What
        lies beside the cards, such as the glow on a wall, stays in the map. Panes of one window
        become one card.
    **options
        Options of `detect`. Here `rise` is 2.25 and `min_worth` is 0 by default, so that
        weak lights do not stay in the remainder.

    Returns
    -------
    lights : RemovedLights
        The removed lights, with their irradiance at normal incidence; `Cards` if `shapes` is True.
    remainder : EnvMap
        A map like any other; its `notes` name the removed lights.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, an option is out of its range, or `lights` are from another
        method or another map.

    See Also
    --------
    detect : the lights of a map.

    Notes
    -----
    At normal n the removed radiance T gives :math:`n \cdot V` in each channel, with
    :math:`V = \int T \omega\, d\omega`, and the light gives :math:`E\, n \cdot d`. The direction
    d is that of the luminance of V. For suns, one channel differs by 0.01 to 11 %, because of haze
    and because a lens refracts red and blue differently. Windows that are blue above and green
    below differ more. If the horizon of a surface cuts a light, the shape of the light matters,
    which is not exactly a disc.

    The glare around a light is removed in rings. Rings are added while their median luminance falls
    by a factor of 1.1 to 1.25 over two rings, up to 15 degrees from the light. Glare falls like
    this, a sky does not. Bright surroundings that are connected to the light, up to 45 degrees
    away, are dimmed: the clouds around a sun, or the dim part of a softbox. A luminance of y
    thresholds, with y above 1.5, becomes 2 - 1/4 / (y - 1) thresholds.

    Of a map that shows a part of the sphere (`EnvMap.coverage`), only what is seen is removed and
    counted, and nothing is filled from unseen pixels. They stay black in the remainder.

    The irradiance of a clipped light is a lower bound, because the map has lost the radiance above
    its clip level.

    References
    ----------
    Cascadic multigrid for the fill: F. A. Bornemann, P. Deuflhard: "The cascadic multigrid method
    for elliptic problems", Numerische Mathematik 75, 1996.

    Examples
    --------
    >>> import envlights as el
    >>> sun = el.synthetic.Disc((1, 1, 0), 1.0, (900, 800, 700))
    >>> env = el.EnvMap(el.synthetic.scene(256, background=[0.2, 0.3, 0.4], shapes=[sun]).radiance)
    >>> lights, rest = el.split(env)
    >>> len(lights), rest.radiance.max(axis=(0, 1))
    (1, array([0.2, 0.3, 0.4], dtype=float32))

    The lights and the remainder as a rig, the remainder as harmonics:

    >>> sky = el.fit(rest, lights=0, ambient="sh2")
    >>> rig = el.Rig(sky.ambient, lights.discs(), error=0.0)
    >>> np.allclose(rig.probe([[0, 1, 0]]), env.probe([[0, 1, 0]]), rtol=1e-4)
    True
    """
    flag("shapes", shapes)
    env = as_envmap(env)
    found, chosen, luminance = _choose(env, lights, fraction, options)
    if shapes and len(chosen) and env.width < _LEAST_COLUMNS:
        chosen, env = chosen[:0], env.with_radiance(env.radiance, (*env.notes, _TOO_SMALL))
    start = perf_counter()
    pixels = _light_pixels(env, chosen, luminance)
    if chosen is lights:
        _check_peaks(chosen, pixels)
    parts = _native.split_map(env.radiance, env.is_border_sampled, pixels, env.coverage)
    removed = _removed_lights(chosen, parts, _report(chosen, len(found), perf_counter() - start))
    if shapes:
        return _cards_and_rest(env, removed, parts.remainder, pixels)
    notes = (*env.notes, *_notes(removed))
    result = Split(removed, env.with_radiance(parts.remainder, notes))
    blocks = parts.light_of_block.reshape(found.report.working_size)
    result._removed = RemovedRadiance(env, blocks, pixels.block)
    return result


def _cards_and_rest(
    env: EnvMap, removed: RemovedLights, remainder: NDArray[np.float32], pixels: LightPixels
) -> CardSplit:
    """Cards for removed lights, and the map with everything outside of the cards."""
    blocks = pixels.pixel, pixels.light_of_pixel
    cards, around = cut(
        env, remainder, blocks, pixels.block, (removed.direction, removed.angular_radius)
    )
    remark = [f"{cards.in_short()} removed from the map"] if len(cards) else []
    return CardSplit(cards, env.with_radiance(around, (*env.notes, *remark)))


def _choose(
    env: EnvMap,
    lights: int | DetectedLights | None,
    fraction: float | None,
    options: dict[str, Any],
) -> tuple[DetectedLights, DetectedLights, NDArray[np.float32]]:
    """All lights of the map, the lights to remove, and the luminance of the reduced map."""
    if isinstance(lights, DetectedLights):
        given = [*options, *(["fraction"] if fraction is not None else [])]
        if given:
            raise EnvLightsError(
                f"{given[0]} has no effect on lights that are already detected; give only one"
            )
        _check_origin(env, lights.report)
        width = lights.report.working_size[1]
        image = _native.reduced_luminance(env.radiance, width, env.is_border_sampled)
        return lights, lights, image.ravel()
    most = None if lights is None else _count(lights)
    part = None if fraction is None else amount("fraction", fraction, most=1.0)
    found, luminance = detect_with_luminance(env, **_OPTIONS | options)
    if part is not None:
        together = np.cumsum(found.flux_fraction)
        enough = int(np.searchsorted(together, part * (1 - 1e-12) * found.flux_fraction.sum())) + 1
        most = min(enough if part else 0, len(found) if most is None else most)
    return found, found if most is None else found[:most], luminance


def _count(lights: object) -> int:
    if isinstance(lights, bool) or not isinstance(lights, int | np.integer):
        raise EnvLightsError(
            "lights must be a number, or lights from `detect`, such as detected[[0, 2]]; got"
            f" {describe(lights)}"
        )
    return count("lights", int(lights))


def _check_origin(env: EnvMap, report: DetectionReport) -> None:
    """Raise an error for lights of another method, or of a map of another size."""
    if report.method != "tree":
        raise EnvLightsError(
            f'split needs lights of `detect`; got those of method "{report.method}"'
        )
    height, width = report.working_size
    block = -(-env.width // width)
    if (height, width) != (-(-env.height // block), -(-env.width // block)):
        raise EnvLightsError(
            f"the lights must be those of this map of {env.width}x{env.height} pixels; they are"
            f" from a map that was reduced to {width}x{height}"
        )


def _check_peaks(lights: DetectedLights, pixels: LightPixels) -> None:
    """Raise an error for lights whose peak differs from the map at their pixels.

    A peak is one pixel of the map, which has at least 1 / block^3 of the weight in its block.
    """
    image = pixels.luminance.reshape(lights.report.working_size)
    largest = np.zeros(len(lights))
    rows, columns = lights.members.pixel.T
    np.maximum.at(largest, lights.members.light, image[rows, columns])
    least, most = 1 - _PEAK_TOLERANCE, 1 + _PEAK_TOLERANCE
    peak = lights.peak_luminance
    is_other = (largest > most * peak) | (largest < least * peak / pixels.block**3)
    for light in np.flatnonzero(is_other)[:1]:
        raise EnvLightsError(
            f"the lights must be those of this map: light {light} has a peak luminance of"
            f" {peak[light]:.4g}, but its brightest pixel here has {largest[light]:.4g}"
        )


def _light_pixels(
    env: EnvMap, lights: DetectedLights, luminance: NDArray[np.float32]
) -> LightPixels:
    """Pixels of all lights; lights that stay get an index beyond those to remove."""
    members, report = lights.members, lights.report
    pixel = np.concatenate([members.others, members.pixel])
    light = np.concatenate([np.full(len(members.others), len(lights)), members.light])
    block = -(-env.width // report.working_size[1])
    return LightPixels(pixel, light, lights.direction, block, report.threshold, luminance)


def _removed_lights(
    chosen: DetectedLights, parts: _native.MapSplit, report: DetectionReport
) -> RemovedLights:
    """Removed lights, with the remaining measurements of the detected lights."""
    detected = {each.name: getattr(chosen, each.name) for each in fields(chosen) if each.init}
    measured = {
        "direction": parts.direction,
        "irradiance": parts.irradiance,
        "flux": parts.flux,
        "solid_angle": parts.solid_angle,
        "flux_fraction": parts.flux @ LUMINANCE / (parts.map_flux or 1.0),
        "vector_irradiance": parts.vectors,
        "reach": parts.reach,
        "report": report,
        # Index of the lights in the pixels, because the constructor sorts the lights.
        "origin": range(len(chosen)),
    }
    return RemovedLights(**(detected | measured))


def _report(chosen: DetectedLights, found: int, seconds: float) -> DetectionReport:
    """Detection report that also states the lights that stay."""
    report = chosen.report
    stay = found - len(chosen)
    others = "1 light stays" if stay == 1 else f"{stay} lights stay"
    skipped = (*report.skipped, f"{others} in the map") if stay else report.skipped
    return replace(report, skipped=skipped, seconds={**report.seconds, "split": seconds})


def _notes(removed: RemovedLights) -> tuple[str, ...]:
    if not len(removed):
        return ()
    flux = percent(removed.flux_fraction.sum())
    notes = [f"{removed.in_short()} with {flux} of the flux removed"]
    if cut := int(removed.is_cut.sum()):
        lights = "light lies" if cut == 1 else "lights lie"
        notes.append(
            f"{cut} removed {lights} at the border of what the map shows, so only the seen part was"
            " removed, and the flux is that of this part"
        )
    return tuple(notes)
