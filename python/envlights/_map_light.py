"""Light of an environment map: its probe, and radiance for what it does not show."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _unseen, _visibility
from envlights._check import amount, check_choice, count, one_or_more
from envlights._map_harmonics import CONVENTIONS, in_convention, map_harmonics
from envlights._map_pixels import MapPixels
from envlights._unseen import PartialMap, Unseen
from envlights.kernels.image import LUMINANCE
from envlights.kernels.probe import irradiance

if TYPE_CHECKING:
    from typing_extensions import Self


#: Vector that an upward surface faces.
_UP = np.array([0.0, 1.0, 0.0])


class MapLight(MapPixels):
    """Probe and fill of a map; see `EnvMap`."""

    def probe(self, normals: ArrayLike, *, unseen: Unseen = None) -> NDArray[np.float64]:
        r"""Exact irradiance of a white Lambertian probe under the map.

        It is integrated over all pixels: the reference for `fit`.

        Parameters
        ----------
        normals : array_like, shape (n, 3) or (3,)
            Unit normals, or one.
        unseen : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance where the map shows nothing; see `filled`. For several calls, fill once:
            ``env.filled().probe(normals)``.

        Returns
        -------
        ndarray, shape (n, 3) or (3,)
            RGB irradiance in W m\ :sup:`-2`:
            :math:`E(n) = \int L(\omega) \max(0, n \cdot \omega)\, d\omega`. Divide by pi for the
            radiance of the probe (Madsen et al. 2003, equations 1 to 3).

        Raises
        ------
        EnvLightsError
            If `normals` has another shape or holds a vector whose length is not 1, or `filled`
            refuses `unseen`.
        """
        rows, is_one = one_or_more("normals", normals)
        radiance = self.filled(unseen).radiance
        values = irradiance(radiance, rows, border_sampled=self.is_border_sampled)
        return values[0] if is_one else values

    def harmonics(
        self, degree: int = 2, convention: str = "envlights", *, unseen: Unseen = None
    ) -> NDArray[np.float64]:
        r"""Spherical harmonics of the map up to order 2, as other programs store them.

        Parameters
        ----------
        degree : int
            Highest order, from 0 to 2.
        convention : {"envlights", "ramamoorthi", "three", "unity"}
            "envlights" and "ramamoorthi": coefficients L of the radiance for the real harmonics of
            `kernels.harmonic_radiance`, which are those of Ramamoorthi and Hanrahan (2001) in our
            axes. "three": the same in the axes of three.js, for ``LightProbe.sh.coefficients``.
            "unity": row i is ``sh[channel, i]`` of ``SphericalHarmonicsL2``, in the axes of Unity:
            irradiance over pi, with the factors of the polynomials multiplied in.
        unseen : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance where the map shows nothing; see `filled`.

        Returns
        -------
        ndarray, shape ((degree + 1)\ :sup:`2`, 3)
            Multiples of 1; y, z, x; xy, yz, 3z² - 1, xz, x² - y², in linear RGB. The integral is
            exact for pixels of one radiance each.

        Raises
        ------
        EnvLightsError
            If `degree` is not from 0 to 2, `convention` is unknown, or `filled` refuses `unseen`.

        References
        ----------
        R. Ramamoorthi, P. Hanrahan: "An Efficient Representation for Irradiance Environment Maps",
        SIGGRAPH 2001; equations 3, 8 and 12.

        Examples
        --------
        The irradiance over pi of a uniform map is its radiance, which Unity holds in row 0:

        >>> import envlights as el
        >>> env = el.EnvMap(np.full((16, 32, 3), 0.5))
        >>> env.harmonics(convention="unity")[0].round(6)
        array([0.5, 0.5, 0.5])
        """
        count("degree", degree, most=2)
        check_choice("convention", convention, CONVENTIONS)
        radiance = self.filled(unseen).radiance
        rows = in_convention(map_harmonics(radiance, self.is_border_sampled), convention)
        return rows[: (degree + 1) ** 2]

    def filled(self, unseen: Unseen = None, *, albedo: float = 0.25) -> Self:
        r"""Map with radiance where it shows nothing: its unseen part is filled.

        Parameters
        ----------
        unseen : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance of the unseen part. "black": none. "harmonic": a smooth continuation of the
            pixels around it, which solves Laplace's equation on the sphere. "ground": above the
            horizon the same, of radiance up to 8 times the median luminance; below it, diffuse
            ground under the sky above. A number or RGB: this radiance. Default: "harmonic" if 85 %
            or more of the sphere is seen; with less, a choice is required.
        albedo : float
            Albedo of the "ground", from 0 to 1: its radiance is the albedo times the irradiance of
            an upward surface over pi.

        Returns
        -------
        EnvMap
            Map without `seen`; its last note names the fill. A map that shows all is returned
            as it is. A partly seen pixel keeps its radiance, and the fill adds the unseen share.

        Raises
        ------
        EnvLightsError
            If `unseen` is none of these or left out with less than 85 % seen, or `albedo` is not
            from 0 to 1.

        Notes
        -----
        No fill knows a sun that was not seen. On 8 real maps with a hidden part, the probe of the
        filled map differed from that of the whole one by (median, worst): 0.002 and 0.004
        for "harmonic" without the part below -60 degrees; 0.12 and 0.43 for "ground" without the
        lower half; 0.16 and 0.91 for "harmonic" without the half behind. `benchmarks/unseen.py` has
        all fills.

        Examples
        --------
        Upper half of a grey world:

        >>> import envlights as el
        >>> seen = np.repeat([1.0, 0.0], 16)[:, None] * np.ones(64)
        >>> env = el.EnvMap(np.full((32, 64, 3), 0.5), seen=seen)
        >>> env.filled("harmonic").probe([[0, -1, 0]]).round(3)
        array([[1.571, 1.571, 1.571]])
        >>> env.filled("ground").radiance[-1, 0].round(3)
        array([0.125, 0.125, 0.125], dtype=float32)
        """
        amount("albedo", albedo, most=1.0)
        if self._seen is None:
            _unseen.checked_unseen(unseen)
            return self
        part = PartialMap(self._radiance, self._seen, self.is_border_sampled)
        share = part.share
        choice = _unseen.choice_of(unseen, share)
        of_unseen = _visibility.note_of_unseen(share)
        notes = [note for note in self._notes if note != of_unseen]
        env = type(self).unchecked(
            _unseen.fill(part, choice, albedo),
            registration=self._registration,
            notes=[*notes, _unseen.note_of_fill(choice, share, albedo)],
            white=self._white,
            source=self._source,
        )
        return self._of_same_scale(env)

    def _from_unseen(
        self, unseen: Unseen, facing: NDArray[np.float64] | None = None
    ) -> tuple[float, str]:
        """Luminance of the irradiance that a fill adds to a surface of a clipped map, and a note.

        The surface faces a unit vector; up when left out.
        """
        _unseen.checked_unseen(unseen)
        if self._seen is None or not self.clipped_fraction:
            return 0.0, ""
        part = PartialMap(self._radiance, self._seen, self.is_border_sampled)
        share = part.share if facing is not None else _unseen.share_above_horizon(part)
        filled = self.filled(_unseen.choice_of(unseen, share))
        normal = _UP if facing is None else facing
        with_fill, seen = (
            float(env.probe(normal, unseen="black") @ LUMINANCE) for env in (filled, self)
        )
        return with_fill - seen, f"for the irradiance of the surface, {filled.notes[-1]}"
