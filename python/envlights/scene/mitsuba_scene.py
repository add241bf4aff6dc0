"""A Mitsuba scene that is lit by rigs."""

from __future__ import annotations

import os
from functools import cached_property
from math import ceil, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from envlights._check import count
from envlights._native import EnvLightsError
from envlights.scene.charts import charts
from envlights.scene.direct import AnyLights, DirectLight, as_rig
from envlights.scene.emitters import emitters
from envlights.scene.meters import Meters, meters, read
from envlights.scene.renderer import mitsuba
from envlights.scene.surface import Surface

#: Texels along a side of the direct image, and points along a side of each.
_DIRECT, _POINTS = 16, 8
#: Rays of each point to see what is hidden of the sky. With 16 and 64 the direct image of the
#: courtyard under an ambient term was 3 and 1 % from Mitsuba's.
_RAYS = 64


class Rendered(NamedTuple):
    """A path-traced image."""

    image: NDArray[np.float32]
    """Radiance of the texels, (H, W, 3)."""

    noise: float
    """Its standard error, relative to it: the norm of the noise over the norm of the image."""


class MitsubaScene:
    """The shapes and materials of a Mitsuba scene, under the light of rigs.

    Images hold the radiance that the diffuse part of a material reflects, albedo / pi times
    irradiance: direct and indirect light add up to what is seen of a diffuse scene.

    Mitsuba runs in its variant ``scalar_rgb``; a variant that you have set is set again afterwards.

    Parameters
    ----------
    scene : dict or path-like
        What ``mitsuba.load_dict`` takes, or the path of an XML file; +y up. Its sensors,
        integrator, environment and point lights are left out: the rig is the light.
    lightmap : int or Surface
        Columns and rows of a lightmap with one square chart for each shape, in the order of their
        names, through its UV coordinates. Or a lightmap of your own, with a multiple of 16 rows
        and columns: direct light is then measured at its texels.

    Raises
    ------
    EnvLightsError
        If Mitsuba is not installed or refuses the scene; if a shape is an area light.

    Examples
    --------
    >>> import envlights as el
    >>> yard = MitsubaScene(el.synthetic.courtyard(), lightmap=32)
    >>> round(float(yard.lightmap.position[..., 1].max()), 4)  # of walls that are 3 m high
    2.8125
    >>> rig = el.Rig([0.2, 0.3, 0.5], el.Lights([[0.6, 0.8, 0]], [[3, 3, 2]]), error=0.0)
    >>> yard.indirect(rig, samples=16).image.shape
    (32, 32, 3)
    """

    lightmap: Surface
    """What each texel of the images of indirect light shows."""

    points: Surface
    """Where direct light is measured: 8 by 8 points for each texel of its image, or as near to that
    as a lightmap of your own allows."""

    def __init__(
        self, scene: dict[str, Any] | str | os.PathLike[str], lightmap: int | Surface = 128
    ) -> None:
        with mitsuba() as mi:
            # Kept alive: meshes look into the scene that they were loaded with.
            self._loaded = _loaded(mi, scene)
            self._shapes = _shapes(self._loaded)
            if isinstance(lightmap, Surface):
                self.lightmap, self.points = lightmap, _thinned(lightmap)
            else:
                self.lightmap = charts(mi, self._shapes, count("lightmap", lightmap, least=1))
                self.points = charts(mi, self._shapes, _DIRECT * _POINTS)
            self._scene = self._under(mi, {})

    def blocked(
        self, origins: NDArray[np.float64], directions: NDArray[np.float64]
    ) -> NDArray[np.bool_]:
        """Whether a shape stands in the way of each ray.

        Parameters
        ----------
        origins : ndarray, shape (n, 3)
            In the units of the scene.
        directions : ndarray, shape (n, 3)
            Unit vectors.

        Returns
        -------
        ndarray of bool, shape (n,)
        """
        with mitsuba() as mi:
            # As lists: Mitsuba takes six times as long to read rows of arrays.
            ends = zip(origins.tolist(), directions.tolist(), strict=True)
            hits = (self._scene.ray_test(mi.Ray3f(*each)) for each in ends)
            return np.fromiter(hits, np.bool_, len(origins))

    def direct(self, rig: AnyLights) -> NDArray[np.float32]:
        """Direct light in a small image: what a `TransferModel` predicts from.

        The first call traces what each texel sees of the sky; then each light takes one test for
        shadow for each point.

        Parameters
        ----------
        rig : Rig, Lights or DetectedLights
            Lights alone have no ambient term.

        Returns
        -------
        ndarray, shape (16, 16, 3)
            Radiance that the surfaces reflect of it, linear RGB: the mean over each part of the
            lightmap. On the lightmap itself, ``DirectLight.of(scene.lightmap, scene.blocked)`` has
            it.
        """
        image = self._direct_light.image(rig)
        return self.points.means(image, _DIRECT).astype(np.float32)

    def indirect(self, rig: AnyLights, samples: int = 256, seed: int = 0) -> Rendered:
        """Indirect light, path-traced: all bounces.

        Parameters
        ----------
        rig : Rig, Lights or DetectedLights
            Lights alone have no ambient term.
        samples : int
            Paths of each texel, rounded up to twice a square number.
        seed : int
            Of the paths.

        Returns
        -------
        Rendered
            The image, (H, W, 3), and its noise.
        """
        side = ceil(sqrt(count("samples", samples, least=1) / 2))
        # Two halves whose noise is independent: their difference tells of it.
        seeds = np.random.SeedSequence(count("seed", seed)).generate_state(2)
        one, two = (self._traced(rig, side * side, int(each)) for each in seeds)
        mean = (one + two) / 2
        size = np.linalg.norm(mean)
        noise = float(np.linalg.norm(one - two) / 2 / size) if size else 0.0
        return Rendered(mean.astype(np.float32), noise)

    @cached_property
    def _direct_light(self) -> DirectLight:
        return DirectLight.of(self.points, self.blocked, _RAYS)

    @cached_property
    def _meters(self) -> Meters:
        with mitsuba() as mi:
            return meters(mi, self.lightmap)

    def _traced(self, rig: AnyLights, samples: int, seed: int) -> NDArray[np.float64]:
        """Radiance that the lightmap reflects of the indirect light."""
        irradiance = np.zeros((np.count_nonzero(self.lightmap.covered), 3))
        with mitsuba() as mi:
            for weight, lights in emitters(mi, as_rig(rig)):
                scene = self._under(mi, lights)
                irradiance += weight * read(mi, self._meters, scene, samples, seed)
        return self.lightmap.reflected(irradiance)

    def _under(self, mi: Any, lights: dict[str, Any]) -> Any:
        """The shapes under `lights`."""
        shapes = {f"shape_{k}": shape for k, shape in enumerate(self._shapes)}
        return mi.load_dict({"type": "scene", **shapes, **lights}, optimize=False)


