"""Rendering of shapes in front of a background.

Each light is summed from the pixels of the stored map, so the lights of a `SyntheticMap` are exact
for its map.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common import html
from envlights._common.arrays import convert
from envlights._common.blocks import blocks, in_blocks
from envlights._common.check import count, is_vector, reals
from envlights._common.result import Result
from envlights._native import EnvLightsError
from envlights.kernels import sphere, thumbnails
from envlights.rigs.lights import Lights, brightest_first
from envlights.synthetic.shapes import Shape

#: Largest number of rows; NumPy cannot index much larger maps.
MOST_ROWS = 2**20
#: Function from linear radiance to stored radiance, (height, width, 3) -> (height, width, 3).
Camera = Callable[[NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True, eq=False, repr=False)
class SyntheticMap(Result):
    """Map with exactly known lights."""

    radiance: NDArray[np.float32]
    """Linear RGB, (height, 2 * height, 3)."""

    lights: Lights
    """Direction of each light's flux, and its irradiance above the background; brightest first."""

    solid_angle: NDArray[np.float64]
    """Solid angle of each light in steradians, in the order of `lights`."""

    irradiance_with_background: NDArray[np.float64]
    """RGB integral of the map over the solid angle of each light, as a detector measures it."""

    note: str = ""
    """Description of the map."""

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Radiance as an array, for NumPy."""
        return convert(self.radiance, dtype, copy)

    def in_short(self) -> str:
        """Size, number of lights and description."""
        height, width, _ = self.radiance.shape
        note = f"; {self.note}" if self.note else ""
        return f"{width}x{height} pixels, {self.lights.in_short()}{note}"

    def _html_parts(self) -> tuple[str, ...]:
        picture = html.picture(thumbnails.of_map(self.radiance), "the map")
        return picture, self.lights.table().html()

    @property
    def angular_radius_deg(self) -> NDArray[np.float64]:
        """Angular radius of a disc as large as each light, in degrees."""
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
    """Render shapes on a background.

    Parameters
    ----------
    height : int
        Rows; the map is twice as wide.
    background : array_like, shape (3,) or (height, 2 * height, 3)
        Radiance behind the shapes.
    shapes : sequence of Disc, Rectangle or PixelSun
        Lights. Where they overlap, the last one is in front.
    camera : callable, optional
        Exposure, noise and clipping of the stored radiance. It must be monotonic, because it is
        called for the background alone as well, and the difference is the light of the shapes.
        By default all radiance is stored as it is.
    note : str
        Description of the map.

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
    height = count("height", height, least=2, most=MOST_ROWS)
    map_shape = (height, 2 * height, 3)
    backdrop = _radiance("background", background, map_shape)
    # Compute the fraction of each pixel that shows each shape, behind the shapes in front.
    shown: list[NDArray[np.float64]] = []
    for shape in shapes:
        covered = shape.coverage(height)[..., None]
        shown = [_behind(other, covered) for other in shown] + [covered]
    colours = [_radiance("radiance", shape.radiance, (3,)) for shape in shapes]
    return _measure(backdrop, [*zip(shown, colours, strict=True)], camera or _keep_all, note)


