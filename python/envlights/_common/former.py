"""Former names: each works for one version, and warns with the name that replaced it."""

from __future__ import annotations

import warnings
from operator import attrgetter
from typing import Any


def former(old: str, new: str, owner: object, path: str) -> Any:
    """Attribute `path` of `owner`, with a warning that `old` is called `new` now."""
    warnings.warn(f"{old} is called {new} now", DeprecationWarning, stacklevel=4)
    return attrgetter(path)(owner)
