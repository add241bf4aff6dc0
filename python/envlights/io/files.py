"""Files out, written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

from envlights._native import EnvLightsError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

#: Formats of pictures; here, so that the command line can check them without loading Matplotlib.
PICTURES = (".png", ".pdf", ".svg")


def as_path(path: object) -> Path:
    """`path` as a `Path`, or a refusal."""
    try:
        found = Path(path)  # type: ignore[arg-type]
        is_name = b"\0" not in os.fsencode(found)
    except TypeError:
        raise EnvLightsError(f"a path must be text; got {type(path).__name__}") from None
    except UnicodeEncodeError:  # half of a character
        is_name = False
    if not is_name:
        raise EnvLightsError(
            "a path must be text that can name a file; it holds a zero byte or half a character"
        )
    return found


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Refuse a place where no file can be written, before the work that would be lost.

    A file without any write permission is left alone, even if the user may replace it: somebody
    marked it read-only.

    Returns
    -------
    Path
        Where the file will stand: `path` with links followed.
    """
    try:
        target = Path(os.path.realpath(as_path(path)))
        obstacle = _obstacle(target)
    except (OSError, ValueError) as error:  # a name that is too long, or names no file
        obstacle = getattr(error, "strerror", None) or str(error)
    if obstacle:
        raise EnvLightsError(f"cannot write {path}: {obstacle}")
    return target


def _obstacle(target: Path) -> str:
    """Why no file can be written at `target`; empty where nothing is in the way."""
    if not target.parent.is_dir():
        return f"the folder {target.parent} does not exist"
    if target.is_dir():
        return "it is a folder; give the name of a file"
    if target.exists() and not target.is_file():
        return "it exists and is not a regular file"
    if target.exists() and not (_has_write_mark(target) and os.access(target, os.W_OK)):
        return "it exists and is marked read-only"
    if not os.access(target.parent, os.W_OK | os.X_OK):
        return f"the folder {target.parent} is read-only"
    return ""


def _has_write_mark(path: Path) -> bool:
    return bool(path.stat().st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))


def write_atomically(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Let `write` fill a file beside `path`, then move it into place in one step.

    The temporary name keeps the suffix, from which image libraries take the format. What a process
    left there that was killed while it wrote `path` is cleared away.
    """
    target = check_writable(path)
    try:
        with _file_beside(target) as beside:
            write(beside)
            if target.exists():
                shutil.copymode(target, beside)
            # All of it must be on the disk before it takes the place of the old file.
            _flush(beside)
            beside.replace(target)
        _flush(target.parent)
    except OSError as error:
        raise EnvLightsError(f"cannot write {path}: {error.strerror or error}") from error


@contextlib.contextmanager
def _file_beside(target: Path) -> Iterator[Path]:
    """The name of a new file in the folder of `target`, which is gone in the end."""
    # A short name: that of `target` may have all letters there can be.
    mark = f".{zlib.crc32(target.name.encode(errors='surrogateescape')):08x}"
    beside = target.with_name(f"{mark}-{os.urandom(4).hex()[:7]}{target.suffix}")
    for stale in target.parent.glob(f"{mark}-*"):
        _clear(stale)
    try:
        with _locked_file(beside):
            yield beside
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()


@contextlib.contextmanager
def _locked_file(beside: Path) -> Iterator[None]:
    """An empty file `beside`, locked as long as this process lives and writes it.

    Another process that looks for stale files may find it before it is locked, and remove it: then
    it has no name any more, and is made once more. Windows, which can neither lock so nor rename
    what is open, does without.
    """
    if fcntl is None:
        yield
        return
    while True:
        with beside.open("xb") as file:
            fcntl.flock(file, fcntl.LOCK_EX)
            if os.fstat(file.fileno()).st_nlink:
                yield
                return


def _clear(stale: Path) -> None:
    """Remove a file on which nobody holds a lock: the process that wrote it was killed."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError), stale.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        stale.unlink()


def _flush(path: Path) -> None:
    """Wait until a file, or the names in a folder, are on the disk, where the system can."""
    if path.is_dir() and os.name == "nt":  # Windows opens no folder
        return
    file = os.open(path, os.O_RDWR if path.is_file() else os.O_RDONLY)
    try:
        os.fsync(file)
    finally:
        os.close(file)
