"""`split`: the lights of a map, and the map without them."""

from __future__ import annotations

from dataclasses import fields, replace
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights import _native
from envlights._check import amount, count, describe
from envlights._native import EnvLightsError
from envlights.detection.component_tree import searched
from envlights.detection.detect import detect
from envlights.detection.lights import DetectedLights, DetectionReport
from envlights.detection.taken import TakenLights
from envlights.envmap import AnyMap, EnvMap, as_envmap
from envlights.kernels.image import LUMINANCE, reduced_luminance

#: Options of the component tree that find what would be a light once the others are gone: then the
#: threshold of most real maps falls by less than a tenth, and each share of the flux rises.
_ALL: dict[str, Any] = {"rise": 2.25, "min_worth": 0.0}

#: Pixels to each side of a sample of the article that may belong to its light: its own window.
_WINDOW = 6


#: Relative difference of a light's peak between two maps, by more than the rounding of files.
_PEAK = 1e-3

#: Lights as the kernel takes them: pixels of the map in blocks, the light of each, directions,
#: pixels along the side of a block, the threshold, and where the map was cut off.
_Found = tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64], int, float, float | None]


class Split(NamedTuple):
    """Lights, and what is left of their map."""

    lights: TakenLights
    """Lights that were taken out, brightest first."""

    rest: EnvMap
    """The map without them, of the same size and nowhere negative."""

    def __str__(self) -> str:
        return f"{self.lights}\n\nwhat is left: {self.rest}"

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return self.lights._repr_html_() + self.rest._repr_html_()


def split(
    env: AnyMap,
    lights: int | DetectedLights | None = None,
    *,
    share: float | None = None,
    **options: Any,
) -> Split:
    r"""Take lights out of a map: a sun as a lamp, and the sky without it.

    Each light is taken with its rim and its glare. Its place is filled from the surroundings by a
    membrane, a solution of Laplace's equation on the sphere, wherever the map is brighter than
    that. What was taken is measured: for every surface that has all of a light before it, the light
    gives the same as what the map has lost, to rounding in luminance and in every channel for which
    `TakenLights.off_axis` is 0.

    Parameters
    ----------
    env : EnvMap, path or array_like, shape (height, 2 * height, 3)
        The map.
    lights : int or DetectedLights, optional
        How many lights to take, at most, the brightest first: 1 for the sun. Or lights that
        `detect` has found in this map, such as ``found[[0, 2]]``. All that `detect` finds when left
        out.
    share : float, optional
        Take the fewest lights, the brightest first, that give this share of what all found lights
        give together.
    **options
        Those of `detect`, `method` among them. Here `rise` is 2.25 and `min_worth` is 0 unless
        given: what is nearly a light would be one, once the others are gone.

    Returns
    -------
    lights : TakenLights
        With the irradiance at normal incidence of what was taken.
    rest : EnvMap
        What is left, a map like any other; its `notes` say what was removed.

    Raises
    ------
    EnvLightsError
        If `env` is not a map, an option is out of its range, or the given `lights` were found in
        another map: one of another size, or, by the tree, one in which they were brighter or
        darker.

    See Also
    --------
    detect : which places are lights.

    Notes
    -----
    At normal n the map gives :math:`n \cdot V`, with :math:`V = \int T \omega\, d\omega` for the
    radiance T that is taken, and the light :math:`E\, n \cdot d`. They agree where the vectors of
    all channels are parallel. The fill is tilted so that they are, unless that would show: suns end
    with 1e-11 across the direction, and windows with a view may keep some per cent in one channel.
    Where the horizon of a surface cuts a light, the difference is that of its shape from a disc.

    Rings are added around a light as long as their median luminance falls by 1.1 to 1.25 from one
    to the next but one, and for at most 15 degrees. Glare does so, a sky does not. What is then
    connected to them, within 45 degrees, by places above the threshold of `detect` would be a light
    without them: the bright clouds around a sun, or the dim part of a softbox. Of y thresholds
    there remain 2 - 1/4 / (y - 1) where y is above 1.5, so the sky stays and the light points to
    the sun; what ends sharply around most of it, as a softbox does, goes with the light. A light
    rises to more, so nothing is found in the places of lights. Nor is anything else: in a studio
    whose lamps give nearly all light, the threshold of what is left alone would fall to a tenth,
    and the floor would be a light. Whoever looks for that gives the array, ``rest.radiance``.

    Maps that end at a white lose what white has left of a light: its irradiance is a lower bound.
    There y is of expanded luminance; see `detect_tree`.

    References
    ----------
    The fill by cascadic multigrid: F. A. Bornemann, P. Deuflhard: "The cascadic multigrid method
    for elliptic problems", Numerische Mathematik 75, 1996.

    Examples
    --------
    >>> import envlights as el
    >>> sun = el.synthetic.Disc((1, 1, 0), 1.0, (900, 800, 700))
    >>> env = el.EnvMap(el.synthetic.scene(256, background=[0.2, 0.3, 0.4], shapes=[sun]).radiance)
    >>> lights, rest = el.split(env)
    >>> len(lights), rest.radiance.max(axis=(0, 1))
    (1, array([0.2, 0.3, 0.4], dtype=float32))

    The lights and what is left, as a rig: the rest as harmonics.

    >>> sky = el.fit(rest, lights=0, ambient="sh2")
    >>> rig = el.Rig(sky.ambient, lights.discs(), error=0.0)
    >>> np.allclose(rig.probe([[0, 1, 0]]), env.probe([[0, 1, 0]]), rtol=1e-4)
    True
    """
    env = as_envmap(env)
    found, chosen, luminance = _chosen(env, lights, share, options)
    start = perf_counter()
    members = _members(env, chosen)
    if chosen is lights:
        _check_peaks(env, chosen, members)
    radiance = np.empty_like(env.radiance)
    border_sampled = env.registration == "border-sampled"
    parts = _native.split_map(env.radiance, *members, luminance, border_sampled, radiance)
    taken = _taken(chosen, parts, _report(chosen, len(found), perf_counter() - start))
    notes = (*env.notes, *_notes(taken))
    rest = EnvMap.unchecked(
        radiance,
        registration=env.registration,
        notes=notes,
        white=env.white,
    )
    return Split(taken, rest)


