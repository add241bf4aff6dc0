"""Pairs on disk: a folder of EXR files."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from envlights._common import html
from envlights._common.check import check_progress, describe, first_not_finite
from envlights._common.errors import FileError
from envlights._common.files import as_path
from envlights._common.progress import progress_bar
from envlights._common.result import Result
from envlights._native import EnvLightsError
from envlights.environment.files.image_output import write_exr
from envlights.environment.files.images import read_image
from envlights.kernels import thumbnails

#: First words of the file names.
_DIRECT, _INDIRECT = "direct", "lightmap"
_FILE = re.compile(rf"({_DIRECT}|{_INDIRECT})_(.+)\.exr")

#: Path to a direct image, and path to its indirect image.
PathPair = tuple[str | os.PathLike[str], str | os.PathLike[str]]


@dataclass(frozen=True, eq=False, repr=False)
class ImagePairs(Result):
    """Direct and indirect images of the same lights, linear RGB."""

    direct: NDArray[np.float32]
    """Direct light, (k, h, w, 3)."""

    indirect: NDArray[np.float32]
    """Indirect light, (k, H, W, 3)."""

    def in_short(self) -> str:
        """Number and size of the images."""
        return f"direct {self.direct.shape}, indirect {self.indirect.shape}"

    def _html_parts(self) -> tuple[str, ...]:
        codes = thumbnails.of_pairs(self.direct, self.indirect)
        return (html.picture(codes, "the first pairs, direct light above indirect light"),)

    def save(self, folder: str | os.PathLike[str]) -> None:
        """Write files ``direct_0000.exr``, ``lightmap_0000.exr`` and so on for `read_pairs`.

        Parameters
        ----------
        folder : path-like
            Folder of the files, created if it does not exist.
        """
        try:
            as_path(folder).mkdir(exist_ok=True)
        except OSError as error:
            raise EnvLightsError(f"cannot make the folder {folder}: {error.strerror}") from None
        for k, pair in enumerate(zip(self.direct, self.indirect, strict=True)):
            for kind, image in zip((_DIRECT, _INDIRECT), pair, strict=True):
                write_exr(Path(folder, _file_name(kind, f"{k:04}")), image)


@dataclass(frozen=True, eq=False, repr=False)
class FilePairs(ImagePairs):
    """Pairs read from files.

    `indirect` is mapped from a file without a name in the folder for temporary files, ``TMPDIR``.
    So a database may be larger than memory, and the file is gone with the array. That folder should
    be on a disk; some systems keep ``/tmp`` in memory.
    """

    notes: tuple[str, ...]
    """Remarks on ignored channels of the files."""


def read_pairs(
    pairs: str | os.PathLike[str] | Iterable[PathPair], *, progress: bool | None = None
) -> FilePairs:
    """Read pairs of direct and indirect images from files.

    Parameters
    ----------
    pairs : path-like or iterable of pairs of path-like
        A folder with files ``direct_NAME.exr`` and ``lightmap_NAME.exr``, which are read in the
        order of their names; or the paths of each pair, direct light first.
    progress : bool, optional
        True: show a progress bar. Default: after a second, in a terminal or a notebook.

    Returns
    -------
    FilePairs
        Arguments of `TransferModel.fit` and `TransferModel.add`.

    Raises
    ------
    EnvLightsError
        If a file is missing, damaged, of another size than the first, or holds NaN or infinities.
        The message names the file.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> import envlights as el
    >>> room = el.synthetic.room(3, width=16)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     for k in range(3):
    ...         el.io.write_exr(Path(folder, f"direct_{k:04}.exr"), room.direct[k])
    ...         el.io.write_exr(Path(folder, f"lightmap_{k:04}.exr"), room.indirect[k])
    ...     pairs = el.read_pairs(folder)
    >>> pairs.direct.shape, pairs.indirect.shape
    ((3, 16, 16, 3), (3, 16, 16, 3))
    """
    check_progress(progress)
    is_folder = isinstance(pairs, str | os.PathLike)
    paths = _in_folder(Path(pairs)) if is_folder else _check(pairs)  # type: ignore[arg-type]
    try:
        with tempfile.TemporaryFile() as spool:
            return _read(paths, spool, progress)
    except OSError as error:
        raise FileError(
            f"cannot keep the images in a temporary file: {error.strerror or error};"
            " set TMPDIR to a folder with room for all of them"
        ) from error


def _in_folder(folder: Path) -> list[PathPair]:
    """Pairs of files in a folder, by name; raises an error for a file without a partner."""
    # List the folder.
    try:
        files = sorted(folder.iterdir())
    except (OSError, ValueError) as error:  # a name that is too long, or holds a NUL
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError(f"cannot read pairs from {folder}: {reason}; give a folder") from None
    # Sort its files into pairs.
    found: dict[str, dict[str, Path]] = {}
    for path in files:
        if match := _FILE.fullmatch(path.name):
            found.setdefault(match[2], {})[match[1]] = path
    if not found:
        raise EnvLightsError(
            f"{folder} holds no pairs; give files {_file_name(_DIRECT, 'NAME')} and"
            f" {_file_name(_INDIRECT, 'NAME')}"
        )
    # Refuse a file without a partner.
    for name, pair in found.items():
        for kind in {_DIRECT, _INDIRECT} - pair.keys():
            (partner,) = pair.values()
            raise EnvLightsError(f"{partner} has no partner: {folder / _file_name(kind, name)}")
    return [(pair[_DIRECT], pair[_INDIRECT]) for pair in found.values()]


def _file_name(kind: str, name: str) -> str:
    return f"{kind}_{name}.exr"


def _check(pairs: Iterable[Any]) -> list[PathPair]:
    # A NumPy array without axes looks iterable by its type.
    if not isinstance(pairs, Iterable) or getattr(pairs, "ndim", 1) == 0:
        raise EnvLightsError(f"pairs must be a folder or pairs of paths; got {describe(pairs)}")
    paths = list(pairs)
    for k, pair in enumerate(paths):
        if isinstance(pair, str | os.PathLike) or not hasattr(pair, "__len__") or len(pair) != 2:
            raise EnvLightsError(f"pairs must hold two paths each; number {k} is {describe(pair)}")
    if not paths:
        raise EnvLightsError("pairs is empty; give a folder or at least one pair of paths")
    return [(direct, indirect) for direct, indirect in paths]


def _read(paths: list[PathPair], spool: BinaryIO, progress: bool | None) -> FilePairs:
    """Read images one by one: small ones into memory, large ones into the file `spool`."""
    direct: list[NDArray[np.float32]] = []
    sizes: dict[str, tuple[int, ...]] = {}
    notes: dict[str, None] = {}
    for small, large in progress_bar(paths, "reading", "pair", progress):
        for kind, path in ((_DIRECT, small), (_INDIRECT, large)):
            image = read_image(path)
            pixels = _checked_pixels(path, image.pixels, sizes.setdefault(kind, image.pixels.shape))
            notes |= dict.fromkeys(f"{note} in the {kind} images" for note in image.notes)
            if kind == _DIRECT:
                direct.append(pixels)
            else:
                # Write to the file instead of a memory map: a full disk then raises an error, and
                # does not crash.
                spool.write(pixels.data)
    # Map all large images as one array.
    spool.flush()
    shape = (len(paths), *sizes[_INDIRECT])
    indirect = np.memmap(spool, np.float32, "r", shape=shape)
    return FilePairs(np.stack(direct), indirect, tuple(notes))


def _checked_pixels(
    path: str | os.PathLike[str], pixels: NDArray[np.float32], size: tuple[int, ...]
) -> NDArray[np.float32]:
    if pixels.shape != size:
        given, wanted = (f"{shape[1]}x{shape[0]}" for shape in (pixels.shape, size))
        raise EnvLightsError(f"{path} has {given} pixels, the first of its kind {wanted}")
    if bad := first_not_finite(pixels):
        row, column, value = bad
        raise EnvLightsError(
            f"{path} must be finite; it holds {value} at row {row}, column {column}"
        )
    return np.ascontiguousarray(pixels)
