"""The environment map: radiance from every direction, and the layout of its pixels."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from typing import Any, TypeVar

from numpy.typing import ArrayLike

from envlights._map_calibration import MapCalibration
from envlights._map_layouts import MapLayouts
from envlights._map_pixels import checked_clip_level
from envlights._map_repair import MapRepair
from envlights._native import EnvLightsError, UnusableSamplesError
from envlights._notes import log
from envlights.io.colour import ColourArgument
from envlights.io.exposures import merge_exposures
from envlights.io.image_output import COMPRESSIONS, map_suffix, write_exr, write_hdr
from envlights.io.images import MOST_PIXELS
from envlights.io.source import name_of
from envlights.layouts.records import REGISTRATIONS, Arguments
from envlights.layouts.sources import PictureSource, is_picture_source, read_picture

_T = TypeVar("_T")


class EnvMap(MapCalibration, MapRepair, MapLayouts):
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
    projection : str, optional
        "equirectangular", "cube", "octahedral", "octahedral-equal-area", "angular" (light probe),
        "mirror-ball", "fisheye", "cylinder" or "planar" (a photograph). When left out, shape and
        content decide, or a refusal lists the candidates. Other layouts than equirectangular are
        converted to it; see `source`.
    faces : str, optional
        Order of the faces of a cube: "opengl" (also of DirectX, Vulkan, Unity), "openexr",
        "py360convert", "pannellum", "directxtex", or the name of a cross. When left out, their
        edges decide.
    registration : {"cell-centred", "border-sampled"}, optional
        "cell-centred": a pixel covers the cell around its centre, as in most files.
        "border-sampled": the outer pixels lie on the seam and the poles, as in OpenEXR files with
        the `envmap` attribute.
    mapping : {"equidistant", "equisolid", "stereographic", "orthographic"}, optional
        Mapping of a fisheye.
    fov : float, optional
        Field of view in degrees: horizontally, or across the circle of a fisheye.
    horizon : float, optional
        Row of elevation 0 in a cylinder or a part of a panorama; the middle when left out.
    circle : array_like, shape (3,), optional
        Centre x, centre y and radius of a fisheye or mirror ball, in pixels.
    towards : array_like, shape (3,), optional
        Direction of the centre of a circle or a photograph; +z when left out.
    eye : {"left", "right"}, optional
        Half of a stereo panorama.
    width : int, optional
        Columns of the map. When left out, 4 times the side of a cube's face, or such that its cells
        are as large as the pixels of the picture.
    notes : str or iterable of str
        Remarks on the map's origin.
    white : float, optional
        Clip level: the largest value that the radiance could hold, such as 1.0 for a linearised
        picture. Known for uint8 and uint16. Detection treats pixels at the clip level as lights of
        unknown brightness; see `detect_tree`.
    seen : array_like, shape of the array without channels, optional
        Share of each pixel that the picture shows, from 0 to 1. The radiance is multiplied by it
        already; pixels of share 0 become black. `filled` has radiance for them.
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

    @classmethod
    def open(
        cls,
        path: PictureSource,
        *,
        projection: str | None = None,
        faces: str | None = None,
        registration: str | None = None,
        mapping: str | None = None,
        fov: float | None = None,
        horizon: float | None = None,
        circle: ArrayLike | None = None,
        towards: ArrayLike | None = None,
        eye: str | None = None,
        width: int | None = None,
        white: float | None = None,
        colour: ColourArgument | None = None,
        part: str | int | None = None,
        channels: str | Sequence[str] | None = None,
        max_pixels: int = MOST_PIXELS,
        any_format: bool = False,
    ) -> EnvMap:
        """Read a map from a file, or a cube from six.

        Parameters
        ----------
        path : path-like, bytes or file object
            Radiance .hdr, OpenEXR, PNG, JPEG or TIFF; the first bytes decide. "-" is the standard
            input; addresses like ``s3://`` are read by fsspec, if it is installed. The colour space
            of the file is converted to linear Rec.709: transfer curve, ICC profile, primaries.
            Integers without a statement are sRGB. What alpha or a crop hides is black; see `seen`.
            Six faces of a cube: a list, a mapping, a folder, or a name like ``sky_{face}.hdr``.
        projection, faces, registration, mapping, fov, horizon, circle, towards, eye, width
            Layout of the picture; see `EnvMap`. When left out, the statement of `Picture.save` or
            other metadata of the file decide, then names, shape and content.
        white : float, optional
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
            True: try all formats of OpenImageIO on other files, DDS among them. Not for files of
            strangers, because these readers had memory faults.

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
        arguments = Arguments(
            projection, faces, registration, mapping, fov, horizon, circle, towards, eye
        )
        arguments.check()
        image = read_picture(
            path,
            colour=colour,
            part=part,
            channels=channels,
            max_pixels=max_pixels,
            any_format=any_format,
        )
        env = cls.__new__(cls)
        env._notes = list(image.notes)
        env._white = image.white if white is None else checked_clip_level(white)
        env._units, env._ev100 = image.units, image.ev100
        try:
            env._set_pixels(image.pixels, image.seen, image.hints, arguments, width)
        except EnvLightsError as refusal:
            raise EnvLightsError(f"{name_of(path)}: {refusal}") from None
        log(env._notes)
        return env

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
            Radiance 1 is the clip level at an exposure time of 1. `white` is set if the shortest
            exposure is still clipped. `notes` report white below 254, a response other than sRGB, a
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
        merged = merge_exposures(pictures, times, response)
        registration = REGISTRATIONS[merged.border_sampled]
        env = cls(
            merged.radiance, registration=registration, notes=merged.notes, white=merged.white
        )
        env._ev100 = merged.ev100
        return env

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
        in cd/m2 the attribute ``whiteLuminance``, which `open` reads. A .hdr file cannot hold them,
        so such a map is converted to cells and loses its units; a sample above 1.7e38 is refused.
        The notes of the map become comments of the file. `open` reads those on estimates, such as
        that of `repaired`.
        """
        if map_suffix(path) == ".hdr":
            if half or compression != COMPRESSIONS[0]:
                raise EnvLightsError(f"cannot save {path}: half and compression are of .exr files")
            write_hdr(path, self.cells(), comments=self._notes)
            return
        write_exr(
            path,
            self._radiance,
            half=half,
            compression=compression,
            environment="latlong" if self.is_border_sampled else "",
            comments=self._notes,
            units=self._units,
        )


#: Map, its file as path, bytes or file object, six files of a cube, or radiance as an array.
AnyMap = EnvMap | PictureSource | ArrayLike


def as_envmap(env: Any) -> EnvMap:
    """Map of an `AnyMap`; a map is returned as it is."""
    if is_picture_source(env):
        return EnvMap.open(env)
    return env if isinstance(env, EnvMap) else EnvMap(env)


def apply_to_map(env: Any, work: Callable[[EnvMap], _T]) -> tuple[EnvMap, _T]:
    """Map of an `AnyMap`, and the result of `work` on it.

    An array is cleaned only if a kernel refuses it.

    Kernels read every sample anyway and refuse those that are not radiance, so the usual array
    needs no check of its own.
    """
    if isinstance(env, EnvMap) or is_picture_source(env):
        world = as_envmap(env)
        return world, work(world)
    world = EnvMap.unchecked(env)
    try:
        return world, work(world)
    except UnusableSamplesError:
        world = EnvMap(env)
        return world, work(world)
