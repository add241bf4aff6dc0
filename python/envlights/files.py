"""Files out: whole or not at all."""

from __future__ import annotations

import os
import stat
from collections.abc import Callable
from pathlib import Path

from envlights._native import EnvLightsError


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Refuse a place where no file can be written, before the work that would be lost.

    A file without any permission to write is left alone even where the user is allowed to
    replace it: somebody marked it so.

    Returns
    -------
    Path
        Where the file will stand: `path` with links followed.
    """
    target = Path(os.path.realpath(path))
    if not target.parent.is_dir():
        raise EnvLightsError(f"cannot write {path}: the folder {target.parent} does not exist")
    if target.is_dir():
        raise EnvLightsError(f"cannot write {path}: it is a folder; give the name of a file")
    if target.exists() and not target.is_file():
        raise EnvLightsError(f"cannot write {path}: it exists and is no regular file")
    if target.exists() and not (_has_write_mark(target) and os.access(target, os.W_OK)):
        raise EnvLightsError(f"cannot write {path}: it exists and is marked read-only")
    if not os.access(target.parent, os.W_OK | os.X_OK):
        raise EnvLightsError(f"cannot write {path}: the folder {target.parent} is read-only")
    return target


def _has_write_mark(path: Path) -> bool:
    return bool(path.stat().st_mode & (stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))


def write_atomically(path: str | os.PathLike[str], write: Callable[[Path], object]) -> None:
    """Let `write` fill a file beside `path`, then put it in place in one move.

    The temporary name keeps the suffix, which tells image libraries the format.
    """
    target = check_writable(path)
    beside = target.with_name(f".{target.stem}.{os.getpid()}{target.suffix}")
    try:
        write(beside)
        beside.replace(target)
    except OSError as error:
        raise EnvLightsError(f"cannot write {path}: {error.strerror or error}") from error
    finally:
        beside.unlink(missing_ok=True)
