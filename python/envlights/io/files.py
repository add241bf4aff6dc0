"""Files out, written whole or not at all."""

from __future__ import annotations

import contextlib
import os
import secrets
import shutil
import stat
from collections.abc import Callable
from pathlib import Path

from envlights._native import EnvLightsError

#: Formats of pictures; here, so that the command line can check them without loading Matplotlib.
PICTURES = (".png", ".pdf", ".svg")


def as_path(path: object) -> Path:
    """`path` as a `Path`, or a refusal."""
    try:
        return Path(path)  # type: ignore[arg-type]
    except TypeError:
        raise EnvLightsError(f"a path must be text; got {type(path).__name__}") from None


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
        target = Path(os.path.realpath(path))
        obstacle = _obstacle(target)
    except (OSError, ValueError) as error:  # a name that is too long, or holds a NUL
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

    The temporary name keeps the suffix, from which image libraries take the format.
    """
    target = check_writable(path)
    # A short random name: `path` may have the longest name there is, and threads do not collide.
    beside = target.with_name(f".{secrets.token_hex(8)}{target.suffix}")
    try:
        write(beside)
        if target.exists():
            shutil.copymode(target, beside)
        beside.replace(target)
    except OSError as error:
        raise EnvLightsError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            beside.unlink()
