"""Matrices from the primaries of a file to linear Rec.709.

RGB to XYZ is the derivation of SMPTE RP 177. The white of the file becomes D65 by Bradford's
chromatic adaptation, so grey remains grey.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray

#: x and y of red, green, blue and the white point, in the order of OpenEXR.
Chromaticities = tuple[float, float, float, float, float, float, float, float]

_D65 = (0.3127, 0.3290)
#: White points of digital cinema projectors and of ACES.
_DCI, _D60 = (0.314, 0.351), (0.32168, 0.33767)

REC709: Chromaticities = (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, *_D65)
DISPLAY_P3: Chromaticities = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, *_D65)
DCI_P3: Chromaticities = (0.680, 0.320, 0.265, 0.690, 0.150, 0.060, *_DCI)
ADOBE_RGB: Chromaticities = (0.64, 0.33, 0.21, 0.71, 0.15, 0.06, *_D65)
REC2020: Chromaticities = (0.708, 0.292, 0.170, 0.797, 0.131, 0.046, *_D65)
ACES_AP0: Chromaticities = (0.7347, 0.2653, 0.0, 1.0, 0.0001, -0.0770, *_D60)
ACES_AP1: Chromaticities = (0.713, 0.293, 0.165, 0.830, 0.128, 0.044, *_D60)
#: ROMM RGB (ISO 22028-2), with the white point D50.
PROPHOTO: Chromaticities = (0.7347, 0.2653, 0.1596, 0.8404, 0.0366, 0.0001, 0.3457, 0.3585)

#: Default primaries of Radiance, which image libraries write into every file, whatever its pixels.
_RADIANCE = (0.640, 0.330, 0.290, 0.600, 0.150, 0.060, 0.333, 0.333)

#: Chromaticities this close to Rec.709 count as Rec.709.
_TOLERANCE = 1e-3
#: Largest difference from the identity matrix that counts as a rounded sRGB profile. The next
#: primaries in use, those of European television, differ by 0.04.
_MATRIX_TOLERANCE = 5e-3
#: Smallest area of the triangle of primaries; that of Rec.709 is 0.11.
_LEAST_AREA = 1e-4
#: Smallest determinant of the XYZ matrix of primaries; that of Rec.709 is 0.2.
_LEAST_DETERMINANT = 1e-6

_BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)


def are_unsaid(chromaticities: Sequence[float]) -> bool:
    """True for zeros, and for the default primaries that libraries write into Radiance files."""
    values = np.asarray(chromaticities, float)
    is_default = values.shape == (8,) and np.allclose(values, _RADIANCE, rtol=0, atol=_TOLERANCE)
    return not values.any() or bool(is_default)


def to_rec709(chromaticities: Sequence[float]) -> NDArray[np.float64] | None:
    """Matrix from linear RGB of these primaries to linear Rec.709; None for Rec.709 itself.

    Raises
    ------
    ValueError
        If no colours can have these primaries.
    """
    values = np.asarray(chromaticities, float)
    if values.shape == (8,) and np.allclose(values, REC709, rtol=0, atol=_TOLERANCE):
        return None
    return _from_xyz(_to_xyz(values))


def columns_to_rec709(columns: ArrayLike) -> NDArray[np.float64] | None:
    """Matrix from RGB to linear Rec.709, by the XYZ of the primaries, (3, 3); None near Rec.709.

    Their sum is white, whose luminance becomes 1.

    Raises
    ------
    ValueError
        If no colours can have these primaries.
    """
    values = np.asarray(columns, float)
    white = values.sum(axis=1)
    if not np.isfinite(values).all() or white[1] <= 0:
        raise ValueError("its primaries have no white")
    matrix = _from_xyz(values / white[1])
    return None if np.allclose(matrix, np.eye(3), rtol=0, atol=_MATRIX_TOLERANCE) else matrix


def xyz_to_rec709() -> NDArray[np.float64]:
    """Matrix from CIE XYZ to linear Rec.709, without adaptation of the white point."""
    return np.asarray(np.linalg.inv(_to_xyz(np.array(REC709))), np.float64)


def _from_xyz(columns: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix from RGB to linear Rec.709, by the XYZ of the primaries."""
    if abs(np.linalg.det(columns)) < _LEAST_DETERMINANT:
        raise ValueError("its primaries lie on a line")
    rec709 = _to_xyz(np.array(REC709))
    seen, wanted = (_BRADFORD @ matrix.sum(axis=1) for matrix in (columns, rec709))
    if min(seen) <= 0:
        raise ValueError("its white is impossible")
    adaptation = np.linalg.solve(_BRADFORD, np.diag(wanted / seen) @ _BRADFORD)
    return np.asarray(np.linalg.solve(rec709, adaptation @ columns))


def _to_xyz(chromaticities: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix from linear RGB to XYZ, in which white has the luminance 1."""
    if chromaticities.shape != (8,) or not np.isfinite(chromaticities).all():
        raise ValueError("they must be eight finite numbers")
    x, y = chromaticities.reshape(4, 2).T
    area = abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / 2
    if area < _LEAST_AREA:
        raise ValueError("they lie on a line")
    if y[3] < _TOLERANCE:
        raise ValueError("their white has no luminance")
    # Scale the primaries, as (x, y, z), so that their sum is white.
    points = np.array([x, y, 1 - x - y])
    gains = np.linalg.solve(points[:, :3], points[:, 3] / y[3])
    if min(gains) <= 0:
        raise ValueError("their white lies outside their triangle")
    return np.asarray(points[:, :3] * gains)
