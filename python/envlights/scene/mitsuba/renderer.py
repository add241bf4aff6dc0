"""Mitsuba, if it is installed, in the variant that works on every machine."""

from __future__ import annotations

import importlib
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from envlights._native import EnvLightsError

#: The vectorised variants need an LLVM that is new enough, and end the process where it is not.
_VARIANT = "scalar_rgb"

_LOCK = threading.RLock()


@contextmanager
def mitsuba() -> Iterator[Any]:
    """Mitsuba in its scalar variant; the user's own variant is set again afterwards.

    One thread at a time, because all threads share the variant, and the film and sampler of a
    sensor.
    """
    # Import it at its first use.
    try:
        renderer: Any = importlib.import_module("mitsuba")
    except ImportError as error:
        raise EnvLightsError(
            f"Mitsuba cannot be imported: {error}; install it with"
            " pip install 'envlights[bake]', or '.[bake]' in a checkout"
        ) from None
    # Lend it out in one variant to one thread, then set the user's variant again.
    with _LOCK:
        before = renderer.variant()
        renderer.set_variant(_VARIANT)
        try:
            yield renderer
        finally:
            if before is not None:
                renderer.set_variant(before)


def in_one_line(error: Exception) -> str:
    """The message of an error of Mitsuba, which may have several lines."""
    return " ".join(str(error).split())


def film(width: int, height: int) -> dict[str, Any]:
    """Film of pixels that do not overlap."""
    size = {"width": width, "height": height}
    return {"type": "hdrfilm", **size, "pixel_format": "rgb", "rfilter": {"type": "box"}}
