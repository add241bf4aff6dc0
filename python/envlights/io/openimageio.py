"""Access to OpenImageIO, loaded when a file is first read or written, because loading is slow."""

from __future__ import annotations

import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import OpenImageIO as oiio  # noqa: N813, its own name for itself
else:

    class _OnDemand:
        def __getattr__(self, name: str) -> Any:
            return getattr(import_module("OpenImageIO"), name)

    oiio = _OnDemand()

__all__ = ["oiio"]


def _without_threads() -> None:
    """Let a forked process write by itself.

    The threads of OpenEXR stay in the parent, and the child would wait for them for ever.
    """
    if "OpenImageIO" in sys.modules:
        oiio.attribute("exr_threads", -1)


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_without_threads)
