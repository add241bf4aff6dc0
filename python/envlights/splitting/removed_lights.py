"""Lights that were removed from a map."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.check import rotation
from envlights._common.words import percent
from envlights.detection.lights import DetectedLights
from envlights.export.formats.own_json import LIGHTS_HEADER
from envlights.rigs.lights import Lights

#: Smallest `off_axis` that is printed.
_PRINTED = 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class RemovedLights(DetectedLights):
    r"""Lights that `split` has removed from a map, brightest first.

    `irradiance` is that at normal incidence, :math:`|\int T \omega\, d\omega|` for the removed
    radiance :math:`T`. `direction`, `solid_angle` and `flux_fraction` also belong to T. The
    remaining measurements come from `detect`.

    Examples
    --------
    >>> import envlights as el
    >>> lamp = el.synthetic.Disc((0, 1, 0), 5.0, (9, 6, 3))
    >>> world = el.synthetic.scene(128, background=[0.1] * 3, shapes=[lamp])
    >>> lights, rest = el.split(world.radiance)
    >>> np.allclose(lights.irradiance[0] / lights.irradiance[0, 0], [1, 5.9 / 8.9, 2.9 / 8.9])
    True
    """

    vector_irradiance: NDArray[np.float64] = None  # type: ignore[assignment]
    r""":math:`\int T \omega\, d\omega` of each channel, shape (n, 3 channels, 3 axes)."""

    reach: NDArray[np.float64] = None  # type: ignore[assignment]
    """Angle in radians from each direction to the farthest removed radiance, shape (n,).

    A surface faces all of a light if its normal is less than pi / 2 - reach from the direction."""

    @property
    def off_axis(self) -> NDArray[np.float64]:
        """Fraction of each channel's vector irradiance orthogonal to the direction, (n, 3).

        A light has one direction, that of its luminance. In a channel with another direction, as in
        a window that is blue above and green below, the rest and the lights together differ from
        the map by at most this fraction of the light.
        """
        lengths = np.linalg.norm(self.vector_irradiance, axis=2)
        across = np.cross(self.vector_irradiance, self.direction[:, None])
        shares: NDArray[np.float64] = np.linalg.norm(across, axis=2) / np.maximum(
            lengths, np.finfo(float).tiny
        )
        return shares

    def rotated(self, matrix: ArrayLike) -> RemovedLights:
        """Lights after a rotation; members and report still refer to the map before it."""
        vectors = self.vector_irradiance @ rotation(matrix).T
        return replace(super().rotated(matrix), vector_irradiance=vectors)

    def to_dict(self) -> dict[str, Any]:
        """All fields except the times as plain numbers, lists and strings."""
        # Write the file format of `Lights`; the origin is for `Split.with_lights`.
        return {**super().to_dict(), **LIGHTS_HEADER, "origin": list(self.origin or ())}

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Lights:  # type: ignore[override]
        """Read the direction, irradiance and size of removed lights that `save` wrote."""
        return Lights.load(path)

    def _remarks(self, row: int) -> str:
        remarks = super()._remarks(row)
        most = self.off_axis[row].max()
        if most <= _PRINTED:
            return remarks
        return f"{remarks}  uneven colour ({percent(most, 2)})".strip()
