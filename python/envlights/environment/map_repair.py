"""Repair of a map: an estimate of its clipped light."""

from __future__ import annotations

from typing import TYPE_CHECKING

from envlights._common.former import former_arguments
from envlights._native import EnvLightsError
from envlights.environment.fill import Fill
from envlights.environment.map_light import MapLight
from envlights.environment.repair import repair

if TYPE_CHECKING:
    from typing_extensions import Self


class MapRepair(MapLight):
    """Estimate of clipped light; see `EnvMap`."""

    @former_arguments(unseen="fill")
    def repaired(
        self,
        *,
        sun: object = None,
        irradiance: float | None = None,
        ratio: float | None = None,
        fill: Fill = None,
    ) -> Self:
        r"""Map with an estimate of the clipped light.

        Clipped pixels are raised, each in its own colour. The amount of missing light is a number
        that you measured, or an estimate with the ground as light meter. Its distribution is a
        guess: more in small clipped regions, in high ones, and in the middle of each.

        Parameters
        ----------
        sun : None
            Refused: ``with_sun(env, sun).to_map()`` adds the disc of a sun.
        irradiance : float, optional
            Measured luminance of the irradiance on an upward surface, on the scale of the map:
            lux, if `units` is "cd/m2"; see `calibrated`.
        ratio : float, optional
            The same irradiance divided by the one without the clipped regions: two readings of a
            lux meter on the ground, in the open and with the sun shaded. It needs no scale.
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance where the map shows nothing, for the irradiance of an upward surface; see
            `filled`. Required if less than 85 % of the upper half is seen.

        Returns
        -------
        EnvMap
            Without a `clip_level`; what is not seen stays black. Its last note holds the factor by which
            the flux was raised, and its source. If the ground gives no estimate, the map keeps its
            `clip_level`, and the note says why.

        Raises
        ------
        EnvLightsError
            If both numbers are given, one is less than that of the map, all clipped pixels lie
            below the horizon, `fill` is required, or there is a `sun`.

        Notes
        -----
        `envlights.environment.repair` has the formula of the estimate. On 8-bit pictures of 17 HDR maps in
        eleven tones (`benchmarks/clipped_repair.py`) the relative RMS error of a probe at the best
        common scale falls from 0.43 to 0.23 (median), and grows by more than 0.05 in 2 %. Do not
        use it on ground that is far from grey, such as snow or a dark floor, in the shade while the
        sun shines elsewhere, or for light that does not reach the ground.

        Examples
        --------
        A clipped sun over grey ground that shows its irradiance:

        >>> import numpy as np
        >>> import envlights as el
        >>> sky = np.full((64, 128, 3), 0.1)
        >>> sky[12:14, 60:62] = 1.0
        >>> sky[32:] = 0.2 / np.pi * 2.0
        >>> env = el.EnvMap(sky, clip_level=1.0)
        >>> print(env.repaired().notes[-1].split(":")[0])
        the flux was raised by a factor of 2.6 for the clipped light
        >>> env.repaired(irradiance=2.0).probe([[0, 1, 0]]).round(3)
        array([[2., 2., 2.]])
        """
        if sun is not None:
            raise EnvLightsError(
                "repaired takes no sun; el.with_sun(env, sun).to_map() adds its disc to the map"
            )
        clip_level = self._clip_level
        if clip_level is None and self.clipped_fraction:
            clip_level = float(self._radiance.max())
        received, assumed = self._from_unseen(fill)
        radiance, note, is_open = repair(
            self._radiance,
            self.is_border_sampled,
            clip_level,
            irradiance,
            ratio,
            coverage=self._coverage,
            from_unseen=received,
        )
        clip_level = self._clip_level if is_open else None
        notes = (*self._notes, *filter(None, [assumed]), note)
        env = type(self)(
            radiance,
            registration=self._registration,
            notes=notes,
            clip_level=clip_level,
            coverage=self._coverage,
        )
        env._source = self._source
        return self._of_same_scale(env)
