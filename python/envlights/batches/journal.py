"""Rows of a batch as lines of JSON, which a killed process leaves whole.

A row is one `write` to a file that is open for appending. Once it returns, the system has the line,
so a killed process loses nothing; at most its last line is torn, and the next start cuts it off. A
crash of the machine may lose the lines of the last seconds; their maps are done again. `fsync` for
each line would wait for the disk as long as a small fit takes.
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import IO, Any, NamedTuple

from envlights._common.files import check_writable, write_atomically
from envlights._common.tables import json_lines
from envlights._native import EnvLightsError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

#: Name of the file of rows in the folder of a batch.
JOURNAL = "batch.jsonl"
#: Most seconds of rows that a crash of the machine can lose.
_SYNC_SECONDS = 5.0


class Entry(NamedTuple):
    """Last row of a source, without its numbers."""

    name: str
    sha256: str | None
    """Hash of the map; None after a failure, so that it is tried again."""

    method: tuple[str, str, str | None]
    """Method, options and suffix of the file."""

    file: str | None
    start: int
    length: int


class Journal:
    """Rows in a file of the folder, or in memory without a folder."""

    def __init__(self, folder: Path | None) -> None:
        self._folder = folder
        self._file = io.BytesIO() if folder is None else _lock_file(folder / JOURNAL)
        self._synced = monotonic()
        self.entries: dict[str, Entry] = {}
        """Last row of each source."""
        self._recover()

    def _recover(self) -> None:
        """Read the rows of earlier runs, and cut off a torn line."""
        self._file.seek(0)
        whole = 0
        for line in self._file:
            if not line.endswith(b"\n"):
                break
            self._note(line, whole)
            whole += len(line)
        self._file.truncate(whole)
        self._file.seek(whole)

    def _note(self, line: bytes, start: int) -> None:
        """Keep the place of a row; a line that is damaged is left out, so its map is done again."""
        try:
            row = json.loads(line)
            sha256 = None if row.get("failure") else row["sha256"]
            method = (row["what"], row["options"], row["suffix"])
            entry = Entry(row["name"], sha256, method, row.get("file"), start, len(line))
            self.entries[row["source"]] = entry
        except (ValueError, KeyError, TypeError, AttributeError):
            return

    def finished_hash(
        self, source: str, name: str, method: tuple[str, str, str | None]
    ) -> str | None:
        """SHA-256 of a map whose row and file are there for the same method, or None."""
        entry = self.entries.get(source)
        if entry is None or entry.method != method or entry.name != name:
            return None
        is_there = entry.file is None or (self._folder and (self._folder / entry.file).exists())
        return entry.sha256 if is_there else None

    def append(self, row: dict[str, Any]) -> None:
        """Write a row as a whole line; the file of its map is on the disk already."""
        line = json_lines([row]).encode()
        start = self._file.tell()
        self._file.write(line)
        self._file.flush()
        self._note(line, start)
        if self._folder is not None and monotonic() - self._synced > _SYNC_SECONDS:
            os.fsync(self._file.fileno())
            self._synced = monotonic()

    def lines(self) -> Iterator[bytes]:
        """Last row of each source, sorted by name."""
        for entry in sorted(self.entries.values()):
            self._file.seek(entry.start)
            yield self._file.read(entry.length)
        self._file.seek(0, io.SEEK_END)

    def finish(self) -> bytes:
        """Write the last row of each source alone, sorted by name; the rows if in memory."""
        if self._folder is None:
            return b"".join(self.lines())
        write_atomically(self._folder / JOURNAL, self._write_lines)
        return b""

    def _write_lines(self, path: Path) -> None:
        with path.open("wb") as file:
            file.writelines(self.lines())

    def close(self) -> None:
        """Close the file, so that another batch can use the folder."""
        self._file.close()


def _lock_file(path: Path) -> IO[bytes]:
    """File of rows, open for one batch; a second one in the same folder is refused."""
    check_writable(path)
    try:
        file = path.open("a+b")
        if fcntl is not None:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise EnvLightsError(
            f"another batch writes to the folder {path.parent}; wait for its end, or give another"
        ) from None
    except OSError as error:
        raise EnvLightsError(f"cannot write {path}: {error.strerror}") from None
    return file
