"""Transfer curves: functions from codes in 0 to 1 to linear values.

A curve is a function of an array of codes. Negative codes of floating point files get the negative
value of the positive code, and codes above 1 continue the formula.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights._common.srgb import decode_srgb, encode_srgb

Reals = NDArray[np.float64]
#: Function from codes to linear values, in an array of the same shape.
Curve = Callable[[Reals], Reals]

#: Luminance in cd/m2 of diffuse white, which is mapped to 1 (ITU-R BT.2408).
DIFFUSE_WHITE = 203.0
#: HLG signal of diffuse white (ITU-R BT.2408, table 1).
_HLG_WHITE = 0.75

#: Exponents of Adobe RGB (1998), exactly 2 + 51/256, and of ROMM RGB.
ADOBE_EXPONENT, PROPHOTO_EXPONENT = 563 / 256, 1.8

#: Largest difference from sRGB, in code, that counts as rounded sRGB: half an 8-bit code. Without
#: it, pictures with the usual profiles differ in the last digits from pictures without.
_SRGB_TOLERANCE = 0.5 / 255

#: Last part of a sampled curve, whose exponent extrapolates it above code 1.
_TAIL = 0.1
#: Largest exponent of the extrapolation.
_MOST_EXPONENT = 5.0


def odd(curve: Curve) -> Curve:
    """Curve extended to negative codes by odd symmetry."""

    def extension(codes: Reals) -> Reals:
        codes = np.asarray(codes, np.float64)
        return np.asarray(np.copysign(curve(np.abs(codes)), codes))

    return extension


def srgb(codes: Reals) -> Reals:
    """Linear values of sRGB codes, rounded to single precision."""
    return np.asarray(np.copysign(decode_srgb(np.abs(codes)), codes), np.float64)


@dataclass(frozen=True)
class Power:
    """Linear values as a power of the codes, times a factor."""

    exponent: float
    factor: float = 1.0

    def __call__(self, codes: Reals) -> Reals:
        """Linear values of codes."""
        codes = np.asarray(codes, np.float64)
        return np.asarray(self.factor * np.copysign(np.abs(codes) ** self.exponent, codes))


@odd
def rec709(codes: Reals) -> Reals:
    """Linear scene values by the inverse of the camera curve of ITU-R BT.709 and BT.2020."""
    # Both constants to the 12-bit precision of BT.2020.
    alpha, beta = 1.09929682680944, 0.018053968510807
    return np.where(codes < 4.5 * beta, codes / 4.5, ((codes + (alpha - 1)) / alpha) ** (1 / 0.45))


@odd
def prophoto(codes: Reals) -> Reals:
    """Linear values of ROMM RGB codes (ISO 22028-2)."""
    return np.where(codes < 16 / 512, codes / 16, codes**PROPHOTO_EXPONENT)


@odd
def pq(codes: Reals) -> Reals:
    """Linear values of PQ codes (SMPTE ST 2084); 203 cd/m2 is mapped to 1."""
    m1, m2, c1, c2, c3 = 0.1593017578125, 78.84375, 0.8359375, 18.8515625, 18.6875
    # Codes above 1 are undefined; they get the luminance of code 1, 10000 cd/m2.
    power = np.minimum(codes, 1) ** (1 / m2)
    return (np.maximum(power - c1, 0) / (c2 - c3 * power)) ** (1 / m1) * (10000 / DIFFUSE_WHITE)


@odd
def hlg(codes: Reals) -> Reals:
    """Linear scene values of HLG codes (ITU-R BT.2100); diffuse white is mapped to 1."""
    return _hlg(codes) / _hlg(np.array(_HLG_WHITE))


def _hlg(codes: Reals) -> Reals:
    """Inverse of the camera curve of HLG, with the value 1 at code 1."""
    a, b, c = 0.17883277, 0.28466892, 0.55991073
    # Limit the codes, because the exponential overflows far above code 1.
    bright = np.exp((np.minimum(codes, 2) - c) / a) + b
    return np.where(codes <= 0.5, codes**2 / 3, bright / 12)


class Interpolation:
    """Piecewise linear curve through equidistant values."""

    def __init__(self, values: Reals) -> None:
        self.values: Reals = np.asarray(values, np.float64)
        self._codes = np.linspace(0, 1, len(self.values))
        self._exponent = _exponent_at_end(self._codes, self.values)

    def __call__(self, codes: Reals) -> Reals:
        """Linear values of codes; a power law extrapolates the end of the curve."""
        codes = np.asarray(codes, np.float64)
        size = np.abs(codes)
        inside = np.interp(size, self._codes, self.values)
        beyond = np.maximum(size, 1) ** self._exponent
        return np.asarray(np.copysign(inside * beyond, codes))


def _exponent_at_end(codes: Reals, values: Reals) -> float:
    """Exponent of the power law through the last value and one slightly before it."""
    before, end = np.interp([1 - _TAIL, 1], codes, values)
    if before <= 0 or end <= before:
        return 0.0
    return float(min(np.log(end / before) / -np.log(1 - _TAIL), _MOST_EXPONENT))


class PerChannel:
    """Curves of red, green and blue; the last axis of the codes is the channel."""

    def __init__(self, curves: tuple[Curve, Curve, Curve]) -> None:
        self.curves = curves

    def __call__(self, codes: Reals) -> Reals:
        """Linear values of codes, (..., 3); a single grey channel uses the curve of green."""
        codes = np.asarray(codes, np.float64)
        if codes.shape[-1] == 1:
            return self.curves[1](codes)
        return np.stack([curve(codes[..., c]) for c, curve in enumerate(self.curves)], axis=-1)


def narrow_range(curve: Curve, bits: int) -> Curve:
    """Curve of codes with black at 16/256 and white at 235/256, as in video."""
    largest, step = (1 << bits) - 1, 1 << (bits - 8)
    return lambda codes: curve((np.asarray(codes) * largest - 16 * step) / (219 * step))


def is_linear(curve: Curve) -> bool:
    """True if the curve is the identity, up to the rounding of 16 bits."""
    codes = np.linspace(0, 1, 1025)
    return bool(np.abs(curve(codes) - codes).max() < 2**-15)


def is_srgb(curve: Curve) -> bool:
    """True if the curve is sRGB, up to half an 8-bit code."""
    codes = np.linspace(0, 1, 1025)
    return bool(np.abs(encode_srgb(curve(codes)) - codes).max() < _SRGB_TOLERANCE)
