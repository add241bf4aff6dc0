"""Rows of a batch as JSON lines, which stay valid if a process is killed.

A row is one `write` to a file that is open for appending. Once it returns, the system has the line,
so a killed process loses nothing; at most its last line is torn, and the next start cuts it off. A
crash of the machine may lose the lines of the last seconds; their maps are done again. `fsync` for
each line would wait for the disk as long as a small fit takes.

A line of claims names files before they are written, so that those of other programs are known.
"""

from __future__ import annotations

import io
import json
import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from time import monotonic
from typing import IO, Any, NamedTuple

from envlights._common.errors import FileError
from envlights._common.files import check_writable, write_atomically
from envlights._common.tables import json_lines
from envlights._native import EnvLightsError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

#: Name of the file of rows in the folder of a batch.
JOURNAL = "batch.jsonl"
#: First key of a row, which identifies also an incomplete row.
_NAME = re.compile(rb'^\{"name": ("(?:[^"\\]|\\.)*")')
#: Keys of each row.
_KEYS = {"name", "source", "sha256", "what", "options", "suffix"}
#: Seconds between flushes to disk: the most that a system crash can lose.
_SYNC_SECONDS = 5.0


#: Prefixes of journal lines; a killed process may leave an incomplete line.
_STARTS = (b'{"name": ', b'{"claims": ')


def row_of_line(line: bytes) -> dict[str, Any] | None:
    """Row in a line; None for claims, damaged lines, and lines of other programs."""
    try:
        row = json.loads(line)
        return row if row.keys() >= _KEYS else None
    except (ValueError, AttributeError, RecursionError):
        return None


def _is_json(line: bytes) -> bool:
    try:
        json.loads(line)
    except (ValueError, RecursionError):
        return False
    return True


def _claims_of_line(line: bytes) -> list[str] | None:
    """File names claimed in a line; None for other lines."""
    try:
        data = json.loads(line)
        return [str(each) for each in data["claims"]] if data.keys() == {"claims"} else None
    except (ValueError, AttributeError, TypeError, RecursionError):
        return None


class Entry(NamedTuple):
    """Last row of a source; rows of this run have only a name and a start, to save memory."""

    name: str
    start: int
    sha256: str | None = None
    """Hash of the map; None after a failure, so that the map is tried again."""

    method: tuple[str, str, str | None] | None = None
    """Method, options and file suffix."""

    file: str | None = None