def normal_numbers(rng: np.random.Generator, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """Numbers of `rng.standard_normal`, drawn in blocks."""
    numbers = np.empty(shape)
    for part in blocks((numbers.size,)):
        rng.standard_normal(out=numbers.reshape(-1)[part])
    return numbers


def _keep_all(radiance: NDArray[np.float64]) -> NDArray[np.float64]:
    return radiance


def _measure(
    backdrop: NDArray[np.float64],
    shown: list[_Shown],
    camera: Camera,
    note: str,
) -> SyntheticMap:
    """The map as stored, and its lights summed over the pixels that show them."""
    # Replace the fraction of the background that shows a shape.
    whole = in_blocks(backdrop.shape, lambda rows: _add(backdrop, shown, rows))
    # Store the map with and without its lights.
    lit = in_blocks(backdrop.shape, lambda rows: backdrop[rows] + whole[rows])
    picture = _Picture(_in_floats(camera(lit)), camera(backdrop), backdrop, whole)
    # Sum each light over its pixels.
    direction, irradiance, with_background, solid_angle = np.zeros((4, len(shown), 3))
    for i, each in enumerate(shown):
        direction[i], irradiance[i], with_background[i], solid_angle[i] = picture.light(i, *each)
    # Sort as `Lights` does; shapes may share a direction, which therefore does not identify them.
    order = brightest_first(irradiance)
    lights = Lights(direction, irradiance)
    return SyntheticMap(picture.stored, lights, solid_angle[order, 0], with_background[order], note)


def _in_floats(radiance: NDArray[np.float64]) -> NDArray[np.float32]:
    return in_blocks(radiance.shape, lambda rows: radiance[rows].astype(np.float32))


#: Fraction of each pixel that shows a shape, (height, width, 1), and the shape's radiance.
_Shown = tuple[NDArray[np.float64], NDArray[np.float64]]


def _behind(fraction: NDArray[np.float64], covered: NDArray[np.float64]) -> NDArray[np.float64]:
    """Visible fraction of a shape behind other shapes with coverage `covered`."""
    return in_blocks(fraction.shape, lambda rows: fraction[rows] * (1 - covered[rows]))


def _add(backdrop: NDArray[np.float64], shown: list[_Shown], rows: slice) -> NDArray[np.float64]:
    """Radiance that shapes add to some rows of a background."""
    behind = backdrop[rows]
    added = [fraction[rows] * (colour - behind) for fraction, colour in shown]
    whole: NDArray[np.float64] = np.sum(added, axis=0) if added else np.zeros_like(behind)
    return whole


@dataclass(frozen=True, eq=False)
class _Picture:
    """A map as stored.

    Each light owns what it adds to a stored pixel, and its share of the stored background. A pixel
    that shows two lights is divided between them, so no flux counts twice.
    """

    stored: NDArray[np.float32]
    """Map as stored, (height, width, 3)."""

    behind: NDArray[np.float64]
    """Map without lights, as stored."""

    backdrop: NDArray[np.float64]
    """Map without lights, before the camera response."""

    whole: NDArray[np.float64]
    """Radiance of all shapes, before the camera response."""

    @cached_property
    def solid_angles(self) -> NDArray[np.float64]:
        """Solid angle of each pixel, (height, width, 1)."""
        height, width, _ = self.stored.shape
        return sphere.pixel_solid_angles(height, width)[..., None]

    def light(
        self, i: int, fraction: NDArray[np.float64], colour: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64], float]:
        """Direction, irradiance, irradiance with background, and solid angle of shape `i`.

        `fraction` of each pixel shows it.
        """
        # Find the pixels of the shape; hidden shapes keep a rounding error of their coverage.
        at = (fraction[..., 0] > 1e-9).nonzero()
        height, width, _ = self.stored.shape
        v, u = ((place + 0.5) / side for place, side in zip(at, (height, width), strict=True))
        solid_angles, directions = self.solid_angles[at], sphere.uv_to_direction(np.c_[u, v])
        own = fraction[at] * (colour - self.backdrop[at])
        # Divide the stored light between shapes in proportion to their radiance.
        whole = self.whole[at]
        part = np.divide(own, whole, out=np.zeros((len(at[0]), 3)), where=whole != 0)
        flux = (self.stored[at] - self.behind[at]) * part * solid_angles
        if not flux.any():
            raise EnvLightsError(
                f"shape {i} adds no light to the map; it must be in front, brighter than the"
                f" background, and large enough for maps {len(self.stored)} pixels high"
            )
        # Sum the flux, its centroid, and the background behind it.
        centroid = (flux.sum(axis=1, keepdims=True) * directions).sum(axis=0)
        irradiance = flux.sum(axis=0)
        owned = fraction[at] * solid_angles
        background = (self.behind[at] * owned).sum(axis=0)
        direction = centroid / np.linalg.norm(centroid)
        return direction, irradiance, irradiance + background, owned.sum()


def _radiance(name: str, values: ArrayLike, shape: tuple[int, ...]) -> NDArray[np.float64]:
    """`values` as RGB radiance of `shape`; raises an error that names the argument."""
    array = reals(name, values, 1 if is_vector(values) else len(shape))
    if array.shape not in ((3,), shape) or not np.isfinite(array).all() or (array < 0).any():
        raise EnvLightsError(
            f"{name} must be finite RGB, not negative, of the shape {shape};"
            f" got the shape {array.shape}"
        )
    return np.broadcast_to(array, shape)
