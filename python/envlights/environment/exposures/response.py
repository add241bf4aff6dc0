"""Camera response: the exposure of each code, known or estimated.

Named curves come first. If none fits, a smooth correction of the best one is fitted to the codes of
equal radiance (Debevec and Malik 1997, equation 3): few knots, because two to five exposures do not
determine 256 codes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import describe
from envlights._common.srgb import decode_srgb
from envlights._native import EnvLightsError
from envlights.environment.colour.transfer_curves import rec709
from envlights.environment.exposures.comparison import LEVELS, Comparison

#: Codes from 0 to 1 at which a response is tabulated.
CODES = np.arange(LEVELS) / (LEVELS - 1)
#: Smallest exposure, so that logarithms are finite: 0.01 steps of a code.
_LEAST = 1e-5
#: Knots of the correction, as codes; dense where cameras differ from sRGB.
_KNOTS = np.array([0.0, 0.04, 0.08, 0.14, 0.22, 0.32, 0.44, 0.56, 0.67, 0.77, 0.85, 0.92, 1.0])
#: Penalty on second differences of the correction at the knots, for residuals of 1 %; chosen by
#: hand.
_SMOOTHNESS = 0.03
#: Noise of a code and of a log exposure; number of pixels that halves a weight.
_CODE_NOISE, _LOG_NOISE, _MANY = 0.7 / 255, 0.01, 30.0
#: Iterations of robust reweighting, and the scale of outliers.
_PASSES, _OUTLIER = 8, 0.05


@dataclass(frozen=True, eq=False)
class Response:
    """Exposure of each code, relative to the clip level."""

    name: str
    """Name for notes."""

    log_exposure: NDArray[np.float64]
    """Natural logarithms of the exposures of `CODES`, (256,)."""

    curve: Callable[[NDArray[Any]], NDArray[Any]] | None = None
    """Function from codes to exposures, up to a factor; None if only `log_exposure` is known."""

    def exposure(self, codes: NDArray[np.floating]) -> NDArray[np.float32]:
        """Exposures of codes from 0 to 1."""
        if self.curve is not None:
            level = np.exp(self.log_exposure[-1]) / float(self.curve(np.ones(1))[0])
            return np.asarray(self.curve(codes) * level, dtype=np.float32)
        table = np.exp(self.log_exposure)
        table[table <= 1.01 * _LEAST] = 0
        return np.asarray(np.interp(codes, CODES, table), dtype=np.float32)

    def logarithm(self, codes: NDArray[np.floating]) -> NDArray[np.float64]:
        """Natural logarithms of exposures."""
        return np.asarray(np.interp(codes, CODES, self.log_exposure))

    def slope(self, codes: NDArray[np.floating]) -> NDArray[np.float64]:
        """Derivative of the log exposure by the code."""
        return np.asarray(np.interp(codes, CODES, np.gradient(self.log_exposure, CODES)))

    def scaled(self, clip_level: float) -> Response:
        """Response scaled so that its exposure is 1 at the code `clip_level`."""
        return replace(
            self, log_exposure=self.log_exposure - self.logarithm(np.array([clip_level]))[0]
        )


def known_responses(clip_level: float) -> list[Response]:
    """Known responses, most likely first; `clip_level` is the largest code."""
    curves: dict[str, Callable[[NDArray[np.float64]], NDArray[np.floating]]] = {
        "sRGB": decode_srgb,
        f"sRGB up to code {255 * clip_level:.0f}": lambda codes: decode_srgb(codes / clip_level),
        "Rec.709": rec709,
        "gamma 2.2": lambda codes: codes**2.2,
        "gamma 1.8": lambda codes: codes**1.8,
        "sRGB in video range (16 to 235)": lambda codes: decode_srgb(_full_range(codes)),
        "Rec.709 in video range (16 to 235)": lambda codes: rec709(_full_range(codes)),
    }
    if clip_level > 254.5 / 255:
        curves.pop("sRGB up to code 255")
    return [_response(name, curve).scaled(clip_level) for name, curve in curves.items()]


def by_hand(response: object, clip_level: float) -> Response:
    """Response given by the caller: "srgb", "linear", or the exposures of 256 codes."""
    if isinstance(response, str):
        if response == "srgb":
            return _response("sRGB", decode_srgb).scaled(clip_level)
        if response == "linear":
            return _response("linear", lambda codes: codes).scaled(clip_level)
        raise EnvLightsError(
            f"response must be 'srgb', 'linear' or {LEVELS} exposures; got {describe(response)}"
        )
    return _response("of the caller", _interpolate(_checked_curve(response))).scaled(clip_level)


def _checked_curve(response: object) -> NDArray[np.float64]:
    wanted = f"response must be 'srgb', 'linear' or {LEVELS} exposures that rise with the code"
    try:
        curve = np.asarray(response, dtype=np.float64)
    except (TypeError, ValueError):
        raise EnvLightsError(f"{wanted}; got {describe(response)}") from None
    if curve.shape != (LEVELS,):
        raise EnvLightsError(f"{wanted}; got an array of shape {curve.shape}")
    if not np.isfinite(curve).all() or curve[0] < 0 or (np.diff(curve) < 0).any() or curve[-1] <= 0:
        raise EnvLightsError(f"{wanted}; got a curve that falls, or is negative or not finite")
    return np.asarray(curve / curve[-1])


def fit_response(
    base: Response, pairs: list[Comparison], log_times: NDArray[np.float64], clip_level: float
) -> Response:
    """Response that differs smoothly from `base` and fits the pairs best."""
    low, high, wanted, weight = _equations(base, pairs, log_times)
    matrix = _hats(high) - _hats(low)
    bends = np.diff(np.eye(len(_KNOTS)), 2, axis=0) * _SMOOTHNESS / _LOG_NOISE * np.sqrt(len(low))
    anchor = 1e3 * _hats(np.array([clip_level]))
    knots = np.zeros(len(_KNOTS))
    for _ in range(_PASSES):
        residual = wanted - matrix @ knots
        robust = np.sqrt(weight / (1 + (residual / _OUTLIER) ** 2))
        rows = np.concatenate([robust[:, None] * matrix, bends, anchor])
        right = np.concatenate([robust * wanted, np.zeros(len(bends) + 1)])
        knots = np.linalg.lstsq(rows, right, rcond=None)[0]
    curve = np.maximum.accumulate(base.log_exposure + _hats(CODES) @ knots)
    return Response("estimated", curve).scaled(clip_level)


def residuals(
    response: Response, pair: Comparison, log_times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Differences of log exposures minus differences of log times, and weights, (n,) each."""
    ratio = response.logarithm(pair.high) - response.logarithm(pair.low)
    noise = _CODE_NOISE**2 * (response.slope(pair.low) ** 2 + response.slope(pair.high) ** 2)
    weight = pair.count / (pair.count + _MANY) / (noise + _LOG_NOISE**2)
    return ratio - (log_times[pair.long] - log_times[pair.short]), weight