class Journal:
    """Rows in a file of the folder, or in memory if there is no folder."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._path = Path(JOURNAL) if folder is None else folder / JOURNAL
        self._file = io.BytesIO() if folder is None else _lock_file(self._path)
        self._end = 0
        self._claims: set[str] = set()
        """Files that this batch may write, except those of rows of this run."""
        self._torn: set[bytes] = set()
        self._synced = monotonic()
        self.entries: dict[str, Entry] = {}
        """Last row of each source."""
        try:
            self._recover()
        except EnvLightsError:
            self.close()
            raise

    def _recover(self) -> None:
        """Read the rows of earlier runs, and cut off an incomplete line."""
        self._file.seek(0)
        whole, others = 0, 0
        for line in self._file:
            if not line.endswith(b"\n"):
                is_torn = any(line.startswith(each[: len(line)]) for each in _STARTS)
                others += not is_torn or _is_json(line)
                self._torn.update(_NAME.findall(line))
                break
            if not self._note(line, whole):
                # A system crash damages lines; a complete line without a row belongs to another
                # program.
                others += _is_json(line) or not (self.entries or self._claims)
                self._torn.update(_NAME.findall(line))
            whole += len(line)
        if others:
            raise FileError(
                f"{self._path} has lines that are no rows of a batch, so it may be the file of"
                " another program; give another folder, or move it away"
            )
        self._file.truncate(whole)
        self._end = whole

    def _note(self, line: bytes, start: int) -> bool:
        """Store the file position of a row, or claims; False for lines of other programs."""
        if (claims := _claims_of_line(line)) is not None:
            self._claims.update(claims)
            return True
        if (row := row_of_line(line)) is None:
            return False
        sha256 = None if row.get("failure") else row["sha256"]
        method = (row["what"], row["options"], row["suffix"])
        entry = Entry(row["name"], start, sha256, method, row.get("file"))
        self.entries[row["source"]] = entry
        self._claims.update([entry.file] if entry.file else [])
        return True

    def claim(self, name: str, files: Iterable[str]) -> frozenset[str]:
        """Claim output files for a map; return those that this batch may write."""
        if self._folder is None:
            return frozenset()
        if json.dumps(name).encode() in self._torn:
            self._claims.update(files)
        new = [
            file
            for file in files
            if file not in self._claims and not os.path.lexists(self._folder / file)
        ]
        if new:
            self._write(json_lines([{"claims": new}]).encode())
            self._claims.update(new)
        return frozenset(file for file in files if file in self._claims)

    def finished_hash(
        self, source: str, name: str, method: tuple[str, str, str | None], files: Iterable[str]
    ) -> str | None:
        """SHA-256 of a map whose row and files exist for the same method; otherwise None."""
        entry = self.entries.get(source)
        if entry is None or entry.method != method or entry.name != name:
            return None
        if entry.file is None or self._folder is None:
            return entry.sha256
        return entry.sha256 if all((self._folder / file).exists() for file in files) else None

    def append(self, row: dict[str, Any]) -> None:
        """Write a complete row; the file of its map must already be on disk.

        A source has one row in a run.
        """
        start = self._end
        self._write(json_lines([row]).encode())
        self.entries[row["source"]] = Entry(row["name"], start)
        self._claims.discard(row.get("file"))

    def _write(self, line: bytes) -> None:
        """Append a line in a single write; raises an error if the disk is full."""
        sink = getattr(self._file, "raw", self._file)  # a buffer would be written again at the end
        try:
            sink.seek(0, io.SEEK_END)
            rest = memoryview(line)
            while rest:
                rest = rest[sink.write(rest) :]
            if self._folder is not None and monotonic() - self._synced > _SYNC_SECONDS:
                os.fsync(self._file.fileno())
                self._synced = monotonic()
        except OSError as error:
            raise FileError(
                f"cannot write {self._path}: {error.strerror}; what is finished stays, so start"
                " the batch again when there is room"
            ) from None
        self._end += len(line)

    def lines(self) -> Iterator[bytes]:
        """Last row of each source, sorted by name."""
        for entry in sorted(self.entries.values()):
            self._file.seek(entry.start)
            yield self._file.readline()

    def finish(self) -> bytes:
        """Compact the file to the last row per source, sorted by name; return rows in memory."""
        if self._folder is None:
            return b"".join(self.lines())
        write_atomically(self._folder / JOURNAL, self._write_lines)
        return b""

    def _write_lines(self, path: Path) -> None:
        """Write the rows, and claims on files that no row names."""
        named = {entry.file for entry in self.entries.values()}
        others = sorted(self._claims - named)
        claims = [each for each in others if self._folder and (self._folder / each).exists()]
        with path.open("wb") as file:
            file.writelines(self.lines())
            file.write(json_lines([{"claims": claims}] if claims else []).encode())

    def close(self) -> None:
        """Close the file, so that another batch can use the folder."""
        self._file.close()


def _lock_file(path: Path) -> IO[bytes]:
    """Open file of rows, locked for one batch; raises an error for a second batch in the folder."""
    check_writable(path)
    try:
        file = path.open("a+b")
    except OSError as error:
        raise EnvLightsError(f"cannot write {path}: {error.strerror}") from None
    if fcntl is None:
        return file
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise EnvLightsError(
            f"another batch writes to the folder {path.parent}; wait for its end, or give another"
        ) from None
    except OSError:  # some file systems have no locks
        pass
    return file
