"""Direct light of rigs on a surface."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from envlights import kernels
from envlights._common.check import count
from envlights._native import EnvLightsError
from envlights.detection.lights import DetectedLights
from envlights.kernels.ambient import as_harmonics
from envlights.kernels.solids import Solid, Stage, solids_of
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig
from envlights.scene.sky import Blocked, sky_transfer, visible_share
from envlights.scene.solids import blocked_by, hidden_harmonics
from envlights.scene.surface import Surface

#: A rig, or lights without an ambient term.
AnyLights = Rig | Lights | DetectedLights

#: No ambient light.
DARK = np.zeros(3)


@dataclass(frozen=True, eq=False)
class DirectLight:
    """Direct light of rigs on a surface, with shadows.

    A light without a size takes one shadow ray for each texel, a disc several to points on it. For
    the ambient term, the visible part of the sky is traced once for each texel. Shadows of balls,
    boxes and convex polyhedra need no rays: see `of_solids`.

    Examples
    --------
    A white floor under a light 60 degrees from its normal, with nothing in the way:

    >>> import numpy as np
    >>> from envlights import Lights, Rig
    >>> floor = Surface([[[0, 0, 0]]], [[[0, 1, 0]]], [[[np.pi] * 3]])
    >>> light = DirectLight.of(floor, lambda origins, directions: np.zeros(len(origins), bool))
    >>> rig = Rig([0, 0, 0], Lights([[np.sqrt(0.75), 0.5, 0]], [[2, 4, 6]]), error=0.0)
    >>> light.image(rig).round(6)
    array([[[1., 2., 3.]]])
    """

    surface: Surface
    """Surface that receives the light."""

    blocked: Blocked
    """Ray tracer: a function of origins and unit directions, (n, 3) each, that returns True for
    each ray that hits something, (n,)."""

    sky: NDArray[np.float64]
    """Irradiance of each covered texel under each spherical harmonic, (n, 9)."""

    rays: int = 16
    """Shadow rays from each texel to a light with a size. They vary between texels, so that a mean
    over several texels uses all their rays."""

    stage: Stage | None = None
    """Solids and covered texels, if shadows are computed in closed form."""

    @classmethod
    def of(cls, surface: Surface, blocked: Blocked, directions: int = 64) -> DirectLight:
        """Trace the visible part of the sky at each texel of a surface.

        Parameters
        ----------
        surface : Surface
        blocked : callable
            See the attribute.
        directions : int
            Rays for each texel. They differ from texel to texel, so a mean over several texels is
            as accurate as all their rays together.

        Returns
        -------
        DirectLight
        """
        directions = count("directions", directions, least=1)
        return cls(surface, blocked, sky_transfer(surface, blocked, directions))

    @classmethod
    def of_solids(
        cls, surface: Surface, solids: Solid | Iterable[Solid], directions: int = 64
    ) -> DirectLight:
        """Direct light with shadows of balls, boxes and convex polyhedra in closed form.

        Parameters
        ----------
        surface : Surface
            Texels on the solids or elsewhere. No texel should be inside a solid: it would be dark.
        solids : Ball, Box or Polyhedron, or several
            Everything that casts shadows. A floor is a wide, flat box.
        directions : int
            Rays for each texel if the ambient term is harmonics; all else has no noise.

        Returns
        -------
        DirectLight

        Examples
        --------
        A ball hides a light behind it, and a quarter of a constant sky:

        >>> from envlights import Lights, Rig
        >>> from envlights.scene import Ball, Surface
        >>> floor = Surface([[[0, 0, 0]]], [[[0, 1, 0]]], [[[1, 1, 1]]])
        >>> light = DirectLight.of_solids(floor, Ball((0, 2, 0), 1))
        >>> rig = Rig([1, 2, 3], Lights([[0, 1, 0]], [[4, 4, 4]], [0.3]), error=0.0)
        >>> light.image(rig).round(9)
        array([[[0.75, 1.5 , 2.25]]])
        """
        directions = count("directions", directions, least=1)
        _, normals = surface.lifted()
        stage = Stage(solids_of(solids), surface.position[surface.covered], normals)
        sky = kernels.harmonic_irradiance(normals)
        sky -= hidden_harmonics(surface, stage, directions)
        return cls(surface, blocked_by(stage.solids), sky, stage=stage)

    def image(self, rig: AnyLights) -> NDArray[np.float64]:
        r"""Reflected radiance of the surface under the direct light of a rig.

        Parameters
        ----------
        rig : Rig, Lights or DetectedLights
            In the frame of the scene; lights alone have no ambient term.

        Returns
        -------
        ndarray, shape (H, W, 3)
            :math:`\frac{albedo}{\pi} (E_a + \sum_j V_j E_j \max(0, n \cdot l_j))` with the
            visibility :math:`V_j` of each light, and the irradiance :math:`E_a` of the visible part
            of the ambient term. Of a disc, the irradiance without shadows is known in closed form,
            and :math:`V_j` is the fraction of the rays that reach it, or exact for solids.
        """
        rig = as_rig(rig)
        irradiance = self.sky @ as_harmonics(rig.ambient)
        # Add each light at the texels that face it, outside its shadow.
        lights = self._traced(rig.lights) if self.stage is None else _exact(rig.lights, self.stage)
        return self.surface.reflected(irradiance + lights)

    def _traced(self, lights: Lights) -> NDArray[np.float64]:
        """Irradiance of the covered texels under lights, with shadow rays."""
        origins, normals = self.surface.lifted()
        irradiance = np.zeros_like(normals)
        rows = zip(lights.direction, lights.irradiance, lights.angular_radius, strict=True)
        for direction, strength, radius in rows:
            received = kernels.rig_irradiance(normals, DARK, [direction], [strength], [radius])
            faces = np.flatnonzero(received.any(axis=1))
            seen = visible_share(
                self.blocked, origins[faces], normals[faces], direction, radius, self.rays
            )
            irradiance[faces] += seen[:, None] * received[faces]
        return irradiance


def _exact(lights: Lights, stage: Stage) -> NDArray[np.float64]:
    """Irradiance under lights, with shadows in closed form."""
    discs = lights.direction, lights.irradiance, lights.angular_radius
    whole = kernels.rig_irradiance(stage.normals, DARK, *discs)
    hidden = kernels.hidden_fractions(stage, lights.direction, lights.angular_radius)[:, 1:]
    return np.asarray(np.maximum(whole - hidden @ lights.irradiance, 0.0))


def as_rig(lights: AnyLights) -> Rig:
    """The given rig, or a rig of lights only; raises an error for other values."""
    if isinstance(lights, Rig):
        return lights
    if not isinstance(lights, Lights | DetectedLights):
        raise EnvLightsError(
            "a rig must be a Rig, Lights or DetectedLights;"
            f" got an object of the type {type(lights).__name__}"
        )
    return Rig(DARK, lights.discs(), error=0.0)
