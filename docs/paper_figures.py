"""Draw the pictures of view.md: `python docs/paper_figures.py`, with the extra `bake`.

They are figures 3, 6, 8 and 9 of Madsen, Sørensen and Vittrup (2003), in the generated hall.
"""

from pathlib import Path

import numpy as np

import envlights as el
from envlights.environment.files.image_output import write_png
from envlights.scene.camera import Camera
from envlights.scene.closed_form import shade, shade_with_hard_shadows
from envlights.scene.mitsuba.path_traced import SolidsOnFloor
from envlights.scene.panorama_floor import floor_albedo
from envlights.scene.view_image import true_view, view_image

HERE = Path(__file__).parent
#: Reflectance of all objects.
WHITE = 0.8
#: Columns and rows of one ball of figures 3 and 6.
BALL = 140


def save(name: str, rows: list[list[np.ndarray]], white: float) -> None:
    """Save a table of images of radiance, with one exposure."""
    picture = np.concatenate([np.concatenate(row, axis=1) for row in rows])
    write_png(HERE / name, np.clip(picture / white, 0, 1).astype(np.float32))


def probe(light: el.EnvMap | el.Rig, azimuth: float) -> np.ndarray:
    """White ball under a light, seen horizontally from an azimuth; its surroundings are grey."""
    at = (2 * np.arange(2 * BALL) + 1) / (2 * BALL) - 1
    x, y = np.meshgrid(1.1 * at, -1.1 * at)
    z = np.sqrt(np.maximum(1 - x**2 - y**2, 0))
    sin, cos = np.sin(azimuth), np.cos(azimuth)
    normals = np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)
    on_ball = x**2 + y**2 < 1
    image = np.full((2 * BALL, 2 * BALL, 3), 0.25)
    image[on_ball] = WHITE / np.pi * light.probe(normals[on_ball])
    return image.reshape(BALL, 2, BALL, 2, 3).mean(axis=(1, 3))


def balls_of(seed: int) -> list[el.scene.Ball]:
    """White balls at random places above the floor."""
    rng = np.random.default_rng(seed)
    balls: list[el.scene.Ball] = []
    while len(balls) < 7:
        x, z = rng.uniform(-4, 4, 2)
        radius = rng.uniform(0.25, 0.55)
        ball = el.scene.Ball((x, radius + rng.choice([0, 0.8, 1.6]), z), radius)
        gaps = [np.subtract(b.centre, ball.centre) for b in balls]
        if np.hypot(x, z) > 1.2 and all(np.linalg.norm(gap) > 1.2 for gap in gaps):
            balls.append(ball)
    return balls


def scene(env: el.EnvMap, solids: list) -> SolidsOnFloor:
    """White solids on the floor of the map."""
    return SolidsOnFloor(tuple(solids), np.full((len(solids), 3), WHITE), floor_albedo(env))


def draw_probes(env: el.EnvMap) -> None:
    """Figures 3 and 6: the map, 4 lights and 1 light; seen from the windows and from the wall."""
    rigs = [el.fit(env, lights) for lights in (4, 1)]
    # The sum over a map takes long, and a probe is smooth.
    small = env.resized(128)
    sides = [0.5, 0.5 + np.pi]
    save("view_probe.png", [[probe(x, side) for x in (small, *rigs)] for side in sides], 1.9)


def draw_balls(env: el.EnvMap) -> None:
    """Figure 8: four views of the hall with white balls."""
    rig, balls = el.fit(env, 4, floor=True), scene(env, balls_of(5))
    looks = [np.array([np.sin(a), 0, np.cos(a)]) for a in np.pi * np.arange(4) / 2]
    eye = np.array([0.0, 1.6, 0.0])
    cameras = [Camera(tuple(eye), tuple(eye - [0, 0.15, 0] + at), 90, 300, 190) for at in looks]
    images = [view_image(env, rig, balls, camera, per_side=2) for camera in cameras]
    save("view_balls.png", [images[:2], images[2:]], 0.9)


def draw_box(env: el.EnvMap) -> None:
    """Figure 9: a box with four shadows, the way of the paper, ours, and the truth."""
    box = scene(env, [el.scene.Box((0, 0.6, 0), (0.3, 0.6, 0.3), 0.5)])
    camera = Camera((0.0, 2.6, -5.0), (0, 0.45, 0), 40, 240, 176)
    points = el.fit(env, 4, sizes=False)
    rig = el.fit(env, 4, floor=True)
    images = [
        view_image(env, points, box, camera, shading=shade_with_hard_shadows),
        view_image(env, rig, box, camera, shading=shade),
        true_view(env, rig, box, camera, 72).image,
    ]
    save("view_box.png", [images], 0.55)


def main() -> None:
    """Draw the three pictures."""
    env = el.EnvMap(el.synthetic.hall(512).radiance)
    draw_probes(env)
    draw_balls(env)
    draw_box(env)


if __name__ == "__main__":
    main()
