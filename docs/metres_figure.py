"""Draw the picture of metres.md: `PYTHONPATH=. python docs/metres_figure.py`.

A white ball at three points of a generated room, with all light at infinity, with lights in metres,
and in closed form. Each column has its own exposure; error: RMS over the pixels of the ball.
"""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from tests.placing.rooms import room, seen

import envlights as el
from envlights._common.srgb import encode_srgb

#: Metres from the camera; the last point is 0.4 m from a lamp.
POINTS = {"at the camera": (0, 0, 0), "1 m away": (0.8, 0, 0.6), "2 m away": (1.5, -0.3, -1.2)}
KIND, PIXELS = "pendants", 150


def ball() -> tuple[np.ndarray, np.ndarray]:
    """Normals of the visible pixels of a ball that is seen along +z, and their mask."""
    y, x = 1 - 2 * (np.indices((PIXELS, PIXELS)) + 0.5) / PIXELS
    inside = x**2 + y**2 < 1
    depth = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    # From the camera that looks along +z, +x is to the left.
    return np.stack([x, y, -depth], axis=-1)[inside], inside


def main() -> None:
    """Draw the figure."""
    placed, (normals, inside) = el.place(*seen(KIND)), ball()
    points = np.array(list(POINTS.values()), float)
    home = placed.irradiance(points[0], normals)
    rows = {
        "at infinity": [home] * len(points),
        "in metres": placed.irradiance(points, normals),
        "truth": [room(KIND).probe(point, normals) for point in points],
    }
    figure, axes = plt.subplots(3, 3, figsize=(5.4, 5.9))
    for row, (name, values) in zip(axes, rows.items(), strict=True):
        for column, (axis, value) in enumerate(zip(row, values, strict=True)):
            truth = rows["truth"][column]
            image = np.ones((PIXELS, PIXELS, 3))
            image[inside] = encode_srgb(np.clip(0.8 * value / truth.max(), 0, 1))
            axis.imshow(image)
            axis.set_axis_off()
            error = np.linalg.norm(value - truth) / np.linalg.norm(truth)
            words = "" if name == "truth" else f"error {100 * error:.1f} %"
            axis.text(0.5, -0.04, words, ha="center", va="top", transform=axis.transAxes)
        row[0].text(
            -0.06, 0.5, name, ha="right", va="center", rotation=90, transform=row[0].transAxes
        )
    for axis, title in zip(axes[0], POINTS, strict=True):
        axis.set_title(title, fontsize=10)
    figure.tight_layout()
    figure.savefig(Path(__file__).with_name("metres.png"), dpi=85)


if __name__ == "__main__":
    main()