def _thinned(lightmap: Surface) -> Surface:
    """The texels of a lightmap at which direct light is measured, or a refusal."""
    rows, columns = lightmap.covered.shape
    if rows % _DIRECT or columns % _DIRECT:
        raise EnvLightsError(
            f"lightmap must have a multiple of {_DIRECT} rows and columns; got {rows}x{columns}"
        )
    return lightmap.thinned(_step(rows // _DIRECT), _step(columns // _DIRECT))


def _step(texels: int) -> int:
    """The largest step through so many texels that meets their end and leaves enough of them."""
    return max((s for s in range(1, texels // _POINTS + 1) if texels % s == 0), default=1)


def _loaded(mi: Any, scene: dict[str, Any] | str | os.PathLike[str]) -> Any:
    """The scene with each shape for itself, or a refusal."""
    if not isinstance(scene, dict | str | os.PathLike):
        raise EnvLightsError(f"scene must be a dict or the path of an XML file; got {scene!r:.40}")
    try:
        # Optimised scenes have one shape for all that are of one material.
        if isinstance(scene, dict):
            return mi.load_dict(scene, optimize=False)
        return mi.load_file(os.fspath(scene), optimize=False)
    except (RuntimeError, TypeError) as error:
        reason = " ".join(str(error).split())
        raise EnvLightsError(f"Mitsuba cannot load the scene: {reason}") from None


def _shapes(loaded: Any) -> list[Any]:
    """The shapes in the order of their names, or a refusal."""
    if not hasattr(loaded, "shapes"):
        raise EnvLightsError(f"scene must be of the type 'scene'; got a {type(loaded).__name__}")
    shapes = loaded.shapes()
    if not shapes:
        raise EnvLightsError("the scene has no shapes; there is nothing to light")
    for shape in shapes:
        if shape.is_emitter():
            raise EnvLightsError(
                f"the shape {shape.id()!r} is an area light; take it off: the rig is the light"
            )
    return sorted(shapes, key=lambda shape: str(shape.id()))
