"""Random variations of rigs for training, bitwise equal for a seed on every machine."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common import check
from envlights._common.check import amount, describe
from envlights._native import EnvLightsError
from envlights.kernels.ambient import as_harmonics, turned_about_pole
from envlights.rigs.lights import Lights
from envlights.rigs.planck import planck_gains
from envlights.rigs.portable import circle, power_of_two, uniform
from envlights.rigs.rig import Rig, error_of

#: Number, or (lowest, highest) of a range.
Range = float | tuple[float, float]

#: Smallest and largest values. 20 stops are a factor of a million. Blue is positive from 2000 K on,
#: and the formula ends at 15000 K. Direction tolerances above 20 degrees are hardly meaningful.
_LIMITS = {
    "azimuth": (-math.inf, math.inf),
    "exposure": (-20.0, 20.0),
    "temperature": (2000.0, 15000.0),
    "mix": (0.0, 1.0),
    "tolerance": (0.0, math.radians(20.0)),
}
#: Random numbers per variation before those of the lights, and random numbers per light.
_HEAD, _EACH = 6, 3


class Variation(NamedTuple):
    """Varied rig, and the applied changes."""

    rig: Rig
    """Varied rig. Its `error` is the largest of its sources, and its report is empty."""

    number: int
    """Index in the stream, from 0."""

    sources: tuple[int, ...]
    """Index of the varied rig, or indices of the two mixed rigs."""

    mix: float
    """Weight of the second source; 0 if there is none."""

    azimuth: float
    """Degrees added to all azimuths."""

    exposure: float
    """Exposure change in stops, for all light."""

    temperature: float
    """Colour temperature in kelvins to which white light was changed."""

    dropped: tuple[int, ...]
    """Indices of omitted lights, in the concatenated lights of the sources."""

    jitter: tuple[float, ...]
    """Distance on the unit sphere by which each source light was moved; approximately radians."""

    def changes(self) -> dict[str, Any]:
        """All fields except the rig, as plain numbers and lists."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in self._asdict().items()
            if name != "rig"
        }


class _Part(NamedTuple):
    """Source rig that is varied or mixed."""

    rig: Rig
    reach: NDArray[np.float64]
    """1 - cosine of the largest displacement of each light."""
    weight: float = 1.0


class _Ranges(NamedTuple):
    """Checked ranges of `vary`."""

    mix: tuple[float, float]
    azimuth: tuple[float, float]
    exposure: tuple[float, float]
    mired: tuple[float, float]
    drop: float