def _equations(
    base: Response, pairs: list[Comparison], log_times: NDArray[np.float64]
) -> tuple[NDArray[np.float64], ...]:
    """Codes of the pairs, their desired corrections, and weights with a mean of 1 / noise^2."""
    parts = []
    for pair in pairs:
        residual, weight = residuals(base, pair, log_times)
        parts.append((pair.low, pair.high, -residual, weight))
    low, high, wanted, weight = (np.concatenate(part) for part in zip(*parts, strict=True))
    return low, high, wanted, weight


def _hats(codes: NDArray[np.floating]) -> NDArray[np.float64]:
    """Piecewise linear basis functions, one per knot, at the codes, (n, knots)."""
    columns = [np.interp(codes, _KNOTS, column) for column in np.eye(len(_KNOTS))]
    return np.stack(columns, axis=1)


def _response(name: str, curve: Callable[[NDArray[Any]], NDArray[Any]]) -> Response:
    exposure = np.maximum(curve(CODES).astype(np.float64), _LEAST)
    return Response(name, np.log(exposure), curve)


def _interpolate(exposures: NDArray[np.float64]) -> Callable[[NDArray[Any]], NDArray[Any]]:
    return lambda codes: np.asarray(np.interp(codes, CODES, exposures))


def _full_range(codes: NDArray[np.float64]) -> NDArray[np.float64]:
    """Video codes (16 to 235) rescaled to the range 0 to 1."""
    return np.clip((255 * codes - 16) / 219, 0, 1.1)
