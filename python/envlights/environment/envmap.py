"""The environment map: radiance from every direction, and its pixel layout."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights._common.arrays import convert as convert_array
from envlights._common.check import describe, texts
from envlights._common.former import former_arguments, former_attributes, former_parts
from envlights._common.notes import Note
from envlights._common.units import OWN_SCALE, checked_units
from envlights._native import EnvLightsError
from envlights.environment import convert, light, repair, text
from envlights.environment.calibrate import Readings, calibrate
from envlights.environment.colour.choice import ColourArgument
from envlights.environment.files.image_output import COMPRESSIONS
from envlights.environment.files.images import MOST_PIXELS
from envlights.environment.fill import Fill
from envlights.environment.layouts.picture import Picture
from envlights.environment.layouts.projections import (
    ARGUMENTS,
    Layout,
    with_arguments,
    with_target_arguments,
)
from envlights.environment.layouts.records import Origin
from envlights.environment.open import map_of_array, map_of_exposures, open_map
from envlights.environment.picture_files import PictureSource
from envlights.environment.pixels import PROJECTION, MapPixels, are_equal
from envlights.frames import turn_of, turn_upright

if TYPE_CHECKING:
    from typing_extensions import Self

_T = TypeVar("_T")


@former_attributes(
    white="clip_level",
    seen="coverage",
    seen_share="coverage_fraction",
    clipped_share="clipped_fraction",
    clipped_flux_share="clipped_flux_fraction",
)
class EnvMap:
    r"""An environment map: radiance from every direction.

    Frame: right-handed, +y up. The centre of the image looks along +z, its left quarter along +x,
    its top row at the zenith.

    Parameters
    ----------
    radiance : array_like, shape (height, 2 * height, 3)
        Floating point: linear radiance in W m\ :sup:`-2` sr\ :sup:`-1`, on any common scale.
        uint8 and uint16: sRGB codes. A fourth channel is straight alpha, also of floating point:
        radiance is multiplied by it. Masked pixels of a NumPy masked array are not seen. A single
        channel is grey. NaN becomes the mean of its neighbours, negative samples become 0. Infinite
        ones count as clipped, at 65504 or at twice the largest finite sample. `notes` lists every
        change. A C-contiguous float32 array without such samples is not copied, so do
        not change it afterwards. Other layouts have other shapes; the faces of a cube may be an
        array (6, n, n, 3), or a mapping from names like "px" to arrays.
    layout : str or Layout, optional
        "equirectangular", "cube", "octahedral", "octahedral-equal-area", "angular" (light probe),
        "mirror-ball", "fisheye", "cylinder" or "planar" (a photograph), or a `Layout` with more
        arguments: ``el.io.Layout.fisheye(mapping="equisolid", fov=180)``. When left out, shape and
        content decide, or a refusal lists the candidates. Other layouts than equirectangular are
        converted to it; see `source`.
    width : int, optional
        Columns of the map. When left out, 4 times the side of a cube's face, or such that its cells
        are as large as the pixels of the picture.
    notes : str or iterable of str
        Remarks on the map's origin.
    clip_level : float, optional
        Clip level: the largest value that the radiance could hold, such as 1.0 for a linearised
        picture. Known for uint8 and uint16. Detection treats pixels at the clip level as lights of
        unknown brightness; see `detect`.
    coverage : array_like, shape of the array without channels, optional
        Fraction of each pixel that the picture shows, from 0 to 1. The radiance is multiplied by it
        already; pixels of fraction 0 become black. `filled` has radiance for them.
    units : {"the map's own scale", "cd/m2"}
        Unit of the radiance; "cd/m2" is that of its luminance. `calibrated` makes it so.

    Raises
    ------
    EnvLightsError
        If the array has another shape or dtype, or holds no finite sample.

    Examples
    --------
    >>> import numpy as np
    >>> env = EnvMap(np.ones((64, 128, 3)))
    >>> env
    EnvMap(128x64 equirectangular, cell-centred)
    >>> env.probe([[0, 1, 0]]).round(3)
    array([[3.142, 3.142, 3.142]])
    """

    @former_parts(
        "layout",
        with_arguments,
        ARGUMENTS,
        white="clip_level",
        towards="forward",
        seen="coverage",
    )
    def __init__(
        self,
        radiance: ArrayLike | Mapping[str, ArrayLike],
        *,
        layout: str | Layout | None = None,
        width: int | None = None,
        notes: str | Iterable[str] = (),
        clip_level: float | None = None,
        coverage: ArrayLike | None = None,
        units: str = OWN_SCALE,
    ) -> None:
        if isinstance(radiance, str | os.PathLike):
            raise EnvLightsError(
                "a map must be an array; `EnvMap.open` reads files; got"
                f" {describe(os.fspath(radiance))}"
            )
        self._pixels = map_of_array(
            radiance,
            coverage,
            layout,
            width,
            clip_level,
            texts("notes", notes),
            checked_units(units),
        )

    @classmethod
    def _of(cls, pixels: MapPixels) -> Self:
        """Map of pixels that are already checked."""
        env = cls.__new__(cls)
        env._pixels = pixels
        return env

    @classmethod
    @former_parts("layout", with_arguments, ARGUMENTS, white="clip_level", towards="forward")
    def open(
        cls,
        path: PictureSource,
        *,
        layout: str | Layout | None = None,
        width: int | None = None,
        clip_level: float | None = None,
        colour: ColourArgument | None = None,
        part: str | int | None = None,
        channels: str | Sequence[str] | None = None,
        max_pixels: int = MOST_PIXELS,
        any_format: bool = False,
    ) -> EnvMap:
        """Read a map from one file, or from the six files of a cube map.

        Parameters
        ----------
        path : path-like, bytes or file object
            Radiance .hdr, OpenEXR, PNG, JPEG or TIFF; the first bytes decide. "-" is the standard
            input; addresses like ``s3://`` are read by fsspec, if it is installed. The colour space
            of the file is converted to linear Rec.709: transfer curve, ICC profile, primaries.
            Integers without a statement are sRGB. What alpha or a crop hides is black; see
            `coverage`.
            Six faces of a cube: a list, a mapping, a folder, or a name like ``sky_{face}.hdr``.
        layout, width
            Layout of the picture, and columns of the map; see `EnvMap`. When left out, the
            statement of `Picture.save` or other metadata of the file decide, then names, shape and
            content.
        clip_level : float, optional
            Clip level; see `EnvMap`. Known for files of integers, from their own histogram.
        colour : str, bytes or path-like, optional
            Colour space of the samples, instead of what the file says: "linear", "srgb", "p3",
            "rec2020", "acescg", ..., or an ICC profile.
        part : str or int, optional
            Name of a layer, or name or number of an image of the file. When left out, the finished
            picture is found by its name.
        channels : str or sequence of str, optional
            Names of red, green and blue, or of one grey channel, then perhaps alpha.
        max_pixels : int
            Files with more pixels are refused before memory is allocated. The default is
            32768x16384.
        any_format : bool
            True: try all formats of OpenImageIO (extra ``formats``) on other files, DDS among them.
            Not for files of strangers, because these readers had memory faults.

        Returns
        -------
        EnvMap
            With `notes` on everything that was assumed, and the layout of the file in `source`.

        Raises
        ------
        EnvLightsError
            If the file cannot be read, or its layout is not known; then the sentence lists the
            candidates.
        """
        pixels = open_map(
            path,
            layout,
            width,
            clip_level,
            colour=colour,
            part=part,
            channels=channels,
            max_pixels=max_pixels,
            any_format=any_format,
        )
        return cls._of(pixels)

    @classmethod
    def from_exposures(
        cls,
        pictures: Iterable[ArrayLike | str | os.PathLike[str]],
        times: Iterable[float] | None = None,
        *,
        response: str | ArrayLike | None = None,
    ) -> EnvMap:
        """Merge exposures of a panorama into one linear map (Madsen et al. 2003, figure 4).

        Every sample is the mean of the exposures that show it well, with weights that fall to 0
        towards white and black. Near clipped regions, where JPEG rings, a longer exposure counts
        only if shorter ones show that it is dark there. Exposures that differ by more than a factor
        of 1.3, because something moved, are replaced by the best one.

        Parameters
        ----------
        pictures : iterable of path-like or array_like, shape (height, 2 * height, 3)
            Two exposures or more from one position, in any order: files as in `open`, raw files of
            cameras (with the extra ``raw``), or arrays of uint8 or uint16, which are codes.
            Floating-point arrays are linear and clipped at 1.
        times : iterable of float, optional
            Exposure time of each picture, in any unit. When left out, the EXIF of the files gives
            time, aperture and sensitivity. One wrong time is corrected if the others show it.
        response : {"srgb", "linear"} or array_like, shape (256,), optional
            Response of the camera: exposures of the codes 0 to 255. When left out, it is sRGB if
            that agrees with the times, else another known curve, else it is estimated.

        Returns
        -------
        EnvMap
            Radiance 1 is the clip level at an exposure time of 1. With an estimated response it is
            relative: ratios are measured, and its scale, that of the clip level, may be off by a
            factor of 2; `calibrated` sets it. `clip_level` is set if the shortest exposure is still
            clipped. `notes` report a clip level below code 254, a response other than sRGB, a
            corrected time, moved pictures, drift of the white balance, and contradictions.

        Raises
        ------
        EnvLightsError
            If a picture cannot be read, sizes differ, a time is missing, tags of aperture or
            sensitivity are missing in some files, or the pictures contradict the times.

        Examples
        --------
        >>> import numpy as np
        >>> truth = np.full((4, 8, 3), 0.05)
        >>> truth[1, 2] = 6.0
        >>> env = EnvMap.from_exposures([np.minimum(truth * t, 1) for t in (0.1, 8.0)], (0.1, 8.0))
        >>> env.radiance[1, 1:3, 0].round(3)
        array([0.05, 6.  ], dtype=float32)
        """
        return cls._of(map_of_exposures(pictures, times, response))

    @property
    def radiance(self) -> NDArray[np.float32]:
        """Linear RGB, (height, width, 3), read-only; ``radiance.copy()`` is writable."""
        return self._pixels.radiance

    @property
    def projection(self) -> str:
        """Layout of the sphere in `radiance`: "equirectangular"; `source` has that of the input."""
        return PROJECTION

    @property
    def source(self) -> Origin:
        """Original picture of the map: its layout, and how it was recognised."""
        return self._pixels.source

    @property
    def registration(self) -> str:
        """Positions of the pixels: "cell-centred" or "border-sampled"."""
        return self._pixels.registration

    @property
    def is_border_sampled(self) -> bool:
        """True if the outer pixels lie on the seam and the poles."""
        return self._pixels.is_border_sampled

    @property
    def notes(self) -> tuple[Note, ...]:
        """Notes on changed samples and on assumptions; `Note.code` is the kind of a note."""
        return tuple(map(Note, self._pixels.notes))

    @property
    def clip_level(self) -> float | None:
        """Clip level: the largest value that the radiance can hold; None if unknown."""
        return self._pixels.clip_level

    @property
    def units(self) -> str:
        """Unit of the radiance: "cd/m2" or "the map's own scale".

        `calibrated` sets it. Irradiance of a map in cd/m2 has a luminance in lux.
        """
        return self._pixels.units

    @property
    def ev100(self) -> float | None:
        """Exposure value at ISO 100 of the picture, from the EXIF of its file; None if unknown.

        Known for JPEG and TIFF files of integers with exposure time, aperture and sensitivity, and
        for a merged series of them.
        """
        return self._pixels.ev100

    @property
    def clipped_fraction(self) -> float:
        """Fraction of the sphere with clipped radiance.

        With a known `clip_level`, or in floats decoded from 8-bit codes: pixels with a channel at
        it, from code 254 of 255 on. Otherwise: pixels with the largest sample, if there are
        several.
        """
        return self._pixels.clipped_fractions[0]

    @property
    def clipped_flux_fraction(self) -> float:
        """Fraction of the luminance flux in clipped pixels.

        Lights that `fit` places there are a lower bound.
        """
        return self._pixels.clipped_fractions[1]

    @property
    def coverage(self) -> NDArray[np.float32] | None:
        """Coverage of each pixel, 0 to 1, (height, width); None if the map is complete."""
        return self._pixels.coverage

    @property
    def coverage_fraction(self) -> float:
        """Fraction of the sphere that the map covers."""
        return self._pixels.coverage_fraction

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.radiance.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.radiance.shape[1])

    def cells(self) -> NDArray[np.float32]:
        """Radiance resampled to a cell-centred map of the same size and flux."""
        return self._pixels.cells()

    def probe(self, normals: ArrayLike, *, fill: Fill = None) -> NDArray[np.float64]:
        r"""Exact irradiance of a white Lambertian probe under the map.

        It is integrated over all pixels: the reference for `fit`.

        Parameters
        ----------
        normals : array_like, shape (n, 3) or (3,)
            Unit normals, or one.
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
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
            refuses `fill`.
        """
        return light.probe(self._pixels, normals, fill)

    def harmonics(
        self, degree: int = 2, convention: str = "envlights", *, fill: Fill = None
    ) -> NDArray[np.float64]:
        r"""Spherical harmonics of the map up to order 2, as other programs store them.

        Parameters
        ----------
        degree : int
            Highest order, from 0 to 2.
        convention : {"envlights", "ramamoorthi", "three", "unity", "filament", "babylon"}
            "envlights" and "ramamoorthi": coefficients L of the radiance for the real harmonics of
            `kernels.harmonic_radiance`, which are those of Ramamoorthi and Hanrahan (2001) in our
            axes. "three": the same in the axes of three.js, for ``LightProbe.sh.coefficients``.
            "unity": row i is ``sh[channel, i]`` of ``SphericalHarmonicsL2``, in the axes of Unity:
            irradiance over pi, with the factors of the polynomials multiplied in. "filament": the
            same in our axes, which are those of glTF, for ``IndirectLight::Builder::irradiance``
            and Cesium's `sphericalHarmonicCoefficients`. "babylon": irradiance over pi for
            ``SphericalHarmonics.FromArray`` of Babylon.js, in the left-handed axes of a glTF there.
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
            Radiance where the map shows nothing; see `filled`.

        Returns
        -------
        ndarray, shape ((degree + 1)\ :sup:`2`, 3)
            Multiples of 1; y, z, x; xy, yz, 3z² - 1, xz, x² - y², in linear RGB. The integral is
            exact for pixels of one radiance each.

        Raises
        ------
        EnvLightsError
            If `degree` is not from 0 to 2, `convention` is unknown, or `filled` refuses `fill`.

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
        return light.harmonics(self._pixels, degree, convention, fill)

    @former_arguments(unseen="fill")
    def filled(self, fill: Fill = None, *, albedo: float = 0.25) -> Self:
        r"""Map with radiance filled in where nothing is visible.

        Parameters
        ----------
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
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
            Map without `coverage`; its last note names the fill. A map that shows all is returned
            as it is. A partly seen pixel keeps its radiance, and the fill adds the uncovered part.

        Raises
        ------
        EnvLightsError
            If `fill` is none of these or left out with less than 85 % seen, or `albedo` is not
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
        >>> env = el.EnvMap(np.full((32, 64, 3), 0.5), coverage=seen)
        >>> env.filled("harmonic").probe([[0, -1, 0]]).round(3)
        array([[1.571, 1.571, 1.571]])
        >>> env.filled("ground").radiance[-1, 0].round(3)
        array([0.125, 0.125, 0.125], dtype=float32)
        """
        return self._changed(light.with_fill(self._pixels, fill, albedo))

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
            Without a `clip_level`; what is not seen stays black. Its last note holds the factor by
            which the flux was raised, and its source. If the ground gives no estimate, the map
            keeps its `clip_level`, and the note says why.

        Raises
        ------
        EnvLightsError
            If both numbers are given, one is less than that of the map, all clipped pixels lie
            below the horizon, `fill` is required, or there is a `sun`.

        Notes
        -----
        `envlights.environment.repair` has the formula of the estimate. On 8-bit pictures of 17 HDR
        maps in eleven tones (`benchmarks/clipped_repair.py`) the relative RMS error of a probe at
        the best common scale falls from 0.43 to 0.23 (median), and grows by more than 0.05 in 2 %.
        Do not
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
        return self._changed(repair.with_estimate(self._pixels, irradiance, ratio, fill))

    @former_arguments(unseen="fill", facing="normal")
    def calibrated(
        self,
        *,
        lux: float | None = None,
        normal: ArrayLike | None = None,
        shaded: float | None = None,
        nits: float | None = None,
        at: ArrayLike | None = None,
        patch: float = 1.0,
        ev100: float | None = None,
        fill: Fill = None,
    ) -> Self:
        r"""Map in photometric units: its luminance is in cd/m2.

        Give one reading: `lux`, `nits` with `at`, or `ev100`. Without any, the exposure in the EXIF
        of the file gives the scale; see `ev100`.

        Parameters
        ----------
        lux : float, optional
            Illuminance of a surface, as a lux meter shows it.
        normal : array_like, shape (3,), optional
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
        fill : {"black", "harmonic", "ground"}, float or array_like, shape (3,), optional
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
            sun and shade contradict the map, `ev100` is of a map in cd/m2, or no reading is given
            and there is no EXIF.

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
        >>> env = el.EnvMap(sky, clip_level=1.0).calibrated(lux=98000, shaded=15000)
        >>> env.probe([[0, 1, 0]]).round(0)
        array([[98000., 98000., 98000.]])
        """
        readings = Readings(lux, normal, shaded, nits, at, ev100)
        return self._changed(calibrate(self._pixels, readings, patch, fill))

    def rotated(
        self,
        matrix: ArrayLike | None = None,
        *,
        frame: str | None = None,
        camera: ArrayLike | None = None,
    ) -> Self:
        """Rotate the map: the radiance from direction d moves to ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3), optional
            A rotation, such as one of `el.frames.rotation`, in the frame of the map or in `frame`.
        frame : str, optional
            Name of the frame of the other argument, from `el.frames.FRAMES`: "colmap", "blender".
        camera : array_like, shape (3, 3), (3, 4) or (4, 4), optional
            In place of `matrix`: the matrix of a camera as the program of `frame` stores it. The
            map becomes the view of this camera, with what it looks at in the centre.

        Returns
        -------
        EnvMap
            Map of the same size. Rotations about the pole by whole columns lose nothing. Other
            rotations average samples of each pixel, keep the flux of the map, the flux and the
            direction of each bright pixel, and make a border-sampled map cell-centred.

        See Also
        --------
        Rig.rotated : the same for a rig.
        el.frames.Axes.view : the rotation of a `camera`, for rigs and lights.

        Examples
        --------
        A quarter turn about the pole, from +z to +x:

        >>> import envlights as el
        >>> env = el.EnvMap(np.eye(8)[:4, :, None] * np.ones(3))
        >>> turned = env.rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
        >>> np.array_equal(turned.radiance, np.roll(env.radiance, -2, axis=1))
        True
        """
        return self._changed(convert.rotate(self._pixels, turn_of(matrix, frame, camera)))

    def levelled(self, up: ArrayLike) -> Self:
        """Rotate the map by the smallest angle that brings a direction to the zenith.

        Parameters
        ----------
        up : array_like, shape (3,)
            Direction in the map, of any length above 0, that is up in the world.

        Examples
        --------
        >>> import envlights as el
        >>> lamp = el.Lights([[0.6, 0.8, 0]], [[1, 1, 1]], [0.2]).to_map(64)
        >>> lamp.levelled([0.6, 0.8, 0]).probe([[0, 1, 0]]).round(3)
        array([[1., 1., 1.]])
        """
        return self.rotated(turn_upright(up))

    def resized(self, width: int) -> Self:
        """Map of another size with the same flux.

        Parameters
        ----------
        width : int
            Columns, even; the height is half of it.

        Returns
        -------
        EnvMap
            Cell-centred. Every bright pixel keeps its flux and its direction.

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).resized(32)
        EnvMap(32x16 equirectangular, cell-centred)
        """
        return self._changed(convert.resize(self._pixels, width))

    def limited(self, maximum: float) -> Self:
        """Map limited to a maximum, for formats and displays that have one.

        The excess of each light is spread over the pixels around it, so that flux and direction of
        the light stay. `envlights.limit` returns the excess as lights instead.

        Parameters
        ----------
        maximum : float
            Largest value of a sample, such as 65504 for half floats.

        Returns
        -------
        EnvMap
            The last note says how much flux was moved, and how far.

        Raises
        ------
        EnvLightsError
            If the mean radiance of the map is above the maximum.

        Examples
        --------
        >>> import envlights as el
        >>> sky = np.ones((64, 128, 3))
        >>> sky[20, 40] = 1e5
        >>> env = el.EnvMap(sky).limited(65504)
        >>> float(env.radiance.max())
        65504.0
        >>> env.notes[-1]
        'limited to 65504: 32 % of the flux was moved by up to 4.2 degrees'
        """
        return self._changed(convert.limit(self._pixels, maximum))

    @former_parts("layout", with_target_arguments, ARGUMENTS)
    def to(self, layout: str | Layout, *, width: int | None = None) -> Picture:
        """Picture of the map in another layout.

        Parameters
        ----------
        layout : str or Layout
            "cube", "octahedral", "octahedral-equal-area", "angular", "mirror-ball", "fisheye",
            "cylinder", "planar", "equirectangular", or a `Layout` with more arguments:
            ``el.io.Layout.planar(fov=65, forward=(1, 0, 0))``. "source" is the layout of
            `EnvMap.source`, with its size, faces, orientation and field of view, as for the rest of
            `split`.
        width : int, optional
            Columns; of a cube, those of one face. When left out, the pixels are as large as those
            of the map on its equator.

        Returns
        -------
        Picture
            `numpy.asarray` gives its samples; `Picture.save` writes files.

        Raises
        ------
        EnvLightsError
            If the layout is not known, or an argument of it is missing, out of its range or of
            pictures that exist, such as `circle`.

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).to("cube", width=32)
        Picture(32x192 cube, cell-centred, faces in the order of OpenGL)
        """
        return convert.to(self._pixels, layout, width)

    def view(
        self,
        direction: ArrayLike,
        fov: float = 60.0,
        *,
        width: int = 800,
        height: int | None = None,
    ) -> Picture:
        """Picture by a level camera inside the map.

        Parameters
        ----------
        direction : array_like, shape (3,)
            Direction of the centre of the picture.
        fov : float
            Horizontal field of view, in degrees.
        width, height : int
            Size of the picture; 3:2 when `height` is left out.

        Returns
        -------
        Picture
            Radiance, (height, width, 3).

        Examples
        --------
        >>> import envlights as el
        >>> el.EnvMap(np.ones((64, 128, 3))).view([0, 0, 1], width=90)
        Picture(90x60 planar)
        """
        return convert.view(self._pixels, direction, fov, width, height)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        half: bool = False,
        compression: str = COMPRESSIONS[0],
    ) -> None:
        """Write the map as an OpenEXR (.exr) or Radiance (.hdr) file; a failure leaves no file.

        `open` reads it back: .exr without loss, .hdr with 8 bits and a shared exponent.

        Parameters
        ----------
        path : path-like
            A file with the suffix ``.exr`` or ``.hdr``.
        half : bool
            For .exr: 16 instead of 32 bits for each sample. A sample above 65504 is refused.
        compression : {"zip", "piz", "rle", "none"}
            For .exr; all keep every bit.

        Notes
        -----
        Primaries are those of Rec.709. A border-sampled map gets the attribute ``envmap``, and one
        in cd/m2 the attribute ``whiteLuminance``, which `open` reads; `coverage` becomes alpha. A
        .hdr file cannot hold them, so such a map is converted to cells, loses its units, and what
        is not seen becomes black; a sample above 1.7e38 is refused.
        The notes of the map become comments of the file. `open` reads those on estimates, such as
        that of `repaired`.
        """
        convert.save(self._pixels, path, half=half, compression=compression)

    def with_radiance(
        self, radiance: NDArray[np.float32], notes: Iterable[str], *, keeps_clip_level: bool = True
    ) -> Self:
        """Map with other samples in the same layout.

        Parameters
        ----------
        radiance : ndarray of float32, shape (height, width, 3)
            Multiplied by `coverage`; not checked.
        notes : iterable of str
            All notes of the new map.
        keeps_clip_level : bool
            False for radiance that was estimated above the clip level.

        Returns
        -------
        EnvMap
            Registration, clip level, seen part, source, units and exposure are those of this map.
        """
        level = self.clip_level if keeps_clip_level else None
        changed = self._pixels.changed(radiance, self.coverage, notes, clip_level=level)
        return self._of(changed)

    def _changed(self, pixels: MapPixels) -> Self:
        """Map with other pixels; the same object if they did not change."""
        return self if pixels is self._pixels else self._of(pixels)

    def __repr__(self) -> str:
        return text.line(self._pixels, type(self).__name__)

    def __str__(self) -> str:
        return text.paragraph(self._pixels)

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        return text.block(self._pixels, type(self).__name__)

    def __eq__(self, other: object) -> bool:
        """True if radiance, units, layout, clip level and coverage are equal."""
        return (
            are_equal(self._pixels, other._pixels) if isinstance(other, EnvMap) else NotImplemented
        )

    __hash__: ClassVar[None] = None  # type: ignore[assignment]  # what is compared by its pixels

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Radiance as an array, for NumPy."""
        return convert_array(self.radiance, dtype, copy)

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self)._of, (self._pixels,)
