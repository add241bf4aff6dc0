"""Classes of refusals of files, for callers who treat them differently."""

from __future__ import annotations

import errno

from envlights._native import EnvLightsError


class MissingFileError(EnvLightsError, FileNotFoundError):
    """Refusal of a file that does not exist."""

    def __init__(self, *args: object) -> None:
        super().__init__(*args)
        self.errno = errno.ENOENT


class DamagedFileError(EnvLightsError):
    """Refusal of a file whose content contradicts its format."""
