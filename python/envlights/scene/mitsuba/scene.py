"""A Mitsuba scene under the light of rigs."""

from __future__ import annotations

import os
from functools import cached_property
from math import ceil, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._common.check import count
from envlights._native import EnvLightsError
from envlights.scene.direct import AnyLights, DirectLight, as_rig
from envlights.scene.gather import DIRECT, RAYS, check_blocks, gather
from envlights.scene.mitsuba.chart_rays import charts, mitsuba_hits, texel_hits
from envlights.scene.mitsuba.emitters import emitters
from envlights.scene.mitsuba.path_traced import Still
from envlights.scene.mitsuba.renderer import film, in_one_line, mitsuba
from envlights.scene.surface import Surface, tangent_frames
from envlights.scene.triangles import triangles
from envlights.transfer.prior import TransferPrior

#: Points along a side of each of the 16 by 16 texels of the direct image.
_POINTS = 8
#: Rays to the sky from each point. With 16 and with 64 of them, the direct image of the courtyard
#: under an ambient term differed from Mitsuba's by 3 % and 1 %.
_RAYS = 64


class Rendering(NamedTuple):
    """A path-traced image."""

    image: NDArray[np.float32]
    """Radiance of the texels, (H, W, 3)."""

    noise: float
    """Relative standard error: the norm of the noise over the norm of the image."""


