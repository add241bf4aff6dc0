"""The environment map: radiance from every direction, and the layout of its pixels."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from envlights import _cleaning, _html, _map_text, _native, _thumbnails, resampling
from envlights._arrays import converted
from envlights._check import amount, check_choice, one_or_more, rotation, shown, texts
from envlights._map_array import map_array
from envlights._native import EnvLightsError, UnusableSamplesError
from envlights.io.exposures import Exposures
from envlights.io.image_output import COMPRESSIONS, map_suffix, write_exr, write_hdr
from envlights.io.images import MOST_PIXELS, read_image
from envlights.kernels.probe import irradiance
from envlights.repair import repair

PROJECTIONS = ("equirectangular",)
REGISTRATIONS = ("cell-centred", "border-sampled")

_T = TypeVar("_T")


class EnvMap:
    r"""An environment map: radiance from every direction.

    Frame: right-handed, +y up. The centre of the image looks along +z, its left quarter along +x,
    its top row at the zenith.

    Parameters
    ----------
    radiance : array_like, shape (height, 2 * height, 3)
        Three channels; of four the last is alpha, which is ignored, and one, or none at all, is
        grey: `notes` says so.
        Floating point: linear radiance in W m\ :sup:`-2` sr\ :sup:`-1`, on any common scale.
        uint8 and uint16: sRGB-coded, which is noted. A C-contiguous float32 array is not copied
        (it must not be changed afterwards), unless it holds samples that are not radiance: negative
        ones and NaN become 0, infinite ones the largest finite sample; `notes` holds their number.
    projection : {"equirectangular"}
        The layout of the sphere in the image, by name, so that a script says what its array is.
        Only this one can be read as yet; others are refused.
    registration : {"cell-centred", "border-sampled"}
        "cell-centred": a pixel stands for the cell around its centre, as in most files.
        "border-sampled": the outer pixels lie on the seam and the poles, as in OpenEXR files with
        the `envmap` attribute.
    notes : str or iterable of str
        Remarks on the map's origin.
    white : float, optional
        The value at which the radiance was cut off, such as 1.0 for a picture that was linearised
        elsewhere. It is known for uint8 and uint16. Detection treats what is at white as lost, not
        as dim; see `detect_tree`.

    Raises
    ------
    EnvLightsError
        If the array has another shape or dtype, or holds no finite sample.

    Examples
    --------
    >>> env = EnvMap(np.ones((64, 128, 3)))
    >>> env
    EnvMap(128x64 equirectangular, cell-centred)
    >>> env.probe([[0, 1, 0]]).round(3)
    array([[3.142, 3.142, 3.142]])
    """

    def __init__(
        self,
        radiance: ArrayLike,
        *,
        projection: str = "equirectangular",
        registration: str = "cell-centred",
        notes: str | Iterable[str] = (),
        white: float | None = None,
    ) -> None:
        check_choice("projection", projection, PROJECTIONS)
        check_choice("registration", registration, REGISTRATIONS)
        self._white = None if white is None else checked_white(white)
        self._clipped: tuple[float, float] | None = None
        self._notes = texts("notes", notes)
        self._projection, self._registration = projection, registration
        if isinstance(radiance, str | os.PathLike):
            raise EnvLightsError(
                "a map must be an array; `EnvMap.open` reads files; got"
                f" {shown(os.fspath(radiance))}"
            )
        linear = self._linear(map_array(radiance, self._notes))
        self._radiance = _read_only(_cleaning.cleaned(linear, self._notes))

    @classmethod
    def unchecked(
        cls,
        radiance: ArrayLike,
        *,
        registration: str = REGISTRATIONS[0],
        notes: Iterable[str] = (),
        white: float | None = None,
    ) -> EnvMap:
        """A map whose samples are not checked: kernels will check each, or have made it."""
        env = cls.__new__(cls)
        env._notes = list(notes)
        env._projection, env._registration = PROJECTIONS[0], registration
        env._white, env._clipped = white, None
        env._radiance = _read_only(env._linear(map_array(radiance, env._notes)))
        return env

    @classmethod
    def open(
        cls,
        path: str | os.PathLike[str],
        *,
        registration: str | None = None,
        white: float | None = None,
        max_pixels: int = MOST_PIXELS,
    ) -> EnvMap:
        """Read a map from a file.

        Parameters
        ----------
        path : path-like
            Radiance .hdr, OpenEXR, PNG, JPEG, TIFF, or whatever else OpenImageIO reads. Files of
            8 or 16 bit integers are linearised from sRGB; alpha and extra channels are ignored.
        registration : {"cell-centred", "border-sampled"}, optional
            As above. When left out, the metadata of the file decides.
        white : float, optional
            As above. It is known for files of integers.
        max_pixels : int
            A file whose header claims more pixels is refused before memory is taken. 32768x16384
            when left out.

        Returns
        -------
        EnvMap
            Its `notes` list everything that was assumed.

        Raises
        ------
        EnvLightsError
            If the file cannot be read or holds no equirectangular map.
        """
        image = read_image(path, max_pixels=max_pixels)
        if registration is None:
            registration = REGISTRATIONS[image.border_sampled]
        try:
            return cls(
                image.pixels,
                registration=registration,
                notes=image.notes,
                white=image.white if white is None else white,
            )
        except EnvLightsError as refusal:
            raise EnvLightsError(f"{os.fspath(path)}: {refusal}") from None

    @classmethod
    def from_exposures(
        cls,
        pictures: Sequence[ArrayLike | str | os.PathLike[str]],
        times: Sequence[float] | None = None,
    ) -> EnvMap:
        r"""One linear map from several exposures of a panorama (Madsen et al. 2003, figure 4).

        Every sample is taken from the exposures that show it below white, in the mean that has the
        least variance for sRGB codes. Where exposures contradict each other by more than a factor
        of 1.3, because something moved, the best one is taken alone.

        Parameters
        ----------
        pictures : sequence of path-like or array_like, shape (height, 2 * height, 3)
            Two exposures or more, from one place, sRGB-coded, in any order: files as in `open`, or
            arrays of uint8 or uint16. Arrays of floating point are linear, with white at 1.
        times : sequence of float, optional
            Exposure time of each, in seconds or any other unit: only ratios matter. When left out,
            they come from the EXIF of the files, with aperture and sensitivity.

        Returns
        -------
        EnvMap
            Radiance 1 is white at a time of 1. It has a `white` if the shortest exposure still
            reaches white. Its `notes` tell where exposures contradict each other and which do not
            fit their times.

        Raises
        ------
        EnvLightsError
            If a picture cannot be read, sizes differ, or a time is missing.

        Notes
        -----
        A sample :math:`z` of an exposure of time :math:`t` has the weight :math:`(t / z')^2`, with
        the slope :math:`z'` of the sRGB curve there: the inverse of the variance that rounding to
        codes leaves. The response is not estimated, as Debevec and Malik (1997) do: it is known.

        Examples
        --------
        >>> truth = np.full((4, 8, 3), 0.05)
        >>> truth[1, 2] = 6.0
        >>> env = EnvMap.from_exposures([np.minimum(truth * t, 1) for t in (0.1, 8.0)], (0.1, 8.0))
        >>> env.radiance[1, 1:3, 0].round(3)
        array([0.05, 6.  ], dtype=float32)
        """
        exposures = Exposures(pictures, times)
        radiance, white = exposures.merged()
        times_shown = f"{exposures.times[0]:.3g} to {exposures.times[-1]:.3g}"
        about = f"{len(exposures.times)} exposures were merged, with times from {times_shown}"
        registration = REGISTRATIONS[exposures.border_sampled]
        notes = (about, *exposures.notes)
        return cls(radiance, registration=registration, notes=notes, white=white)

    @property
    def radiance(self) -> NDArray[np.float32]:
        """Linear RGB, (height, width, 3), read-only."""
        return self._radiance

    @property
    def projection(self) -> str:
        """The layout of the sphere in the image."""
        return self._projection

    @property
    def registration(self) -> str:
        """Whether pixels are cells, or the outer ones lie on the seam and the poles."""
        return self._registration

    @property
    def is_border_sampled(self) -> bool:
        """True if the outer pixels lie on the seam and the poles."""
        return self._registration == REGISTRATIONS[1]

    @property
    def notes(self) -> tuple[str, ...]:
        """What was cleaned or assumed."""
        return tuple(self._notes)

    @property
    def white(self) -> float | None:
        """The largest value that the radiance can hold; None where that is not known.

        1.0 for files and arrays of integers.
        """
        return self._white

    @property
    def clipped_share(self) -> float:
        """Share of the sphere whose radiance was cut off.

        Where `white` is known: the pixels with a channel at white, from code 254 of 255 on. Else
        those that hold the map's largest sample, if there are several; one is the peak of a light.
        """
        return self._clipped_shares()[0]

    @property
    def clipped_flux_share(self) -> float:
        """Share of the map's luminance flux in the pixels of `clipped_share`.

        What a fit makes of that share is a lower bound.
        """
        return self._clipped_shares()[1]

    @property
    def height(self) -> int:
        """Rows."""
        return int(self._radiance.shape[0])

    @property
    def width(self) -> int:
        """Columns."""
        return int(self._radiance.shape[1])

    def probe(self, normals: ArrayLike) -> NDArray[np.float64]:
        r"""Exact irradiance of a white Lambertian probe under the whole map.

        Nothing is fitted or sampled: this is the reference for the lights of `fit`.

        Parameters
        ----------
        normals : array_like, shape (n, 3) or (3,)
            Unit normals, or one.

        Returns
        -------
        ndarray, shape (n, 3) or (3,)
            RGB irradiance in W m\ :sup:`-2`:
            :math:`E(n) = \int L(\omega) \max(0, n \cdot \omega)\, d\omega`. The radiance of the
            probe (Madsen et al. 2003, equations 1 to 3) is this over pi.

        Raises
        ------
        EnvLightsError
            If `normals` has another shape or holds a vector whose length is not 1.
        """
        rows, is_one = one_or_more("normals", normals)
        values = irradiance(self._radiance, rows, border_sampled=self.is_border_sampled)
        return values[0] if is_one else values

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        half: bool = False,
        compression: str = COMPRESSIONS[0],
    ) -> None:
        """Write the map as an OpenEXR (.exr) or Radiance (.hdr) file, whole or not at all.

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
        Primaries are those of Rec.709. A border-sampled map has the attribute ``envmap``; a
        cell-centred one must not, because readers would take its outer pixels for the border. No
        .hdr file can say that it is border-sampled: such a map becomes cells.
        """
        if map_suffix(path) == ".hdr":
            if half or compression != COMPRESSIONS[0]:
                raise EnvLightsError(f"cannot save {path}: half and compression are of .exr files")
            write_hdr(path, self.cells())
            return
        write_exr(
            path,
            self._radiance,
            half=half,
            compression=compression,
            border_sampled=self.is_border_sampled,
        )

    def rotated(self, matrix: ArrayLike) -> EnvMap:
        """The map after a rotation: what was in the direction d is then in ``matrix @ d``.

        Parameters
        ----------
        matrix : array_like, shape (3, 3)
            A rotation, in the frame of the map.

        Returns
        -------
        EnvMap
            Of the same size. Turns about the pole by whole columns lose nothing. Other turns
            average samples of each pixel, keep the flux of the map and that of each bright pixel,
            and make a border-sampled map cell-centred.

        See Also
        --------
        Rig.rotated : the same for a rig.

        Examples
        --------
        A quarter turn about the pole, from +z to +x:

        >>> env = EnvMap(np.eye(8)[:4, :, None] * np.ones(3))
        >>> turned = env.rotated([[0, 0, 1], [0, 1, 0], [-1, 0, 0]])
        >>> np.array_equal(turned.radiance, np.roll(env.radiance, -2, axis=1))
        True
        """
        radiance, is_border = resampling.rotate(
            self._radiance, rotation(matrix), border_sampled=self.is_border_sampled
        )
        registration = REGISTRATIONS[is_border]
        return EnvMap(radiance, registration=registration, notes=self._notes, white=self._white)

    def cells(self) -> NDArray[np.float32]:
        """Radiance of a cell-centred map of the same size: `radiance` itself where it is one.

        The pixels of a border-sampled map are averaged; flux is kept.
        """
        if self.is_border_sampled:
            return resampling.cells_of_borders(self._radiance)
        return self._radiance

    def repaired(self, *, irradiance: float | None = None, ratio: float | None = None) -> EnvMap:
        r"""The map with an estimate of the light that was cut off.

        The pixels that are clipped are raised, each in its own colour. How much light is missing is
        a number of yours, or an estimate with the ground as the light meter of the scene. Where it
        is missing is a guess: small parts of the plateau count for more than their solid angle, and
        so do high ones; each is brightest where it is deepest. `detect` and `fit` work on the
        result as on any map of linear radiance.

        Parameters
        ----------
        irradiance : float, optional
            Luminance of the irradiance that an upward surface really gets, in W m\ :sup:`-2` on
            the scale of the map; of a lux meter only if you know that scale.
        ratio : float, optional
            That irradiance over the one without the clipped places: two readings of a lux meter on
            the ground, one in the open, one with the sun shaded. It needs no scale.

        Returns
        -------
        EnvMap
            Without a `white`. Its last note holds the factor by which the flux was raised and where
            it comes from. Where the ground tells nothing, nothing is added, the map keeps its
            white, and the note says why.

        Raises
        ------
        EnvLightsError
            If both numbers are given, one is less than that of the map as it is, or everything that
            is clipped lies below the horizon.

        Notes
        -----
        The estimate takes the ground for one of albedo 0.2, with the mean luminance
        :math:`L` of what lies more than 3 degrees below the horizon and is not clipped, and the
        irradiance :math:`E` of an upward surface under the map as it is:
        :math:`\min(3 \max(0, \pi L / 0.2 - E), 3 F, 400\, \Omega)`, where :math:`F` is the flux
        that is not clipped and :math:`\Omega` the solid angle that is, in units of white. The rule
        is ours.

        Measured on 8-bit pictures of 17 HDR maps in eleven tones (`benchmarks/clipped_repair.py`),
        the relative RMS error of a probe at the best common scale falls from 0.43 to 0.23 (median),
        and grows by more than 0.05 in 2 %. The estimate is worthless on ground that is far from
        grey, such as snow or a dark floor, in the shade while the sun shines elsewhere, and under
        light that the ground does not see. Where :math:`\pi L / E` is from 0.7 to 1.1, a white
        floor explains the ground as well: nothing is added.

        Examples
        --------
        A sun that was cut off, over grey ground that still shows its irradiance:

        >>> sky = np.full((64, 128, 3), 0.1)
        >>> sky[12:14, 60:62] = 1.0
        >>> sky[32:] = 0.2 / np.pi * 2.0
        >>> env = EnvMap(sky, white=1.0)
        >>> print(env.repaired().notes[-1].split(":")[0])
        the flux was raised by a factor of 2.6 for what was clipped
        >>> env.repaired(irradiance=2.0).probe([[0, 1, 0]]).round(3)
        array([[2., 2., 2.]])
        """
        white = self._white
        if white is None and self.clipped_share:
            white = float(self._radiance.max())
        radiance, note, is_open = repair(
            self._radiance, self.is_border_sampled, white, irradiance, ratio
        )
        white = self._white if is_open else None
        notes = (*self._notes, note)
        return EnvMap(radiance, registration=self._registration, notes=notes, white=white)

    def __repr__(self) -> str:
        layout = f"{self.width}x{self.height} {self._projection}, {self._registration}"
        notes = f", notes: {'; '.join(self._notes)}" if self._notes else ""
        return f"EnvMap({layout}{self._clipped_in_words()}{notes})"

    def __str__(self) -> str:
        layout = f"{self.width}x{self.height} pixels, {self._projection}, {self._registration}"
        white = f"clip level {self._white:g}{self._clipped_in_words()}" if self._white else ""
        return _map_text.paragraph(self._radiance, layout, white, self._notes)

    def _clipped_in_words(self) -> str:
        """Clipped part of a map with a clip level; empty for other maps."""
        return "" if self._white is None else _map_text.clipped(*self._clipped_shares())

    def _repr_pretty_(self, printer: Any, _: bool) -> None:
        printer.text(repr(self) if printer.indentation else str(self))

    def _repr_html_(self) -> str:
        picture = _html.picture(
            _thumbnails.of_map(self._radiance), "the map, exposed for its lamps"
        )
        return _html.block("EnvMap", "", picture, _html.lines(str(self)))

    def __eq__(self, other: object) -> bool:
        """Whether both hold the same radiance in the same pixels, cut off at the same white."""
        if not isinstance(other, EnvMap):
            return NotImplemented
        layout, others = ((e.projection, e.registration, e.white) for e in (self, other))
        return layout == others and np.array_equal(self.radiance, other.radiance)

    __hash__ = None  # type: ignore[assignment]  # what is compared by its pixels

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """The radiance, so that NumPy takes a map wherever it takes an array."""
        return converted(self._radiance, dtype, copy)

    def __reduce__(self) -> tuple[Any, ...]:
        # A copy is looked through again: only its constructor closes the array to writing.
        arguments = self._projection, self._registration, self._notes, self._white
        return _copied, (self._radiance, *arguments)

    def _clipped_shares(self) -> tuple[float, float]:
        if self._clipped is None:
            self._clipped = _native.clipped_share(
                self._radiance, self.is_border_sampled, self._white
            )
        return self._clipped

    def _linear(self, array: NDArray[Any]) -> NDArray[np.float32]:
        """Linear samples of `array`; sRGB codes are clipped at 1."""
        if array.dtype.kind != "f":
            self._white = 1.0 if self._white is None else self._white
        return _cleaning.linear(array, self._notes)


#: A map, the path of its file, or its radiance as an array.
AnyMap = EnvMap | str | os.PathLike[str] | ArrayLike


def _read_only(array: NDArray[np.float32]) -> NDArray[np.float32]:
    view = array.view()
    view.flags.writeable = False
    return view


def _copied(
    radiance: NDArray[np.float32],
    projection: str,
    registration: str,
    notes: list[str],
    white: float | None = None,
) -> EnvMap:
    return EnvMap(
        radiance, projection=projection, registration=registration, notes=notes, white=white
    )


def checked_white(white: float) -> float:
    """A white, or a refusal of what none can be."""
    value = amount("white", white)
    if value == 0:
        raise EnvLightsError("white must be above 0; got 0")
    return value


def as_envmap(env: AnyMap) -> EnvMap:
    """`env` itself, or the map that an array or the path of a file stands for."""
    if isinstance(env, str | os.PathLike):
        return EnvMap.open(env)
    return env if isinstance(env, EnvMap) else EnvMap(env)


def apply_to_map(env: AnyMap, work: Callable[[EnvMap], _T]) -> tuple[EnvMap, _T]:
    """The map, and the result of `work` on it.

    The kernels that `work` calls read every sample and count those that are not radiance. Only if
    they find some is an array cleaned, and `work` called again.
    """
    if isinstance(env, EnvMap | str | os.PathLike):
        world = as_envmap(env)
        return world, work(world)
    world = EnvMap.unchecked(env)
    try:
        return world, work(world)
    except UnusableSamplesError:
        world = EnvMap(env)
        return world, work(world)
