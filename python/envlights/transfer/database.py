"""Pairs on disk: a folder of EXR files, read one after the other."""

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
from tqdm import tqdm

from envlights._native import EnvLightsError
from envlights._result import Result
from envlights.io.images import read_image

#: How the files of a folder are called.
_DIRECT, _INDIRECT = "direct", "lightmap"
_NAME = re.compile(rf"({_DIRECT}|{_INDIRECT})_(.+)\.exr")

#: A path to an image of direct light, and one to the indirect light.
PathPair = tuple[str | os.PathLike[str], str | os.PathLike[str]]


@dataclass(frozen=True, eq=False, repr=False)
class FilePairs(Result):
    """Pairs that were read from files.

    `indirect` is mapped from a file without a name in the folder for temporary files, ``TMPDIR``,
    which is gone with the array: a database that is larger than memory fits. That folder should be
    on a disk; some systems keep ``/tmp`` in memory.
    """

    direct: NDArray[np.float32]
    """Direct light, (k, h, w, 3)."""

    indirect: NDArray[np.float32]
    """Indirect light, (k, H, W, 3)."""

    notes: tuple[str, ...]
    """What was left out of the files."""

    def in_short(self) -> str:
        """How many images there are, and how large."""
        return f"direct {self.direct.shape}, indirect {self.indirect.shape}"


def read_pairs(
    pairs: str | os.PathLike[str] | Iterable[PathPair], *, progress: bool = False
) -> FilePairs:
    """Pairs of images of direct and indirect light, from files.

    Parameters
    ----------
    pairs : path-like or iterable of pairs of path-like
        A folder with files ``direct_NAME.exr`` and ``lightmap_NAME.exr``, taken in the order of
        their names; or the paths of each pair, the direct light first.
    progress : bool
        Show a progress bar on stderr.

    Returns
    -------
    FilePairs
        What `TransferModel.fit` and `TransferModel.add` take.

    Raises
    ------
    EnvLightsError
        If a file is missing, damaged, of another size than the first, or holds NaN or infinities;
        the sentence names it.

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
    is_folder = isinstance(pairs, str | os.PathLike)
    paths = _in_folder(Path(pairs)) if is_folder else _checked(pairs)  # type: ignore[arg-type]
    try:
        with tempfile.TemporaryFile() as spool:
            return _read(paths, spool, progress)
    except OSError as error:
        raise EnvLightsError(
            f"cannot keep the images in a temporary file: {error.strerror or error};"
            " set TMPDIR to a folder with room for all of them"
        ) from error


def _in_folder(folder: Path) -> list[PathPair]:
    """The pairs of a folder by name, or a refusal that names the file without a partner."""
    try:
        files = sorted(folder.iterdir())
    except (OSError, ValueError) as error:  # a name that is too long, or holds a NUL
        reason = getattr(error, "strerror", None) or str(error)
        raise EnvLightsError(f"cannot read pairs from {folder}: {reason}; give a folder") from None
    found: dict[str, dict[str, Path]] = {}
    for path in files:
        if match := _NAME.fullmatch(path.name):
            found.setdefault(match[2], {})[match[1]] = path
    if not found:
        raise EnvLightsError(
            f"{folder} holds no pairs; give files {_DIRECT}_NAME.exr and {_INDIRECT}_NAME.exr"
        )
    for name, pair in found.items():
        for kind in {_DIRECT, _INDIRECT} - pair.keys():
            (partner,) = pair.values()
            raise EnvLightsError(f"{partner} has no partner: {folder / f'{kind}_{name}.exr'}")
    return [(pair[_DIRECT], pair[_INDIRECT]) for pair in found.values()]


def _checked(pairs: Iterable[Any]) -> list[PathPair]:
    if not isinstance(pairs, Iterable):
        raise EnvLightsError(f"pairs must be a folder or pairs of paths; got {pairs!r}")
    paths = list(pairs)
    for k, pair in enumerate(paths):
        if isinstance(pair, str | os.PathLike) or not hasattr(pair, "__len__") or len(pair) != 2:
            raise EnvLightsError(f"pairs must hold two paths each; number {k} is {pair!r}")
    if not paths:
        raise EnvLightsError("pairs is empty; give a folder or at least one pair of paths")
    return [(direct, indirect) for direct, indirect in paths]


def _read(paths: list[PathPair], spool: BinaryIO, progress: bool) -> FilePairs:
    """Images one after the other: the small ones in memory, the large ones through `spool`."""
    direct: list[NDArray[np.float32]] = []
    sizes: dict[str, tuple[int, ...]] = {}
    notes: dict[str, None] = {}
    for small, large in tqdm(paths, desc="reading", unit="pair", disable=not progress):
        for kind, path in ((_DIRECT, small), (_INDIRECT, large)):
            image = read_image(path)
            pixels = _fitting(path, image.pixels, sizes.setdefault(kind, image.pixels.shape))
            notes |= dict.fromkeys(f"{note} in the {kind} images" for note in image.notes)
            if kind == _DIRECT:
                direct.append(pixels)
            else:
                # Written, not through a map: a full disk is then an error and no crash.
                spool.write(pixels.data)
    spool.flush()
    shape = (len(paths), *sizes[_INDIRECT])
    indirect = np.memmap(spool, np.float32, "r", shape=shape)
    return FilePairs(np.stack(direct), indirect, tuple(notes))


def _fitting(
    path: str | os.PathLike[str], pixels: NDArray[np.float32], size: tuple[int, ...]
) -> NDArray[np.float32]:
    """The pixels of a file, or a refusal that names it."""
    if pixels.shape != size:
        seen, wanted = (f"{shape[1]}x{shape[0]}" for shape in (pixels.shape, size))
        raise EnvLightsError(f"{path} has {seen} pixels, the first of its kind {wanted}")
    bad = np.argwhere(~np.isfinite(pixels))
    if len(bad):
        row, column, _ = bad[0]
        value = pixels[tuple(bad[0])]
        raise EnvLightsError(
            f"{path} must be finite; it holds {value} at row {row}, column {column}"
        )
    return np.ascontiguousarray(pixels)
