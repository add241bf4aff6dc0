"""Lights as arrays of any library, with conversion from and to rigs."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from envlights._common.units import OWN_SCALE
from envlights._native import EnvLightsError
from envlights.batches.labels import LabelArrays
from envlights.environment.reading import AnyMap, as_envmap
from envlights.layers.arrays import Array, constant, namespace, to_numpy
from envlights.rigs.lights import Lights as Discs
from envlights.rigs.rig import Rig


class Lights(NamedTuple):
    """Lights as arrays of NumPy, JAX, torch or CuPy, with any leading batch axes.

    It is a tuple, so `jax.grad`, `jax.vmap` and the loaders of torch accept it. Shapes are checked,
    but not values, because compiled code cannot refuse any.

    Examples
    --------
    >>> arrays = [[0.0, 2.0, 0.0]], [[1.0, 1.0, 1.0]], [0.1], [0.2, 0.2, 0.2]
    >>> Lights(*map(np.array, arrays)).rig().probe([0, 1, 0]).round(3)
    array([1.628, 1.628, 1.628])
    """

    direction: Array
    """Vectors to the lights, of any length above 0, (..., n, 3): right-handed, +y up."""
    irradiance: Array
    """Linear RGB at normal incidence, (..., n, 3)."""
    angular_radius: Array
    """Radians from 0 to pi / 2, (..., n); 0 is a point."""
    ambient: Array
    """Radiance of the ambient term, (..., 3), or its harmonics as in `Rig.ambient`, (..., 9, 3)."""
    mask: Array | None = None
    """Nonzero for valid lights, (..., n), if rigs differ in length; None if all are valid."""

    @classmethod
    def of(cls, rig: Rig) -> Lights:
        """Lights of a rig as float64 NumPy arrays; over a floor, the half sky becomes a light."""
        direction, radius = rig.lights.direction, rig.lights.angular_radius
        light, ambient = rig.lights.irradiance, rig.ambient
        if rig.floor:
            direction = np.vstack([direction, [[0.0, 1.0, 0.0]]])
            light, radius = np.vstack([light, np.pi * ambient]), np.append(radius, np.pi / 2)
            ambient = np.zeros(3)
        return cls(*map(np.array, (direction, light, radius, ambient)))

    @classmethod
    def of_labels(cls, labels: LabelArrays) -> Lights:
        """Lights of `el.batches.label_arrays`: a batch in float32, with a mask."""
        is_constant = not labels.ambient_harmonics[:, 1:].any()
        ambient = labels.ambient if is_constant else labels.ambient_harmonics
        mask = labels.mask.astype(np.float32)
        return cls(labels.direction, labels.irradiance, labels.angular_radius, ambient, mask)

    def row(self, index: int) -> Lights:
        """Lights in a row of a batch."""
        return Lights(*(each if each is None else each[index] for each in self))

    def rig(self, env: AnyMap | None = None) -> Rig:
        """Rig from a row, for example of a prediction, without masked lights.

        `env` is the map on which the rig is measured, and whose units it has; by default none, and
        its error is None.
        An `EnvLightsError` names values that no rig can have.
        """
        _, lights = check_lights(self)
        if lights.angular_radius.ndim > 1:
            raise EnvLightsError("rig needs one row of a batch: lights.row(0).rig()")
        rows = slice(None) if self.mask is None else to_numpy(self.mask) != 0
        arrays = (to_numpy(each).astype(np.float64)[rows] for each in lights[:3])
        direction, light, radius = arrays
        length = np.linalg.norm(direction, axis=1, keepdims=True)
        direction /= np.where(length > 0, length, 1)
        env = None if env is None else as_envmap(env)
        discs = Discs(direction, light, radius, units=OWN_SCALE if env is None else env.units)
        return Rig.of(to_numpy(lights.ambient).astype(np.float64), discs, env)


def check_lights(lights: Lights) -> tuple[Any, Lights]:
    """Array namespace, and the lights with unit directions and masked ones set to black."""
    if not isinstance(lights, Lights):
        raise EnvLightsError(f"lights must be el.layers.Lights; got {type(lights).__name__}")
    xp = namespace(*(each for each in lights if each is not None))
    shape = tuple(lights.angular_radius.shape)
    ambient = ((*shape[:-1], 3), (*shape[:-1], 9, 3))
    wanted = (((*shape, 3),), ((*shape, 3),), (shape,), ambient, (shape,))
    for name, each, shapes in zip(Lights._fields, lights, wanted, strict=True):
        if each is not None and tuple(each.shape) not in shapes:
            raise EnvLightsError(
                f"{name} must have the shape {' or '.join(map(str, shapes))} beside angular_radius"
                f" with {shape}; got {tuple(each.shape)}"
            )
    direction, light, radius, ambient = floating(xp, *lights[:4])
    if lights.mask is not None:
        light = xp.where((lights.mask != 0)[..., None], light, constant(0.0, light))
    return xp, Lights(unit(xp, direction), light, radius, ambient)


def floating(xp: Any, *arrays: Array) -> list[Array]:
    """Arrays of floats: integers become floats as in the first array that has them."""
    types = [each.dtype for each in arrays if xp.isdtype(each.dtype, "real floating")]
    number = types[0] if types else xp.asarray(0.0).dtype
    return [each if each.dtype in types else xp.astype(each, number) for each in arrays]


def unit(xp: Any, vectors: Array) -> Array:
    """Normalised vectors; zero vectors stay zero."""
    square = xp.sum(vectors * vectors, axis=-1, keepdims=True)
    return vectors / xp.sqrt(xp.where(square > 0, square, 1.0))


def nine_coefficients(lights: Lights) -> Array:
    """Ambient term as nine harmonics, (..., 9, 3), or only the first, (..., 1, 3)."""
    if lights.ambient.ndim == lights.direction.ndim:
        return lights.ambient
    return lights.ambient[..., None, :] * (4 * np.pi) ** 0.5


def spread_and_flux(xp: Any, lights: Lights) -> tuple[Array, Array]:
    """Extent sin^2(a/2) and integral of the radiance of each disc with radius a."""
    spread = xp.sin(lights.angular_radius / 2) ** 2
    return spread, lights.irradiance / (1 - spread)[..., None]