def vary(
    rigs: Rig | Iterable[Rig],
    count: int | None = None,
    *,
    seed: int = 0,
    azimuth: Range = (0.0, 360.0),
    exposure: Range = (-1.0, 1.0),
    temperature: Range = (5000.0, 8000.0),
    mix: Range = 0.0,
    drop: float = 0.0,
    jitter: float = 1.0,
) -> Iterator[Variation]:
    """Vary rigs at random, for training on many lightings (domain randomisation).

    A range is a pair, or one number that all variations have. Numbers are uniform in their range.
    Each variation draws one of the rigs, mixes it with another, drops and moves lights, turns all
    about the pole, and multiplies all light by a colour and an exposure.

    Parameters
    ----------
    rigs : Rig or iterable of Rig
        Rigs of the same units, such as `fit` returns.
    count : int, optional
        Number of variations. Default: without end.
    seed : int
        Seed of the stream. A variation depends on the seed, its number and the rigs alone, and a
        change of one range changes nothing else.
    azimuth : float or (float, float)
        Degrees by which the rig is turned, in the order of map columns.
    exposure : float or (float, float)
        Stops, from -20 to 20: light is multiplied by 2 to this power.
    temperature : float or (float, float)
        Colour temperature of white light along the Planck locus, from 2000 to 15000 kelvins, with
        its luminance unchanged. It is uniform in mireds (1e6 / K); 6504 changes nothing.
    mix : float or (float, float)
        Weight of a second rig, from 0 to 1; the first has one minus it. It needs several rigs,
        which have all a floor or none.
    drop : float
        Probability of each light to be left out.
    jitter : float
        Largest movement of each light, relative to its direction tolerance in the report of the
        fit, or to 20 degrees if that is less. Lights without a report stay, and fixed ones too.

    Yields
    ------
    Variation
        The rig, and what was changed.

    Raises
    ------
    EnvLightsError
        If there is no rig, their units differ, or an argument is out of its range.

    Notes
    -----
    Random bits are those of `numpy.random.PCG64` with ``SeedSequence(seed, spawn_key=(number,))``,
    and everything that is computed from them has the same bits on every machine.

    Examples
    --------
    >>> import envlights as el
    >>> rig = el.fit(el.synthetic.hall(64).radiance, lights=2)
    >>> one, two = el.vary(rig, 2, seed=7, exposure=(0, 2))
    >>> round(one.azimuth, 2), round(one.exposure, 3), len(two.rig.lights)
    (312.78, 1.459, 2)
    """
    each = _rigs_of(rigs)
    seed = check.count("seed", seed)
    numbers = itertools.count() if count is None else range(check.count("count", count))
    ranges = _Ranges(
        _range("mix", mix),
        _range("azimuth", azimuth),
        _range("exposure", exposure),
        _reciprocal(_range("temperature", temperature)),
        amount("drop", drop, most=1.0),
    )
    if ranges.mix[1] and (len(each) < 2 or len({rig.floor for rig in each}) > 1):
        raise EnvLightsError(
            "mix needs two rigs or more, all with a floor or all without one; leave out mix"
        )
    furthest = amount("jitter", jitter)
    parts = [_Part(rig, _reach(rig, furthest)) for rig in each]
    return (_variation(parts, seed, number, ranges) for number in numbers)


def _reciprocal(kelvins: tuple[float, float]) -> tuple[float, float]:
    low, high = kelvins
    return 1e6 / high, 1e6 / low


def _rigs_of(rigs: Any) -> list[Rig]:
    """Rigs as a list; raises an error for other values."""
    each = [rigs] if isinstance(rigs, Rig) else [*rigs] if isinstance(rigs, Iterable) else []
    if not each or not all(isinstance(rig, Rig) for rig in each):
        raise EnvLightsError(f"rigs must be a Rig or several, as of `fit`; got {describe(rigs)}")
    if len({rig.units for rig in each}) > 1:
        raise EnvLightsError("rigs must have the same units; calibrate the maps of all, or of none")
    return each


def _range(name: str, value: Any) -> tuple[float, float]:
    """Lowest and highest value of a range."""
    ends = tuple(value) if isinstance(value, tuple | list | np.ndarray) else (value, value)
    if len(ends) != 2:
        raise EnvLightsError(
            f"{name} must be a number, or the lowest and the highest; got {describe(value)}"
        )
    low, high = (amount(name, end, *_LIMITS[name]) for end in ends)
    if low > high:
        raise EnvLightsError(f"{name} must have its lowest value first; got {describe(value)}")
    return low, high


def _reach(rig: Rig, jitter: float) -> NDArray[np.float64]:
    """1 - cosine of the largest displacement of each light; 0 if the report has no tolerances."""
    known = rig.report.direction_tolerances
    if len(known) != len(rig.lights):
        return np.zeros(len(rig.lights))
    widest = jitter * np.minimum(known, _LIMITS["tolerance"][1])
    sine = circle(np.minimum(widest, math.pi) / (4.0 * math.pi))[1]  # of half the angle
    return 2.0 * sine * sine


