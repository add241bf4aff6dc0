"""Pictures in any projection, and their files."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from envlights._common import html
from envlights._common.arrays import convert
from envlights._common.check import check_choice
from envlights._common.files import as_path
from envlights._common.units import OWN_SCALE
from envlights._native import EnvLightsError
from envlights.environment.files.image_output import (
    COMPRESSIONS,
    PICTURE_SUFFIXES,
    map_suffix,
    with_alpha,
    write_exr,
    write_hdr,
    write_png,
    write_tiff,
)
from envlights.environment.layouts.attribute import line_of
from envlights.environment.layouts.conventions import CONVENTIONS, CROSSES
from envlights.environment.layouts.faces import (
    ARRANGEMENTS,
    arranged_faces,
    faces_of_cross,
    split_strip,
    stored_faces,
    upright_faces,
)
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.kernels import thumbnails

#: Placeholder for the face name in a path.
PLACEHOLDER = "{face}"
#: Smallest coverage of a pixel whose radiance is known; below it, rounding dominates.
_LEAST_SHARE = 0.1
#: Textures that cannot be written here, and programs that can.
_TEXTURES = {
    ".dds": "`texassemble cube` of DirectXTex makes one of six files",
    ".ktx": "`toktx --cubemap` of KTX-Software makes one of six files",
    ".ktx2": "`ktx create --cubemap` of KTX-Software makes one of six files",
}


@dataclass(frozen=True, eq=False)
class Picture:
    """A picture of radiance in any projection.

    `numpy.asarray(picture)` gives the samples as they are saved.

    Examples
    --------
    >>> from envlights.environment.layouts.picture_layout import cube
    >>> picture = picture_of(np.ones((48, 8, 3)), cube(8), faces="opengl")
    >>> picture
    Picture(8x48 cube, cell-centred, faces in the order of OpenGL)
    """

    array: NDArray[np.float32]
    """Linear RGB, (height, width, 3); of a cube its faces, in the order of `faces`."""

    layout: PictureLayout
    """Projection; for a cube, that of its upright faces: front, right, back, left, up, down."""

    faces: str = ""
    """Convention of the faces of a cube; empty for other projections."""

    coverage: NDArray[np.float32] | None = None
    """Coverage of each sample, 0 to 1, (height, width); None if complete."""

    notes: tuple[str, ...] = ()
    """Notes on the origin, which are saved as comments of a file."""

    arrangement: str = ARRANGEMENTS[0]
    """Arrangement of the faces of a cube in `array`: "stack", "strip" or a cross."""

    units: str = OWN_SCALE
    """Unit of the samples; see `EnvMap.units`."""

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of `array`: (height, width, 3)."""
        return self.height, self.width, 3

    @property
    def height(self) -> int:
        """Number of rows."""
        return int(self.array.shape[0])

    @property
    def width(self) -> int:
        """Number of columns."""
        return int(self.array.shape[1])

    def __array__(self, dtype: Any = None, copy: bool | None = None) -> NDArray[Any]:
        """Samples, for `numpy.asarray`."""
        return convert(self.array, dtype, copy)

    def __repr__(self) -> str:
        parts = [f"{self.width}x{self.height} {self.layout.kind}"]
        if self.layout.kind in ("cube", "equirectangular"):
            parts.append("border-sampled" if self.layout.border_sampled else "cell-centred")
        if self.layout.mapping:
            parts.append(self.layout.mapping)
        if self.arrangement in CROSSES:
            parts.append(CROSSES[self.arrangement].title)
        elif self.faces:
            parts.append(f"faces in the order of {CONVENTIONS[self.faces].title}")
        return f"Picture({', '.join(parts)})"

    def _repr_html_(self) -> str:
        drawn = self.array
        if self.faces:
            drawn = arranged_faces(self._upright(), self.faces, "horizontal-cross")
        shown = html.picture(thumbnails.of_map(drawn), f"picture: {self.layout.kind}")
        return html.block("Picture", repr(self)[len("Picture(") : -1], shown)

    def save(
        self,
        path: str | os.PathLike[str],
        *,
        arrangement: str | None = None,
        half: bool = False,
        compression: str = "zip",
    ) -> tuple[Path, ...]:
        """Write one file, or one for each face of a cube.

        Parameters
        ----------
        path : path-like
            A file with the suffix ``.exr``, ``.hdr``, ``.tif`` (32-bit floats) or ``.png`` (16-bit
            sRGB, for radiance up to 1). With ``{face}`` in its name, or for a folder, six files,
            named as usual for the order of the faces: ``px nx py ny pz nz``.
        arrangement : {"stack", "strip", "horizontal-cross", "vertical-cross", ...}
            Arrangement of the faces of a cube in one file: 1:6, 6:1, 4:3 or 3:4. When left out,
            that of the picture.
        half, compression
            For .exr; see `EnvMap.save`.

        Returns
        -------
        tuple of Path
            The written files.

        Raises
        ------
        EnvLightsError
            If the suffix is another, a sample is too large for the format, or a file cannot be
            written.

        Notes
        -----
        A line of the file's description, ``envlights:layout=...``, states the layout, so that
        `EnvMap.open` reads a single file without arguments.

        The stack of a border-sampled cube in the order of OpenEXR, and a border-sampled
        equirectangular picture, get the attribute ``envmap`` of OpenEXR. `coverage` becomes the
        alpha of .exr files; in others, what is not seen is black.
        """
        if arrangement is not None:
            check_choice("arrangement", arrangement, ARRANGEMENTS)
        options: dict[str, Any] = {"half": half, "compression": compression}
        options["units"] = self.units
        files = self._face_files(path)
        if files:
            if arrangement not in (None, "stack"):
                raise EnvLightsError(
                    f"arrangement={arrangement!r} is of one file; got {path}, which names six"
                )
            stored = stored_faces(self._with_alpha()._upright(), self.faces)
            for file, face in zip(files, stored, strict=True):
                _write(file, face, (repr(self), *self.notes), options)
            return files
        arrangement = self.arrangement if arrangement is None else arrangement
        environment = self._environment(arrangement)
        array = self._with_alpha()._arranged_array(arrangement)
        faces = arrangement if arrangement in CROSSES else self.faces
        stated = line_of(self.layout, array.shape[:2], faces)
        _write(path, array, (repr(self), *stated, *self.notes), options, environment)
        return (as_path(path),)

    def _with_alpha(self) -> Picture:
        """Picture whose array has the coverage as a fourth channel, unless it is complete."""
        return replace(self, array=with_alpha(self.array, self.coverage), coverage=None)

    def _face_files(self, path: str | os.PathLike[str]) -> tuple[Path, ...]:
        """Paths of six files; empty if `path` names a single file."""
        target = as_path(path)
        if target.is_dir():
            target = target / f"{PLACEHOLDER}.exr"
        if PLACEHOLDER not in target.name:
            return ()
        if not self.faces:
            raise EnvLightsError(
                f"cannot save a picture of the projection {self.layout.kind} as {path}: six files"
                " are of cubes; give the name of one file"
            )
        names = CONVENTIONS[self.faces].names
        return tuple(target.with_name(target.name.replace(PLACEHOLDER, name)) for name in names)

    def _arranged_array(self, arrangement: str) -> NDArray[np.float32]:
        if arrangement == self.arrangement:
            return self.array
        if not self.faces:
            raise EnvLightsError(
                f"arrangement={arrangement!r} is of cubes; got a picture of the projection"
                f" {self.layout.kind}; leave it out"
            )
        return np.ascontiguousarray(arranged_faces(self._upright(), self.faces, arrangement))

    def _upright(self) -> NDArray[np.float32]:
        """Upright faces, (6, n, n, 3), in the order of `FACES`."""
        if self.arrangement in CROSSES:
            return faces_of_cross(self.array, self.arrangement)
        return upright_faces(split_strip(self.array), self.faces)

    def _environment(self, arrangement: str) -> str:
        """Environment attribute for the file; empty if no value fits."""
        if not self.layout.border_sampled:
            return ""
        if self.layout.is_whole_sphere and self.width == 2 * self.height:
            return "latlong"
        is_stack = arrangement == "stack" and self.faces == "openexr"
        return "cube" if is_stack else ""


