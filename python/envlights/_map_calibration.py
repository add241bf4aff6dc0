"""Calibration of a map: candela per square metre from readings of a meter or an exposure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _calibration
from envlights._calibration import Readings
from envlights._check import amount
from envlights._map_light import MapLight
from envlights._native import EnvLightsError
from envlights._units import PHOTOMETRIC
from envlights._unseen import Unseen
from envlights.kernels.image import LUMINANCE
from envlights.repair import repair

if TYPE_CHECKING:
    from typing_extensions import Self


class MapCalibration(MapLight):
    """Radiance in cd/m2; see `EnvMap`."""

    def calibrated(
        self,
        *,
        lux: float | None = None,
        facing: ArrayLike | None = None,
        shaded: float | None = None,
        nits: float | None = None,
        at: ArrayLike | None = None,
        patch: float = 1.0,
        ev100: float | None = None,
        unseen: Unseen = None,
    ) -> Self:
        r"""Map in photometric units: the luminance of its radiance is in cd/m2.

        Give one reading: `lux`, `nits` with `at`, or `ev100`. Without any, the exposure in the EXIF
        of the file gives the scale; see `ev100`.

        Parameters
        ----------
        lux : float, optional
            Illuminance of a surface, as a lux meter shows it.
        facing : array_like, shape (3,), optional
            Unit vector that this surface faces. Default: up, (0, 1, 0).
        shaded : float, optional
            The same illuminance with only the sun shaded, for a map with a clipped sun: it gives
            the scale of all other light, and the difference gives the sun, as in `repaired`.
        nits : float, optional
            Luminance of a place in cd/m2, as a luminance meter shows it.
        at : array_like, shape (3,) or (2,), optional
            That place: a unit vector, or row and column of a pixel.
        patch : float
            Diameter in degrees of the disc around `at` whose mean luminance is compared; a spot
            meter has 1. A smaller disc than a pixel is that pixel.
        ev100 : float, optional
            Exposure value at ISO 100 of a picture in which 1 is the saturation of the sensor: 1
            becomes :math:`1.2 \cdot 2^{EV}` cd/m2.
        unseen : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            For `lux`: radiance where the map shows nothing; see `filled`.

        Returns
        -------
        EnvMap
            Map whose `units` are "cd/m2". Its last note has the reading and the factor. Luminance
            is 0.2126 R + 0.7152 G + 0.0722 B, for radiance and for irradiance. `fit`, `detect`
            and `split` of it give lights in lux, and files for other programs have their units.

        Raises
        ------
        EnvLightsError
            If there are readings of several kinds, the map is black or clipped there, readings in
            sun and shade contradict the map, or no reading is given and there is no EXIF.

        Notes
        -----
        With `ev100`, 1.2 is 78 / (100 x 0.65): the saturation of ISO 12232 through a lens that
        passes 65 % of the light (Lagarde and de Rousiers, "Moving Frostbite to Physically Based
        Rendering", 2014). Filament and Unity have the same factor. A reflected-light meter measures
        means, :math:`0.125 \cdot 2^{EV}` cd/m2; give those as `nits`. Tone curves of cameras, and
        stitching, move the scale of a JPEG by up to about one stop.

        Examples
        --------
        >>> import envlights as el
        >>> env = el.EnvMap(np.ones((32, 64, 3))).calibrated(lux=20000)
        >>> env.units, env.probe([[0, 1, 0]]).round(1)
        ('cd/m2', array([[20000., 20000., 20000.]]))

        A sun and its sky from readings of 98000 lux in the sun and 15000 in its shade:

        >>> sky = np.full((32, 64, 3), 0.1)
        >>> sky[6:8, 30:32] = 1.0
        >>> env = el.EnvMap(sky, white=1.0).calibrated(lux=98000, shaded=15000)
        >>> env.probe([[0, 1, 0]]).round(0)
        array([[98000., 98000., 98000.]])
        """
        readings = Readings(lux, facing, shaded, nits, at, ev100)
        readings.check()
        diameter = amount("patch", patch, most=180)
        if lux is not None:
            return self._by_lux(readings, unseen)
        if nits is not None and at is not None:
            return self._by_luminance(_calibration.reading("nits", nits), at, diameter)
        return self._by_exposure(ev100)

    def _by_lux(self, readings: Readings, unseen: Unseen) -> Self:
        """Map whose irradiance has the luminance that a lux meter shows."""
        lux, facing = readings.of_lux()
        ratio = readings.ratio(lux)
        source = f"{lux:g} lux on a surface that faces {_numbers(facing)}"
        if ratio is None:
            measured = float(self.probe(facing, unseen=unseen) @ LUMINANCE)
            return self._scaled(lux, measured, source)
        sunlit = self._with_sun(ratio, facing, readings, unseen)
        measured = float(sunlit.probe(facing, unseen=unseen) @ LUMINANCE)
        return sunlit._scaled(lux, measured, f"{source}, {readings.shaded:g} in the shade")

    def _with_sun(
        self, ratio: float, facing: NDArray[np.float64], readings: Readings, unseen: Unseen
    ) -> Self:
        """Map with the clipped light that two readings show; see `repaired`."""
        if not self.clipped_fraction:
            raise EnvLightsError(
                "shaded needs a map with a clipped sun, but no pixel is clipped: its sun has its"
                " true ratio to the sky; leave shaded out"
            )
        white = float(self._radiance.max()) if self._white is None else self._white
        received, assumed = self._from_unseen(unseen, facing)
        try:
            repaired = repair(
                self._radiance,
                self.is_border_sampled,
                white,
                None,
                ratio,
                facing,
                seen=self._seen,
                from_unseen=received,
            )
        except EnvLightsError as refusal:
            raise EnvLightsError(
                f"lux and shaded, {readings.lux:g} and {readings.shaded:g}, contradict the map:"
                f" {refusal}"
            ) from None
        return type(self).unchecked(
            repaired.radiance,
            registration=self._registration,
            notes=[*self._notes, *filter(None, [assumed]), repaired.note],
            seen=self._seen,
            source=self._source,
        )

    def _by_luminance(self, nits: float, at: ArrayLike, diameter: float) -> Self:
        """Map whose disc has the luminance that a meter shows."""
        direction = _calibration.direction_at(at, self.height, self.width)
        patch = _calibration.patch_of(self.cells(), self._seen, direction, diameter)
        patch.check(self._white)
        source = f"{nits:g} cd/m2 in a disc of {diameter:g} degrees at {_numbers(direction)}"
        return self._scaled(nits, patch.luminance, source)

    def _by_exposure(self, ev100: float | None) -> Self:
        """Map in which 1 is the luminance that saturates the sensor."""
        value, source = ev100, f"EV100 {ev100}"
        if value is None:
            if self._ev100 is None:
                raise EnvLightsError(
                    "give a reading: lux=, nits= with at=, or ev100=; without one, the file must be"
                    " a JPEG or TIFF with exposure time, aperture and sensitivity in its EXIF"
                )
            value = self._ev100
            source = f"EV100 {value:.2f} of the EXIF (up to about one stop off by a tone curve)"
        wanted = _calibration.SATURATION * 2.0 ** amount("ev100", value, -60, 60)
        return self._scaled(wanted, 1.0, source)

    def _scaled(self, wanted: float, measured: float, source: str) -> Self:
        """Map in cd/m2, whose own `measured` becomes `wanted`."""
        radiance, factor, note = _calibration.in_nits(self._radiance, wanted, measured, source)
        return type(self).unchecked(
            radiance,
            registration=self._registration,
            notes=[*_calibration.other_notes(self._notes), note],
            white=None if self._white is None else factor * self._white,
            seen=self._seen,
            units=PHOTOMETRIC,
            source=self._source,
        )


def _numbers(vector: NDArray[np.float64]) -> str:
    return f"({', '.join(f'{value + 0.0:.3g}' for value in vector)})"
