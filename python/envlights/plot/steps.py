"""Drawing of the steps of Loghin (2021), for maps and photographs."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import NDArray

from envlights.plot.markers import RIM
from envlights.plot.wording import entitle

#: Colours of selected and rejected samples.
KEPT, LEFT = "gold", "deepskyblue"


def draw_bright(
    axes: Axes, at: NDArray[np.float64], maxima: NDArray[np.float64], widest: float = np.inf
) -> None:
    """Draw bright samples, (k, 2), linked to the brightest pixel near each sample, (k, 2)."""
    draw_links(axes, at, maxima, LEFT, widest)
    axes.plot(*at.T, ".", ms=4, color=KEPT)
    axes.plot(*maxima.T, "x", ms=4, mew=0.8, color=RIM)
    entitle(axes, f"2. bright samples: {len(at)}, and maxima")


def draw_survivors(
    axes: Axes,
    at: NDArray[np.float64],
    first: NDArray[np.float64],
    survivor: NDArray[np.int64],
    widest: float = np.inf,
) -> None:
    """Draw surviving samples at positions `at`, linked to suppressed samples at `first`."""
    kept = np.unique(survivor)
    draw_links(axes, first, at[survivor], LEFT, widest)
    axes.plot(*first.T, ".", ms=3, color=LEFT)
    axes.plot(*at[kept].T, "o", ms=5, mec="black", mew=0.5, color=KEPT)
    entitle(axes, f"3. survivors: {len(kept)}")


def draw_links(
    axes: Axes,
    start: NDArray[np.float64],
    end: NDArray[np.float64],
    colour: str,
    widest: float = np.inf,
) -> None:
    """Draw lines between positions, except lines of width `widest` or more across the seam."""
    is_near = np.abs(start[:, 0] - end[:, 0]) < widest
    links = np.stack([start, end], axis=1)[is_near]
    axes.add_collection(LineCollection(list(links), colors=colour, lw=0.7))