def picture_of(
    samples: NDArray[Any],
    layout: PictureLayout,
    *,
    faces: str = "opengl",
    coverage: NDArray[Any] | None = None,
    notes: tuple[str, ...] = (),
    arrangement: str = ARRANGEMENTS[0],
) -> Picture:
    """Picture from samples in the given layout.

    Parameters
    ----------
    samples : ndarray, shape (layout.height, layout.width, 3)
        Linear RGB; of a cube, upright faces in our order.
    layout : PictureLayout
        Projection of the samples.
    faces : str
        Convention of a cube's faces in the picture: one of `CONVENTIONS`.
    coverage : ndarray, optional
        Fraction of each sample that is seen.
    notes : tuple of str
        Remarks on the origin.
    arrangement : str
        Arrangement of a cube's faces in the picture: one of `ARRANGEMENTS`.
    """
    array = np.ascontiguousarray(samples, np.float32)
    fraction = None if coverage is None else np.ascontiguousarray(coverage, np.float32)
    if layout.kind != "cube":
        return Picture(array, layout, "", fraction, notes)
    check_choice("faces", faces, tuple(CONVENTIONS))
    check_choice("arrangement", arrangement, ARRANGEMENTS)
    array = _in_arrangement(array, faces, arrangement)
    fraction = None if fraction is None else _in_arrangement(fraction, faces, arrangement)
    return Picture(array, layout, faces, fraction, notes, arrangement)


