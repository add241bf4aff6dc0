"""Labels for training: lights of many maps as arrays of one size, with a mask."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count, describe, named_arguments
from envlights._common.result import Result
from envlights._common.words import percent
from envlights._native import EnvLightsError
from envlights.batches.result import Batch
from envlights.batches.rows import row_of
from envlights.kernels.ambient import as_harmonics
from envlights.kernels.image import LUMINANCE
from envlights.rigs.lights import Lights
from envlights.rigs.lobes import SphericalGaussians, lobes
from envlights.rigs.rig import Rig


@dataclass(frozen=True, eq=False, repr=False)
class LabelArrays(Result):
    """Lights of n maps in k slots each, float32; empty slots are 0."""

    names: tuple[str, ...]
    """Name of each map; empty text if unnamed."""

    mask: NDArray[np.bool_]
    """True for slots with a light, (n, k)."""

    direction: NDArray[np.float32]
    """Unit vectors to the lights: right-handed, +y up, (n, k, 3)."""

    irradiance: NDArray[np.float32]
    """Linear RGB at normal incidence, (n, k, 3)."""

    angular_radius: NDArray[np.float32]
    """Radians, (n, k); 0 is a point."""

    sharpness: NDArray[np.float32]
    """Sharpness of each light as a spherical Gaussian, (n, k)."""

    amplitude: NDArray[np.float32]
    """Radiance along the axis of the spherical Gaussian, linear RGB, (n, k, 3)."""

    ambient: NDArray[np.float32]
    """Mean radiance of the ambient term, linear RGB, (n, 3).

    For a rig above a floor, the radiance of the half sky, which is twice its mean. For lights of
    `detect` or `split`, that of the map without them; 0 for lights without either."""

    ambient_harmonics: NDArray[np.float32]
    """Ambient term in the harmonics of `Rig.ambient`, (n, 9, 3); if constant, only the first is not
    0, and above a floor, the first two.
    """

    left_out: NDArray[np.float32]
    """Fraction of the luminance in lights without a slot, (n,)."""

    @property
    def solid_angle(self) -> NDArray[np.float32]:
        """Solid angle of each disc in steradians, (n, k)."""
        return (4 * np.pi * np.sin(self.angular_radius / 2) ** 2).astype(np.float32)

    def __len__(self) -> int:
        return len(self.mask)

    def in_short(self) -> str:
        """Number of maps, slots and lights."""
        return f"{len(self)} maps with {self.mask.shape[1]} slots, {self.mask.sum()} lights"

    def __str__(self) -> str:
        most = self.left_out.max(initial=0)
        return f"{self.in_short()}; at most {percent(most)} of the lights of a map left out"

    def to_dict(self) -> dict[str, Any]:
        """All arrays, by name."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__}


@named_arguments()
def label_arrays(labels: Batch | Iterable[Rig | Lights], lights: int) -> LabelArrays:
    r"""Lights of many maps as arrays of equal size, to train networks.

    Parameters
    ----------
    labels : Batch or iterable of Rig or Lights
        Maps that failed are left out.
    lights : int
        Number of slots for the lights of each map, k. Brighter lights come first; those beyond the
        slots are left out, and `left_out` has their fraction.

    Returns
    -------
    LabelArrays
        A row for each map.

    Raises
    ------
    EnvLightsError
        If `labels` hold no lights, or `lights` is not a count of at least 1.

    Notes
    -----
    Direction, solid angle, colour and ambient term are the parameters of Gardner et al. (2019),
    "Deep Parametric Indoor Lighting Estimation", without the distance, which a map does not hold. A
    disc of irradiance E has the radiance :math:`E / (\pi \sin^2 a)`. Spherical Gaussians are those
    of `Lights.spherical_gaussians`. `Lights.to_map` draws labels as pictures.

    Examples
    --------
    >>> import envlights as el
    >>> rigs = [el.fit(el.synthetic.plain(seed, 128).radiance, lights=2) for seed in range(3)]
    >>> arrays = el.batches.label_arrays(rigs, lights=4)
    >>> arrays.direction.shape, arrays.mask[0]
    ((3, 4, 3), array([ True,  True, False, False]))
    """
    places = count("lights", lights, least=1, most=1024)
    rows = [row for row in _rows(labels) if not row.get("failure")]
    if any("lights" not in row for row in rows):
        raise EnvLightsError("labels must hold lights: fit, detect or split the maps of the batch")
    n = len(rows)
    mask, harmonics = np.zeros((n, places), bool), np.zeros((n, 9, 3))
    direction, irradiance = np.zeros((2, n, places, 3))
    radius, left_out, ambient = np.zeros((n, places)), np.zeros(n), np.zeros((n, 3))
    for number, row in enumerate(rows):
        every = np.array([light["irradiance"] for light in row["lights"]]).reshape(-1, 3)
        kept = row["lights"][:places]
        mask[number, : len(kept)] = True
        for place, light in enumerate(kept):
            direction[number, place] = light["direction"]
            irradiance[number, place] = light["irradiance"]
            radius[number, place] = light["angular_radius"]
        luminance = every @ LUMINANCE
        left_out[number] = luminance[places:].sum() / (luminance.sum() or 1.0)
        ambient[number] = row.get("ambient") or (0, 0, 0)
        harmonics[number] = row.get("ambient_harmonics") or as_harmonics(ambient[number])
    gaussians = _gaussians(mask, direction, irradiance, radius)
    arrays = (direction, irradiance, radius, *gaussians, ambient, harmonics, left_out)
    names = tuple(row.get("name", "") for row in rows)
    return LabelArrays(names, mask, *(array.astype(np.float32) for array in arrays))


def _rows(labels: Any) -> Iterable[dict[str, Any]]:
    if isinstance(labels, Batch):
        return labels.rows()
    if isinstance(labels, Lights) or not isinstance(labels, Iterable):
        raise EnvLightsError(
            f"labels must be a batch, or several rigs or lights; got {describe(labels)}"
        )
    return map(_row, labels)


def _row(label: object) -> dict[str, Any]:
    if not isinstance(label, Rig | Lights):
        raise EnvLightsError(f"labels must be rigs or lights; got {describe(label)}")
    return row_of(label)


def _gaussians(
    mask: NDArray[np.bool_],
    direction: NDArray[np.float64],
    irradiance: NDArray[np.float64],
    radius: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sharpness and amplitude of each light, 0 in empty slots."""
    found: SphericalGaussians = lobes(
        direction[mask], irradiance[mask], np.minimum(radius[mask], np.pi / 2)
    )
    sharpness, amplitude = np.zeros(mask.shape), np.zeros((*mask.shape, 3))
    sharpness[mask], amplitude[mask] = found.sharpness, found.amplitude
    return sharpness, amplitude
