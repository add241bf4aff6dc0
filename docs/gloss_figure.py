"""Draw the picture of gloss.md: `python docs/gloss_figure.py`.

A ball of rough metal in the generated hall under 4, 8 and 16 lights, beside the truth. Each pixel
is the sum over all pixels of the map, or of the rig drawn as a map.
"""

from pathlib import Path

import numpy as np

import envlights as el
from envlights import kernels
from envlights.environment.files.image_output import write_png

HERE = Path(__file__).parent
ROUGHNESS = 0.33
LIGHTS = (4, 8, 16)
#: Columns and rows of a ball.
BALL = 90
#: Direction towards the viewer, on the horizon.
VIEW = np.array([0.0, 0.0, -1.0])


def lobe(normal: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Reflectance distribution of metal times the cosine, for one normal (Walter et al. 2007)."""
    square = ROUGHNESS**4

    def masking(c: np.ndarray) -> np.ndarray:
        return 2 * c / (c + np.sqrt(square + (1 - square) * c * c))

    half = light + VIEW
    half /= np.linalg.norm(half, axis=1, keepdims=True) + 1e-12
    cosine, towards = np.maximum(light @ normal, 0), normal @ VIEW
    facets = square / (np.pi * ((half @ normal) ** 2 * (square - 1) + 1) ** 2)
    return facets * masking(cosine) * masking(towards) / (4 * towards) * (cosine > 0)


def balls(maps: list[np.ndarray]) -> list[np.ndarray]:
    """Images of the ball under several maps of one size."""
    height, width, _ = maps[0].shape
    light = kernels.pixel_directions(height, width).reshape(-1, 3)
    solid_angles = kernels.pixel_solid_angles(height, width)[..., None]
    power = np.concatenate([(each * solid_angles).reshape(-1, 3) for each in maps], axis=1)
    at = 1.05 * ((2 * np.arange(BALL) + 1) / BALL - 1)
    # Seen from -z with +y up, +x lies to the left.
    x, y = np.meshgrid(-at, -at)
    image = np.full((BALL, BALL, power.shape[1]), np.nan)
    for row, column in np.argwhere(x**2 + y**2 < 1):
        across, up = x[row, column], y[row, column]
        normal = np.array([across, up, -np.sqrt(1 - across**2 - up**2)])
        image[row, column] = lobe(normal, light) @ power
    return np.split(image, len(maps), axis=2)


def main() -> None:
    """Draw and save the row of balls."""
    env = el.EnvMap(el.synthetic.hall(96).radiance)
    rigs = [el.fit(env, lights) for lights in LIGHTS]
    images = balls([*(rig.to_map(env.height).radiance for rig in rigs), env.radiance])
    white = np.nanpercentile(images[-1], 97)
    picture = np.concatenate(images, axis=1)
    shown = np.where(np.isnan(picture), 0.2, picture / white)
    linear = np.clip(shown, 0, 1).astype(np.float32)
    write_png(HERE / "gloss.png", linear)
    for lights, rig, image in zip(LIGHTS, rigs, images, strict=False):
        ball = ~np.isnan(image)
        off = np.linalg.norm((image - images[-1])[ball]) / np.linalg.norm(images[-1][ball])
        print(f"{lights} lights: from all sides {rig.report.gloss_error():.1%}, here {off:.1%}")


if __name__ == "__main__":
    main()
