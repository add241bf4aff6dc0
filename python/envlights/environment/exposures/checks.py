"""Choice of the response and times that agree with the pictures, and detection of a wrong time."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._native import EnvLightsError
from envlights.environment.exposures.comparison import Comparison
from envlights.environment.exposures.response import Response, fit_response, residuals

#: Mean relative residual below which a response fits; JPEG of quality 80 leaves 2 %.
_FITS = 0.025
#: Mean relative residual above which nothing fits.
_FITS_NOT = 0.08
#: Factor by which an estimated response must reduce the residual to replace a known one.
_GAIN = 0.7
#: Smallest log ratio of a wrong time to the right one that is corrected.
_WRONG = np.log(1.1)
#: Smallest log ratio if only a few pixels show it; JPEG of quality 80 moves those by a factor of
#: 1.5.
_WRONG_OF_FEW = np.log(1.8)
#: Fraction of the codes that the residual counts: JPEG spoils single codes, but fewer than the
#: rest.
_MOST_PIXELS = 0.7
#: Number of pixels at which a pair has half of its full weight. Without it, 69 pixels around a sun
#: made a valid series fail.
_MANY = 3000.0
#: Log ratio of exposures to times above which a note warns.
_DOUBT = np.log(1.1)
#: Difference between channels above which a note reports drift of the white balance.
_DRIFT = 0.06


@dataclass(frozen=True, eq=False)
class Agreement:
    """Response and times of a series, and their residual."""

    response: Response
    """Response shared by all pictures."""

    log_times: NDArray[np.float64]
    """Natural logarithms of the corrected times."""

    wrong: int | None
    """Index of the picture whose time was wrong; None if all times are right."""

    residual: float
    """Mean relative residual."""


def agreement(
    candidates: list[Response],
    pairs: list[Comparison],
    log_times: NDArray[np.float64],
    clip_level: float,
    *,
    may_estimate: bool,
) -> Agreement:
    """Simplest response and times that fit: known responses first, then a single wrong time."""
    if not pairs:
        return Agreement(candidates[0], log_times, None, 0.0)
    stated = [_score(each, pairs, log_times) for each in candidates]
    if _agrees(stated[0], pairs, log_times):
        return stated[0]
    corrected = [one for each in candidates for one in _with_one_wrong(each, pairs, log_times)]
    if (best := _first_that_fits(stated) or _first_that_fits(corrected)) is not None:
        return best
    estimated: list[Agreement] = []
    if _is_one_wrong_time(candidates[0], pairs, log_times):
        return stated[0]
    if may_estimate:
        base = min([*stated, *corrected], key=lambda each: each.residual).response
        for start in (candidates[0], base):
            estimated += _estimate(start, pairs, log_times, clip_level)
    return _simplest([*stated, *corrected], estimated)


def _agrees(found: Agreement, pairs: list[Comparison], log_times: NDArray[np.float64]) -> bool:
    """True if the medians of all pairs agree, even if single codes do not."""
    offsets = [abs(offset(found.response, pair, log_times)) for pair in pairs]
    return bool(found.residual < _FITS_NOT and max(offsets) < _FITS)


def _is_believed(place: int, change: float, pairs: list[Comparison]) -> bool:
    """True if the correction of a time is large enough for its number of pixels."""
    pixels = sum(pair.count.sum() for pair in pairs if place in (pair.short, pair.long))
    return bool(abs(change) > (_WRONG if pixels > _MANY else _WRONG_OF_FEW))


def _simplest(known: list[Agreement], estimated: list[Agreement]) -> Agreement:
    """Known response unless an estimate is much better; prefers results without a wrong time."""
    fits = [each for each in estimated if each.residual < _FITS]
    choices = [each for each in fits if each.wrong is None] or fits or estimated
    best = min(known, key=lambda each: each.residual)
    if not choices:
        return best
    other = min(choices, key=lambda each: each.residual)
    is_known = best.residual < _FITS_NOT and _GAIN * best.residual < other.residual
    return best if is_known else other


def _is_one_wrong_time(
    response: Response, pairs: list[Comparison], log_times: NDArray[np.float64]
) -> bool:
    """True if a single pair differs by one factor at all codes: one of its times is wrong."""
    if len(pairs) > 1:
        return False
    change = offset(response, pairs[0], log_times)
    corrected = log_times.copy()
    corrected[pairs[0].long] += change
    return abs(change) > _WRONG and _residual(response, pairs, corrected) < _FITS


def _first_that_fits(found: list[Agreement]) -> Agreement | None:
    """First response if it fits and none is much better; otherwise the best one that fits."""
    if not found:
        return None
    best = min(found, key=lambda each: each.residual)
    if found[0].residual < _FITS and _GAIN * found[0].residual < best.residual + 0.01:
        return found[0]
    return best if best.residual < _FITS else None


def _score(
    response: Response, pairs: list[Comparison], log_times: NDArray[np.float64]
) -> Agreement:
    return Agreement(response, log_times, None, _residual(response, pairs, log_times))


def _residual(response: Response, pairs: list[Comparison], log_times: NDArray[np.float64]) -> float:
    """Weighted mean over pairs of a quantile of the residuals; small pairs count less."""
    scores, weights = [], []
    for pair in pairs:
        residual, weight = _without_drift(pair, *residuals(response, pair, log_times))
        scores.append(weighted_quantile(np.abs(residual), weight, _MOST_PIXELS))
        weights.append(pair.count.sum() / (pair.count.sum() + _MANY))
    return float(np.average(scores, weights=weights))


def _without_drift(
    pair: Comparison, residual: NDArray[np.float64], weight: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Residuals shifted to the same median in all channels, and their weights."""
    parts = [part for channel in range(3) if (part := pair.channel == channel).any()]
    medians = [weighted_quantile(residual[part], weight[part], 0.5) for part in parts]
    equal = residual.copy()
    for part, own in zip(parts, medians, strict=True):
        equal[part] += np.median(medians) - own
    return equal, weight