def straight(picture: Picture) -> Picture:
    """Picture whose radiance is divided by its coverage; the coverage becomes 1 or 0.

    The border of a photograph lies inside pixels of its map. Without this, it comes back darker.
    """
    if picture.coverage is None:
        return picture
    known = picture.coverage >= _LEAST_SHARE
    fraction = np.where(known, picture.coverage, np.float32(1))[..., None]
    array = np.where(known[..., None], picture.array / fraction, np.float32(0))
    return replace(picture, array=array, coverage=None if known.all() else known.astype(np.float32))


def _in_arrangement(stack: NDArray[Any], faces: str, arrangement: str) -> NDArray[Any]:
    """Upright faces rearranged for a convention or a cross."""
    return np.ascontiguousarray(arranged_faces(split_strip(stack), faces, arrangement))


def check_picture_path(path: str | os.PathLike[str]) -> None:
    """Raise an error for a path whose suffix `Picture.save` cannot write."""
    target = as_path(path)
    suffix = target.suffix.lower()
    if suffix in _TEXTURES:
        raise EnvLightsError(
            f"cannot save a picture as {path}: the libraries here do not write {suffix} textures;"
            f" save six .exr files, and {_TEXTURES[suffix]}"
        )
    if target.is_dir():
        return
    if not suffix:
        raise EnvLightsError(
            f"cannot save a picture as {path}: there is no such folder; make it first, or give the"
            " name of a file"
        )
    map_suffix(target, PICTURE_SUFFIXES, "a picture")


def _write(
    path: str | os.PathLike[str],
    array: NDArray[np.float32],
    comments: tuple[str, ...],
    options: dict[str, Any],
    environment: str = "",
) -> None:
    """Write a file in the format of its suffix."""
    check_picture_path(path)
    suffix = as_path(path).suffix.lower()
    if suffix == ".exr":
        write_exr(path, array, environment=environment, comments=comments, **options)
        return
    if options["half"] or options["compression"] != COMPRESSIONS[0]:
        raise EnvLightsError(f"cannot save {path}: half and compression are of .exr files")
    write = {".hdr": write_hdr, ".png": write_png}.get(suffix, write_tiff)
    write(path, array[..., :3], comments=comments)