def _variation(parts: list[_Part], seed: int, number: int, ranges: _Ranges) -> Variation:
    most = max(len(part.rig.lights) for part in parts)
    drawn = uniform(seed, number, _HEAD + 2 * _EACH * most)
    first, second, *values = drawn[:_HEAD].tolist()
    spans = ranges.mix, ranges.azimuth, ranges.exposure, ranges.mired
    mix, azimuth, exposure, mired = (
        low + (high - low) * value for (low, high), value in zip(spans, values, strict=True)
    )
    sources = _sources(len(parts), first, second)[: 2 if ranges.mix[1] else 1]
    chosen = [parts[k]._replace(weight=w) for k, w in zip(sources, (1.0 - mix, mix), strict=False)]
    each = drawn[_HEAD:].reshape(2, most, _EACH)
    draws = np.concatenate([each[k, : len(part.reach)] for k, part in enumerate(chosen)])
    gains = np.array(planck_gains(1e6 / mired)) * power_of_two(exposure)
    is_dropped = draws[:, 0] < ranges.drop
    rig, angles = _change(chosen, azimuth, gains, draws[:, 1:], is_dropped)
    dropped = tuple(np.flatnonzero(is_dropped).tolist())
    return Variation(rig, number, sources, mix, azimuth, exposure, 1e6 / mired, dropped, angles)


def _sources(rigs: int, first: float, second: float) -> tuple[int, int]:
    """Indices of two different rigs, if there are two."""
    one = int(first * rigs)
    return one, (one + 1 + int(second * (rigs - 1))) % rigs


def _change(
    parts: list[_Part],
    azimuth: float,
    gains: NDArray[np.float64],
    draws: NDArray[np.float64],
    is_dropped: NDArray[np.bool_],
) -> tuple[Rig, tuple[float, ...]]:
    """Rig after all changes, and the distance by which each light was moved."""
    rigs = [part.rig for part in parts]
    lights = [rig.lights for rig in rigs]
    cosines, sines = circle(np.append(draws[:, 1], azimuth / 360.0))
    chord = draws[:, 0] * np.concatenate([part.reach for part in parts])
    direction = np.concatenate([each.direction for each in lights])
    x, y, z = _move(direction.T, chord, cosines[:-1], sines[:-1])
    cosine, sine = float(cosines[-1]), float(sines[-1])
    arrays = (
        np.stack([cosine * x - sine * z, y, cosine * z + sine * x], axis=1),
        gains * np.concatenate([part.weight * part.rig.lights.irradiance for part in parts]),
        np.concatenate([each.angular_radius for each in lights]),
    )
    notes = _together(each.notes for each in lights)
    rig = Rig(
        gains * turned_about_pole(_ambient(parts), cosine, sine),
        Lights(*(array[~is_dropped] for array in arrays), units=rigs[0].units, notes=notes),
        None if any(rig.error is None for rig in rigs) else max(map(error_of, rigs)),
        notes=_together(rig.notes for rig in rigs),
        floor=rigs[0].floor,
    )
    return rig, tuple(np.sqrt(2.0 * chord).tolist())


def _together(notes: Iterable[tuple[str, ...]]) -> tuple[str, ...]:
    """Notes of several rigs, without duplicates."""
    return tuple(dict.fromkeys(note for each in notes for note in each))


def _ambient(parts: list[_Part]) -> NDArray[np.float64]:
    """Weighted sum of the ambient terms; harmonics if any of them has harmonics."""
    terms = [part.rig.ambient for part in parts]
    if len({term.ndim for term in terms}) > 1:
        terms = [as_harmonics(term) for term in terms]
    total = parts[0].weight * terms[0]
    for term, part in zip(terms[1:], parts[1:], strict=True):
        total = total + part.weight * term
    return total


def _move(
    direction: NDArray[np.float64],
    chord: NDArray[np.float64],
    along: NDArray[np.float64],
    across: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Directions, (3, n), moved by angles with 1 - cosine `chord`, along two tangents."""
    cosine, sine = 1.0 - chord, np.sqrt(chord * (2.0 - chord))
    x, y, z = direction
    # Duff et al. (2017), "Building an orthonormal basis, revisited".
    sign = np.copysign(1.0, z)
    a = -1.0 / (sign + z)
    b = x * y * a
    first = np.stack([1.0 + sign * x * x * a, sign * b, -sign * x])
    second = np.stack([b, sign + y * y * a, -y])
    moved = cosine * direction + sine * (along * first + across * second)
    length = np.sqrt(moved[0] * moved[0] + moved[1] * moved[1] + moved[2] * moved[2])
    return np.asarray(moved / length, np.float64)