def offset(response: Response, pair: Comparison, log_times: NDArray[np.float64]) -> float:
    """Weighted median of the residuals of a pair."""
    residual, weight = residuals(response, pair, log_times)
    return weighted_quantile(residual, weight, 0.5)


def weighted_quantile(
    values: NDArray[np.float64], weights: NDArray[np.float64], fraction: float
) -> float:
    """Weighted quantile of the values."""
    order = np.argsort(values)
    total = np.cumsum(weights[order])
    return float(values[order][np.searchsorted(total, fraction * total[-1])])


def _with_one_wrong(
    response: Response, pairs: list[Comparison], log_times: NDArray[np.float64]
) -> list[Agreement]:
    """Best correction of each time that the other pictures determine, best first."""
    found = []
    for place in range(len(log_times)):
        if not _is_determined(place, pairs):
            continue
        corrected = _correct(response, pairs, log_times, place)
        if _is_believed(place, corrected[place] - log_times[place], pairs):
            residual = _residual(response, pairs, corrected)
            found.append(Agreement(response, corrected, place, residual))
    return sorted(found, key=lambda each: each.residual)


def _is_determined(place: int, pairs: list[Comparison]) -> bool:
    """True if comparisons with other pictures determine the time of this one."""
    own = [pair for pair in pairs if place in (pair.short, pair.long)]
    partners = {end for pair in own for end in (pair.short, pair.long)} - {place}
    others = {end for pair in pairs if pair not in own for end in (pair.short, pair.long)}
    return len(partners) > 1 or bool(partners & others)


def _correct(
    response: Response, pairs: list[Comparison], log_times: NDArray[np.float64], place: int
) -> NDArray[np.float64]:
    """Times with one replaced by the estimate from its pairs."""
    offsets = [
        offset(response, pair, log_times) * (1 if pair.long == place else -1)
        for pair in pairs
        if place in (pair.short, pair.long)
    ]
    corrected = log_times.copy()
    corrected[place] += float(np.median(offsets))
    return corrected


def _estimate(
    base: Response, pairs: list[Comparison], log_times: NDArray[np.float64], clip_level: float
) -> list[Agreement]:
    """Estimated responses: from all pairs, and from the pairs without each picture."""
    found = [_score(fit_response(base, pairs, log_times, clip_level), pairs, log_times)]
    for place in range(len(log_times)):
        others = [pair for pair in pairs if place not in (pair.short, pair.long)]
        if not others or not _is_determined(place, pairs):
            continue
        response = fit_response(base, others, log_times, clip_level)
        corrected = _correct(response, pairs, log_times, place)
        response = fit_response(base, pairs, corrected, clip_level)
        corrected = _correct(response, pairs, log_times, place)
        if _is_believed(place, corrected[place] - log_times[place], pairs):
            residual = _residual(response, pairs, corrected)
            found.append(Agreement(response, corrected, place, residual))
    return found


def refuse_contradiction(
    found: Agreement, pairs: list[Comparison], log_times: NDArray[np.float64], numbers: list[int]
) -> None:
    """Raise an error for a series that no response and no single wrong time explain."""
    if not pairs or found.residual <= _FITS_NOT:
        return
    told = []
    for pair in pairs:
        stated = log_times[pair.long] - log_times[pair.short]
        excess = offset(found.response, pair, log_times)
        if pair.long - pair.short == 1 or len(pairs) == 1:
            told.append(
                f"{numbers[pair.short]} and {numbers[pair.long]} by a factor of"
                f" {np.exp(stated + excess):.3g}, their times by {np.exp(stated):.3g}"
            )
    raise EnvLightsError(
        f"the exposures contradict their times: exposures {'; '.join(told)}; give the right times,"
        " or the response of the camera as `response`"
    )


def notes_of_pairs(found: Agreement, pairs: list[Comparison], numbers: list[int]) -> list[str]:
    """Notes on neighbouring pictures whose times are doubtful, or cannot be checked."""
    known = {(pair.short, pair.long): pair for pair in pairs}
    notes = []
    for place in range(len(numbers) - 1):
        pair = known.get((place, place + 1))
        both = f"exposures {numbers[place]} and {numbers[place + 1]}"
        if pair is None:
            notes.append(f"{both} have too few pixels in common to check their times")
            continue
        excess = offset(found.response, pair, found.log_times)
        if abs(excess) > _DOUBT:
            stated = found.log_times[pair.long] - found.log_times[pair.short]
            notes.append(
                f"{both} differ by a factor of {np.exp(stated + excess):.3g}, their times by"
                f" {np.exp(stated):.3g}, on few pixels: is a time wrong?"
            )
    return notes


def notes_of_drift(found: Agreement, pairs: list[Comparison], numbers: list[int]) -> list[str]:
    """Notes on neighbouring pictures whose white balance differs."""
    notes = []
    for pair in pairs:
        if pair.long - pair.short != 1 or pair.count.sum() < _MANY:
            continue
        residual, weight = residuals(found.response, pair, found.log_times)
        parts = [pair.channel == channel for channel in range(3)]
        if not all(part.any() for part in parts):
            continue
        offsets = np.array([weighted_quantile(residual[part], weight[part], 0.5) for part in parts])
        if np.ptp(offsets) > _DRIFT:
            factors = ", ".join(f"{factor:.2f}" for factor in np.exp(offsets - np.median(offsets)))
            notes.append(
                f"exposures {numbers[pair.short]} and {numbers[pair.long]} differ in white balance:"
                f" red, green and blue by {factors}"
            )
    return notes