class MitsubaScene:
    """The shapes and materials of a Mitsuba scene, under the light of rigs.

    Images hold the radiance that the diffuse part of a material reflects, albedo / pi times
    irradiance. In a diffuse scene, direct and indirect light add up to the visible radiance.

    Mitsuba runs in its variant ``scalar_rgb``. Afterwards your own variant is set again.

    Parameters
    ----------
    scene : dict or path-like
        Argument of ``mitsuba.load_dict``, or the path of an XML file; +y up. Its sensors,
        integrator, environment and point lights are left out, because the rig is the light.
    lightmap : int or Surface
        Columns and rows of a lightmap. It has one square chart for each shape, over the UV
        coordinates of the shape, in the order of the names of shapes. Or a lightmap of your own,
        with a multiple of 16 rows and columns, at whose texels direct light is then measured.

    Raises
    ------
    EnvLightsError
        If Mitsuba is not installed or refuses the scene; if a shape is an area light.

    Examples
    --------
    >>> import envlights as el
    >>> yard = MitsubaScene(el.synthetic.courtyard(), lightmap=32)
    >>> round(float(yard.lightmap.position[..., 1].max()), 4)  # the walls are 3 m high
    2.8125
    >>> rig = el.Rig([0.2, 0.3, 0.5], el.Lights([[0.6, 0.8, 0]], [[3, 3, 2]]), error=0.0)
    >>> yard.indirect(rig, samples=16).image.shape
    (32, 32, 3)
    """

    lightmap: Surface
    """Surface behind each texel of the images of indirect light."""

    points: Surface
    """Points at which direct light is measured.

    There are 8 by 8 for each texel of its image, or the nearest number that your lightmap
    allows."""

    def __init__(
        self, scene: dict[str, Any] | str | os.PathLike[str], lightmap: int | Surface = 128
    ) -> None:
        with mitsuba() as mi:
            # Keep the scene alive, because its meshes refer to it.
            self._loaded = _load(mi, scene)
            self._shapes = _shapes(self._loaded)
            self._has_charts = not isinstance(lightmap, Surface)
            if isinstance(lightmap, Surface):
                self.lightmap, self.points = lightmap, _thin(lightmap)
            else:
                self.lightmap = charts(mi, self._shapes, count("lightmap", lightmap, least=1))
                self.points = charts(mi, self._shapes, DIRECT * _POINTS)
            self._scene = self._under(mi, {})
            self._triangles = triangles(mi, self._shapes)

    def blocked(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Test which rays hit a shape.

        Parameters
        ----------
        origins : ndarray, shape (n, 3)
            In the units of the scene.
        directions : ndarray, shape (n, 3)
            Unit vectors.

        Returns
        -------
        ndarray of bool, shape (n,)
            True for each ray that hits one.
        """
        if self._triangles is not None:
            return self._triangles.hits(origins, directions).shape >= 0
        with mitsuba() as mi:
            # Convert to lists: Mitsuba takes six times as long to read rows of arrays.
            ends = zip(origins.tolist(), directions.tolist(), strict=True)
            hits = (self._scene.ray_test(mi.Ray3f(*each)) for each in ends)
            return np.fromiter(hits, np.bool_, len(origins))

    def gather(
        self, rays: int = RAYS, *, size: int = DIRECT, progress: bool | None = None
    ) -> TransferPrior:
        """Indirect light by the geometry of the scene, from rays alone.

        It takes all surfaces as diffuse, with the albedo of `lightmap`. It predicts without any
        baked pair; `TransferModel.fit` learns the remainder from some.

        Parameters
        ----------
        rays : int
            Rays from each texel of the lightmap.
        size : int
            Texels along a side of the direct images, which divide those of `points`.
        progress : bool, optional
            True: show a progress bar. Default: after a second, in a terminal or a notebook.

        Returns
        -------
        TransferPrior

        Raises
        ------
        EnvLightsError
            If an albedo is 1 or more, or the lightmap is your own: then use `scene.gather` with a
            ray tracer that knows its texels.

        Examples
        --------
        >>> import envlights as el
        >>> yard = el.scene.MitsubaScene(el.synthetic.courtyard(), lightmap=16)
        >>> prior = yard.gather(rays=64)
        >>> (rig,) = el.synthetic.rigs(1)
        >>> prior.predict(yard.direct(rig)).shape
        (16, 16, 3)
        """
        if not self._has_charts:
            raise EnvLightsError(
                "gather needs the charts of the scene, and the lightmap is your own; call"
                " envlights.scene.gather with a ray tracer that knows its texels"
            )
        size, width = count("size", size, least=1), self.points.covered.shape[1]
        with mitsuba() as mi:
            first_hits = (
                mitsuba_hits(mi, self._scene, self._shapes)
                if self._triangles is None
                else self._triangles.hits
            )
            hit = texel_hits(first_hits, len(self._shapes), width, size)
            return gather(self.lightmap, self.points, hit, rays, size=size, progress=progress)

    def direct(self, rig: AnyLights, size: int = DIRECT) -> NDArray[np.float32]:
        """Direct light as a small image, from which a `TransferModel` predicts.

        The first call traces the visible part of the sky. After that, each light takes one shadow
        ray for each point, and 16 if it has a size.

        Parameters
        ----------
        rig : Rig, Lights or DetectedLights
            Lights alone have no ambient term.
        size : int
            Texels along a side of the image. More than 16 help only with the prior of `gather`.

        Returns
        -------
        ndarray, shape (size, size, 3)
            Reflected radiance, linear RGB: the mean over each part of the lightmap. For an image of
            the size of the lightmap use ``DirectLight.of(scene.lightmap, scene.blocked)``.
        """
        check_blocks(self.points, count("size", size, least=1))
        image = self._direct_light.image(rig)
        return self.points.means(image, size).astype(np.float32)

    def indirect(self, rig: AnyLights, samples: int = 256, seed: int = 0) -> Rendering:
        """Indirect light with all bounces, path-traced.

        Parameters
        ----------
        rig : Rig, Lights or DetectedLights
            Lights alone have no ambient term.
        samples : int
            Paths for each texel, rounded up to twice a square number.
        seed : int
            Seed of the paths.

        Returns
        -------
        Rendering
            The image, (H, W, 3), and its noise.
        """
        side = ceil(sqrt(count("samples", samples, least=1) / 2))
        # Trace two halves with independent noise, and estimate the noise from their difference.
        seeds = np.random.SeedSequence(count("seed", seed)).generate_state(2)
        halves = Still(*(self._traced(rig, side * side, int(each)) for each in seeds))
        return Rendering(halves.image.astype(np.float32), halves.noise)

    @cached_property
    def _direct_light(self) -> DirectLight:
        return DirectLight.of(self.points, self.blocked, _RAYS)

    @cached_property
    def _meters(self) -> Meters:
        with mitsuba() as mi:
            return meters(mi, self.lightmap)

    def _traced(self, rig: AnyLights, samples: int, seed: int) -> NDArray[np.float64]:
        """Reflected radiance of the lightmap under the indirect light of a rig."""
        irradiance = np.zeros((np.count_nonzero(self.lightmap.covered), 3))
        with mitsuba() as mi:
            for weight, lights in emitters(as_rig(rig)):
                scene = self._under(mi, lights)
                irradiance += weight * read(mi, self._meters, scene, samples, seed)
        return self.lightmap.reflected(irradiance)

    def _under(self, mi: Any, lights: dict[str, Any]) -> Any:
        """A scene of the shapes and `lights`."""
        shapes = {f"shape_{k}": shape for k, shape in enumerate(self._shapes)}
        return mi.load_dict({"type": "scene", **shapes, **lights}, optimize=False)


def _thin(lightmap: Surface) -> Surface:
    """Texels of a lightmap at which direct light is measured; raises an error if unsuitable."""
    rows, columns = lightmap.covered.shape
    if rows % DIRECT or columns % DIRECT:
        raise EnvLightsError(
            f"lightmap must have a multiple of {DIRECT} rows and columns; got {rows}x{columns}"
        )
    return lightmap.thinned(_step(rows // DIRECT), _step(columns // DIRECT))


def _step(texels: int) -> int:
    """The largest step that divides `texels` into `_POINTS` steps or more; otherwise 1."""
    return max((s for s in range(1, texels // _POINTS + 1) if texels % s == 0), default=1)


def _load(mi: Any, scene: dict[str, Any] | str | os.PathLike[str]) -> Any:
    """Scene with separate shapes; raises an error if Mitsuba cannot load it."""
    if not isinstance(scene, dict | str | os.PathLike):
        raise EnvLightsError(
            "scene must be a dict or the path of an XML file;"
            f" got an object of the type {type(scene).__name__}"
        )
    try:
        # Do not optimise: that would merge all shapes of one material.
        if isinstance(scene, dict):
            return mi.load_dict(scene, optimize=False)
        return mi.load_file(os.fspath(scene), optimize=False)
    except (RuntimeError, TypeError) as error:
        raise EnvLightsError(f"Mitsuba cannot load the scene: {in_one_line(error)}") from None


def _shapes(loaded: Any) -> list[Any]:
    """Shapes sorted by name; raises an error if a shape is unsuitable."""
    if not hasattr(loaded, "shapes"):
        raise EnvLightsError(f"scene must be of the type 'scene'; got a {type(loaded).__name__}")
    shapes = loaded.shapes()
    if not shapes:
        raise EnvLightsError("the scene has no shapes; there is nothing to light")
    for shape in shapes:
        if shape.is_emitter():
            raise EnvLightsError(
                f"the shape '{shape.id()}' is an area light; remove it, the rig lights the scene"
            )
    return sorted(shapes, key=lambda shape: str(shape.id()))


class Meters(NamedTuple):
    """Sensors on the covered texels of a surface."""

    sensor: Any
    """Sensor of all meters, with a film of one row."""

    squares: list[Any]
    """Shapes of the meters, kept alive here because a sensor does not. No scene contains them."""


def meters(mi: Any, surface: Surface) -> Meters:
    """A small square above each covered texel, and a meter on it."""
    point = mi.load_dict(film(1, 1))
    # Place a square of the size of the lift in the tangent plane of each texel.
    origins, normals = surface.lifted()
    mounts = np.zeros((len(origins), 4, 4))
    mounts[:, :3, :3] = np.swapaxes(tangent_frames(normals), 1, 2) * [surface.lift, surface.lift, 1]
    mounts[:, :3, 3] = origins
    mounts[:, 3, 3] = 1
    # Load the squares, each with its meter.
    squares = [
        mi.load_dict(
            {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f(mount),
                "meter": {"type": "irradiancemeter", "film": point},
            }
        )
        for mount in mounts
    ]
    row = {"type": "batch", "film": film(len(squares), 1), "sampler": {"type": "multijitter"}}
    # Batch the meters; Mitsuba takes them in the order of their names.
    named = {f"meter_{k:08}": square.sensor() for k, square in enumerate(squares)}
    return Meters(mi.load_dict({**row, **named}), squares)


def read(mi: Any, meters: Meters, scene: Any, samples: int, seed: int) -> NDArray[np.float64]:
    """Indirect irradiance of each texel, (n, 3): all bounces, without direct light."""
    paths = mi.load_dict({"type": "path", "hide_emitters": True})
    image = mi.render(scene, sensor=meters.sensor, integrator=paths, spp=samples, seed=seed)
    (row,) = np.array(image, np.float64)
    return np.asarray(row)