def _chosen(
    env: EnvMap, lights: int | DetectedLights | None, share: float | None, options: dict[str, Any]
) -> tuple[DetectedLights, DetectedLights, NDArray[np.float32] | None]:
    """All lights that were found, those that are taken, and the image in which they were found.

    That is its luminance, where this call has searched it by the tree.
    """
    if isinstance(lights, DetectedLights):
        given = [*options, *(["share"] if share is not None else [])]
        if given:
            raise EnvLightsError(
                f"{given[0]} has no meaning for lights that were found before; give one of both"
            )
        _check_size(env, lights.report)
        return lights, lights, None
    most = None if lights is None else _count(lights)
    part = None if share is None else amount("share", share, most=1.0)
    found, luminance = _detected(env, **options)
    if part is not None:
        together = np.cumsum(found.flux_share)
        enough = int(np.searchsorted(together, part * (1 - 1e-12) * found.flux_share.sum())) + 1
        most = min(enough if part else 0, len(found) if most is None else most)
    return found, found if most is None else found[:most], luminance


def _detected(
    env: EnvMap, method: str = "tree", **options: Any
) -> tuple[DetectedLights, NDArray[np.float32] | None]:
    """Lights, and the luminance of the image that was searched by the tree."""
    if method == "tree":
        return searched(env, **_ALL | options)
    return detect(env, method, **options), None


def _count(lights: object) -> int:
    if isinstance(lights, bool) or not isinstance(lights, int | np.integer):
        raise EnvLightsError(
            "lights must be a number, or what `detect` has found, such as found[[0, 2]]; got"
            f" {describe(lights)}"
        )
    return count("lights", int(lights))


