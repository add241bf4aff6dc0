"""Shapes before a background.

What a shape adds to the map is summed from its own pixels, so the lights of a `SyntheticMap` are
exact for the map as rendered.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import kernels
from envlights._check import count, reals
from envlights._native import EnvLightsError
from envlights.kernels.image import LUMINANCE
from envlights.lights import Lights
from envlights.synthetic.shapes import Shape

#: What a file keeps of linear radiance, (height, width, 3) -> (height, width, 3).
Camera = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False)
class SyntheticMap:
    """A map and the lights in it."""

    radiance: NDArray[np.float32]
    """Linear RGB, (height, 2 * height, 3)."""

    lights: Lights
    """Direction of each light's flux, and its irradiance above the background; brightest first."""

    solid_angle: NDArray[np.float64]
    """Of each light in steradians, in the order of `lights`."""

    irradiance_with_background: NDArray[np.float64]
    """RGB, all of the map's radiance over each light's solid angle: what detectors measure."""

    note: str = ""
    """What is to be seen, in words."""

    @property
    def angular_radius_deg(self) -> NDArray[np.float64]:
        """Of a disc as large as each light."""
        cosine = np.clip(1 - self.solid_angle / (2 * np.pi), -1, 1)
        radius: NDArray[np.float64] = np.rad2deg(np.arccos(cosine))
        return radius


def scene(
    height: int,
    *,
    background: ArrayLike = (0.0, 0.0, 0.0),
    shapes: Sequence[Shape] = (),
    camera: Camera | None = None,
    note: str = "",
) -> SyntheticMap:
    """Shapes before a background.

    Parameters
    ----------
    height : int
        Rows; the map is twice as wide.
    background : array_like, shape (3,) or (height, 2 * height, 3)
        Radiance behind the shapes.
    shapes : sequence of Disc, Rectangle or PixelSun
        Lights. Where they overlap, the last one is in front.
    camera : callable, optional
        What the file keeps of the radiance: exposure, noise, clipping. Brighter in must not be
        darker out, for it is asked for the background alone as well, and the difference is what
        the lights add. Left out: everything.
    note : str
        Kept with the map.

    Returns
    -------
    SyntheticMap

    Examples
    --------
    A disc of 5 degrees has the solid angle 2 pi (1 - cos 5 deg):

    >>> from envlights.synthetic import Disc
    >>> lamp = scene(256, shapes=[Disc((1, 0, 0), 5.0, (2, 2, 2))])
    >>> float(lamp.solid_angle[0].round(3)), float((2 * np.pi * (1 - np.cos(np.pi / 36))).round(3))
    (0.024, 0.024)
    """
    height = count("height", height, least=2)
    map_shape = (height, 2 * height, 3)
    backdrop = _radiance("background", background, map_shape)
    # Share of every pixel that shows each shape, after those in front of it.
    shown: list[NDArray[np.float64]] = []
    for shape in shapes:
        covered = shape.coverage(height)[..., None]
        shown = [other * (1 - covered) for other in shown] + [covered]
    added = [
        share * (_radiance("radiance", shape.radiance, (3,)) - backdrop)
        for shape, share in zip(shapes, shown, strict=True)
    ]
    return _measured(backdrop, shown, added, camera or _keep_all, note)


def _keep_all(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
    return radiance


def _measured(
    backdrop: NDArray[np.float64],
    shown: list[NDArray[np.float64]],
    added: list[NDArray[np.float64]],
    camera: Camera,
    note: str,
) -> SyntheticMap:
    """The map as stored, and its lights summed over the pixels that they show in.

    Each light owns what it adds to a stored pixel, and its share of the stored background. A pixel
    that shows two lights is divided between them, so no flux counts twice.
    """
    height, width, _ = backdrop.shape
    whole = np.sum(added, axis=0) if added else np.zeros_like(backdrop)
    stored, behind = camera(backdrop + whole).astype(np.float32), camera(backdrop)
    solid_angles = kernels.pixel_solid_angles(height, width)[..., None]
    directions = kernels.pixel_directions(height, width)
    direction, irradiance, with_background, solid_angle = np.zeros((4, len(shown), 3))
    for i, share in enumerate(shown):
        # A shape wholly behind another keeps a rounding error of its coverage.
        lit = (share[..., 0] > 1e-9).nonzero()
        part = np.divide(
            added[i][lit], whole[lit], out=np.zeros((len(lit[0]), 3)), where=whole[lit] != 0
        )
        flux = (stored[lit] - behind[lit]) * part * solid_angles[lit]
        if not flux.any():
            raise EnvLightsError(
                f"shape {i} adds no light to the map; it must be in front, brighter than the"
                f" background, and large enough for maps {height} pixels high"
            )
        centroid = (flux.sum(axis=1, keepdims=True) * directions[lit]).sum(axis=0)
        direction[i] = centroid / np.linalg.norm(centroid)
        irradiance[i] = flux.sum(axis=0)
        owned = share[lit] * solid_angles[lit]
        with_background[i] = irradiance[i] + (behind[lit] * owned).sum(axis=0)
        solid_angle[i] = owned.sum()
    # The order of `Lights`: shapes may share a direction, so it cannot be found by looking.
    order = np.argsort(-(irradiance @ LUMINANCE), kind="stable")
    lights = Lights(direction, irradiance)
    return SyntheticMap(stored, lights, solid_angle[order, 0], with_background[order], note)


def _radiance(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """`values` as an RGB radiance of `shape`, or a refusal that names it."""
    array = reals(name, values, np.ndim(values))
    if array.shape not in ((3,), shape) or not np.isfinite(array).all() or (array < 0).any():
        raise EnvLightsError(
            f"{name} must be finite RGB, not negative, of the shape {shape};"
            f" got the shape {array.shape}"
        )
    return np.broadcast_to(array, shape)
