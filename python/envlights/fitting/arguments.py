"""Arguments of `fit` beside the map, as one object."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from numpy.typing import ArrayLike

from envlights.environment.fill import Fill
from envlights.rigs.lights import Lights
from envlights.rigs.rig import Rig


@dataclass(frozen=True)
class FitArguments:
    """Arguments of `fit`, as they were given; its signature has their defaults."""

    lights: int | None
    error: float | None
    shadow_error: float | None
    gloss_error: float | None
    roughness: float
    sizes: bool
    max_radius: float | None
    objective: str
    ambient: str | None
    start: str | Rig | Lights
    fixed: ArrayLike | Lights | None
    floor: bool
    fill: Fill
    target: str | Iterable[str] | None
