"""Safe writing of files: after a failure, the old file (or no file) remains."""

from __future__ import annotations

import contextlib
import glob
import importlib.util
import os
import shutil
import stat
import struct
import tokenize
import zlib
from collections.abc import Callable, Iterator
from pathlib import Path

from envlights._common.errors import DamagedFileError, FileError, unreadable
from envlights._native import EnvLightsError

#: Errors that NumPy raises for damaged files of arrays. A damaged byte can also look like a request
#: for a password or like an unknown compression.
DAMAGE = (
    AttributeError,
    EOFError,
    KeyError,
    MemoryError,
    NotImplementedError,
    OverflowError,
    RuntimeError,
    SyntaxError,
    TypeError,
    ValueError,
    struct.error,
    tokenize.TokenError,
    zlib.error,
)

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

#: Suffixes of the map files that a folder search includes.
MAPS = (".exr", ".hdr", ".pic", ".rgbe", ".png", ".jpg", ".jpeg", ".tif", ".tiff")
#: Formats of pictures, for checks without Matplotlib.
PICTURES: tuple[str, ...] = (".png", ".pdf", ".svg")
#: End of the error message if Matplotlib is missing.
NO_MATPLOTLIB = (
    "needs Matplotlib, which is not installed; install it with `pip install 'envlights[plot]'`"
)


def can_draw() -> bool:
    """True if Matplotlib, from the extra `plot`, is installed."""
    return importlib.util.find_spec("matplotlib") is not None


def as_path(path: object) -> Path:
    """`path` as a `Path`; raises an error for anything that is not a file name."""
    try:
        result = Path(path)  # type: ignore[arg-type]
        is_name = b"\0" not in os.fsencode(result)
    except TypeError:
        raise EnvLightsError(f"a path must be text; got {type(path).__name__}") from None
    except UnicodeEncodeError:  # a lone surrogate
        is_name = False
    if not is_name:
        raise EnvLightsError(
            "a path must be text that can name a file; it holds a zero byte or half a character"
        )
    return result


def matches(pattern: str) -> list[str]:
    """Paths that match a glob pattern, sorted; existing folder names with wildcards are literal.

    Brackets are sets of characters, or themselves if nothing matches so.
    """
    path = Path(pattern)
    folder = next((each for each in path.parents if each.exists()), Path())
    rest, start = str(path.relative_to(folder)), glob.escape(str(folder))
    for each in dict.fromkeys([rest, rest.replace("[", "[[]")]):
        if found := glob.glob(str(Path(start, each)), recursive=True):  # noqa: PTH207
            return sorted(found)
    return []


def read_text(path: str | os.PathLike[str]) -> str:
    """Text of a file; raises an error if it cannot be read."""
    try:
        return as_path(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise unreadable(path, error) from None
    except UnicodeDecodeError:
        raise DamagedFileError(f"{path} is damaged or of another kind: it is not text") from None


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Raise an error if no file can be written to a path, before any work.

    A file without any write permission is refused even if its folder would allow a replacement.

    Returns
    -------
    Path
        `path` with links resolved.
    """
    try:
        target = Path(os.path.realpath(as_path(path)))
        obstacle = _obstacle(target)
    except (OSError, ValueError) as error:  # a name that is too long or invalid
        obstacle = getattr(error, "strerror", None) or str(error)
    if obstacle:
        raise FileError(f"cannot write {path}: {obstacle}")
    return target


def _obstacle(target: Path) -> str:
    """Reason why no file can be written to `target`; empty if writable."""
    with contextlib.suppress(FileNotFoundError, NotADirectoryError):
        # Raises an error for an invalid name; `exists` returns False since Python 3.14.
        target.stat()
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
    """Let `write` fill a temporary file beside `path`, then rename it in one step.

    The temporary name has the suffix of `path`, from which image libraries take the format.
    Temporary files of killed processes are removed.
    """
    target = check_writable(path)
    try:
        with _file_beside(target) as beside:
            write(beside)
            if target.exists():
                shutil.copymode(target, beside)
            # Flush to disk before the rename replaces the old file.
            _flush(beside)
            beside.replace(target)
        with contextlib.suppress(OSError):  # the file is in place already
            _flush(target.parent)
    except OSError as error:
        raise FileError(f"cannot write {path}: {error.strerror or error}") from error


def write_content(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write text or bytes; after a failure, the old file or no file remains."""
    data = content if isinstance(content, bytes) else content.encode("utf-8", "backslashreplace")
    write_atomically(path, lambda beside: beside.write_bytes(data))


@contextlib.contextmanager
def _file_beside(target: Path) -> Iterator[Path]:
    """Locked, empty temporary file in the folder of `target`, deleted at the end."""
    # Use a short name, because the name of `target` may have the maximum length.
    mark = f".{zlib.crc32(target.name.encode(errors='surrogateescape')):08x}"
    for stale in target.parent.glob(f"{mark}-*"):
        _clear(stale)
    with _locked_file(target, mark) as beside:
        try:
            yield beside
        finally:
            with contextlib.suppress(OSError):
                beside.unlink()


@contextlib.contextmanager
def _locked_file(target: Path, mark: str) -> Iterator[Path]:
    """Empty file beside `target`, locked while this process writes to it.

    Another process may remove it as stale before it is locked; then another name is tried. The
    same name would be removed by a third process that still has the first file open. Windows has
    neither such locks nor renames of open files, so there is no lock.
    """
    while True:
        beside = target.with_name(f"{mark}-{os.urandom(4).hex()[:7]}{target.suffix}")
        if fcntl is None:
            yield beside
            return
        with beside.open("xb") as file:
            with contextlib.suppress(OSError):  # some file systems have no locks
                fcntl.flock(file, fcntl.LOCK_EX)
            if os.fstat(file.fileno()).st_nlink:
                yield beside
                return


def _clear(stale: Path) -> None:
    """Delete an unlocked file that a killed process left behind."""
    if fcntl is None:
        return
    with contextlib.suppress(OSError), stale.open("rb") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        stale.unlink()


def _flush(path: Path) -> None:
    """Flush a file, or the entries of a folder, to disk, if the system supports it."""
    if path.is_dir() and os.name == "nt":  # Windows cannot open folders
        return
    file = os.open(path, os.O_RDWR if path.is_file() else os.O_RDONLY)
    try:
        os.fsync(file)
    finally:
        os.close(file)