def _check_size(env: EnvMap, report: DetectionReport) -> None:
    height, width = report.working_size
    block = -(-env.width // width)
    if report.method == "tree" and (height, width) != _size(env, block):
        raise EnvLightsError(
            f"the lights must be those of this map, of {env.width}x{env.height} pixels; they were"
            f" found in one that was reduced to {width}x{height}"
        )


def _check_peaks(env: EnvMap, lights: DetectedLights, found: _Found) -> None:
    """Refuse lights whose pixels have another peak than that with which they were found."""
    # The article looks for lights in a reduction of the map, whose peaks are not those of pixels.
    if lights.report.method != "tree":
        return
    wanted, seen = lights.peak_luminance, _native.peaks_of_lights(env.radiance, *found)
    for light in np.flatnonzero(np.abs(seen - wanted) > _PEAK * wanted)[:1]:
        raise EnvLightsError(
            f"the lights must be those of this map: light {light} was found with a peak luminance"
            f" of {wanted[light]:.4g}, and its brightest pixel here has {seen[light]:.4g}"
        )


def _size(env: EnvMap, block: int) -> tuple[int, int]:
    """Height and width of a map in blocks of pixels."""
    return -(-env.height // block), -(-env.width // block)


def _pixels(
    env: EnvMap, lights: DetectedLights, block: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Pixels of the map in blocks, each with its light; those that stay have the number after."""
    members = lights.members
    pixel = np.concatenate([members.others, members.pixel])
    light = np.concatenate([np.full(len(members.others), len(lights)), members.light])
    if lights.report.method == "tree":
        return pixel, light
    return _bright_around(env, pixel, light, lights.report, block)


def _bright_around(
    env: EnvMap,
    sample: NDArray[np.int64],
    light: NDArray[np.int64],
    report: DetectionReport,
    block: int,
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Bright pixels around samples of the article; the first sample, the brightest, has them."""
    size = _size(env, block)
    image = reduced_luminance(
        env.radiance, size[1], border_sampled=env.registration == "border-sampled"
    )
    centre = ((sample + 0.5) * size / report.working_size).astype(np.int64)
    steps = np.arange(-_WINDOW, _WINDOW + 1)
    window = np.stack(np.meshgrid(steps, steps, indexing="ij"), axis=-1).reshape(-1, 2)
    # From the last to the first: of the lights that are given a pixel, the last one has it.
    pixel = (centre[::-1, None] + window).reshape(-1, 2)
    light = light[::-1].repeat(len(window))
    pixel[:, 1] %= size[1]
    inside = (pixel[:, 0] >= 0) & (pixel[:, 0] < size[0])
    pixel, light = pixel[inside], light[inside]
    bright = image[pixel[:, 0], pixel[:, 1]] > report.threshold
    return pixel[bright], light[bright]


def _members(env: EnvMap, lights: DetectedLights) -> _Found:
    """Lights as the kernel takes them."""
    block = -(-env.width // lights.report.working_size[1])
    report = lights.report
    return (
        *_pixels(env, lights, block),
        lights.direction,
        block,
        report.threshold,
        report.clip_level,
    )


def _taken(chosen: DetectedLights, parts: _native.MapSplit, report: DetectionReport) -> TakenLights:
    """What was taken, with the measurements of what was found."""
    kept = {each.name: getattr(chosen, each.name) for each in fields(chosen) if each.init}
    measured = {
        "direction": parts.direction,
        "irradiance": parts.irradiance,
        "solid_angle": parts.solid_angle,
        "flux_share": parts.flux / _map_flux(chosen),
        "vector_irradiance": parts.vectors,
        "reach": parts.reach,
        "report": report,
    }
    return TakenLights(**(kept | measured))


def _map_flux(lights: DetectedLights) -> float:
    """Luminance flux of the map in which lights were found; 1 where none were."""
    share = float(lights.flux_share.sum())
    return float((lights.flux @ LUMINANCE).sum()) / share if share else 1.0


def _report(chosen: DetectedLights, found: int, seconds: float) -> DetectionReport:
    """The report of the detection, with the lights that stay."""
    report = chosen.report
    stay = found - len(chosen)
    skipped = (*report.skipped, f"{stay} lights, which stay in the map") if stay else report.skipped
    return replace(report, skipped=skipped, seconds={**report.seconds, "split": seconds})


def _notes(taken: TakenLights) -> tuple[str, ...]:
    if not len(taken):
        return ()
    percent = 100 * taken.flux_share.sum()
    return (f"{taken.in_short()} with {percent:.3g} % of the flux taken out",)
