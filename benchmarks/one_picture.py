"""One rig in several programs: a white ball on a floor, and how far each picture is off.

    python benchmarks/one_picture.py [--python PROGRAM=PYTHON ...] [-o PICTURE]

The rig has three points and no ambient term, because programs draw ambient light in different ways.
Ours is a formula: the irradiance of each visible point, with hard shadows. Mitsuba runs here;
``--python blender=...`` and ``--python mujoco=...`` name interpreters with bpy and mujoco.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

import envlights as el

SIZE, ALBEDO, RADIUS, FOV = (160, 120), 0.8, 0.5, 40.0
TITLES = {"mujoco": "MuJoCo", "blender": "Blender, Cycles"}
EYE, TARGET, CENTRE = np.array([0, 1.6, 3.0]), np.array([0, 0.35, 0]), np.array([0, RADIUS, 0])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--python", action="append", default=[], metavar="PROGRAM=PYTHON")
    parser.add_argument("-o", "--output", type=Path)
    given = parser.parse_args()
    rig = el.fit(el.synthetic.hall(256).radiance, 3, sizes=False, ambient="none")
    truth, edge = by_formula(rig)
    scale = 1 / truth.max()
    shown = {"formula": truth, "Mitsuba": in_mitsuba(rig)}
    for program, python in (each.split("=", 1) for each in given.python):
        shown[TITLES[program]] = elsewhere(program, python, rig, scale)
    codes = {name: np.clip(255 * scale * image, 0, 255) for name, image in shown.items()}
    print("| program | largest difference, codes of 255 | RMS |\n|---|---|---|")
    for name, image in list(codes.items())[1:]:
        off = np.abs(image - codes["formula"])[~edge]
        print(f"| {name} | {off.max():.1f} | {np.sqrt((off**2).mean()):.2f} |")
    if given.output:
        draw(codes, given.output)


def frame():
    """Right, up and back of the camera."""
    back = (EYE - TARGET) / np.linalg.norm(EYE - TARGET)
    right = np.cross([0, 1, 0], back)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(back, right), back])


def by_formula(rig):
    """Irradiance times albedo in each pixel, and pixels within 2 of an outline or a shadow."""
    columns, rows = SIZE
    half = np.tan(np.radians(FOV / 2))
    fine = 5
    x = (2 * (np.arange(columns * fine) + 0.5) / (columns * fine) - 1) * half
    y = (1 - 2 * (np.arange(rows * fine) + 0.5) / (rows * fine)) * half * rows / columns
    x, y = np.meshgrid(x, y)
    ray = np.stack([x, y, -np.ones_like(x)], -1) @ frame()
    ray /= np.linalg.norm(ray, axis=-1, keepdims=True)
    ball, floor = hit_ball(EYE, ray), -EYE[1] / np.where(ray[..., 1] < 0, ray[..., 1], np.nan)
    is_ball = np.isfinite(ball)
    point = EYE + np.where(is_ball, ball, floor)[..., None] * ray
    normal = np.where(is_ball[..., None], (point - CENTRE) / RADIUS, [0, 1, 0])
    light, kind = np.zeros(ray.shape), is_ball.astype(float)
    for towards, irradiance in zip(rig.lights.direction, rig.lights.irradiance, strict=True):
        is_lit = (normal @ towards > 0) & ~np.isfinite(hit_ball(point + 1e-6 * normal, towards))
        kind = 2 * kind + (is_lit | (normal @ towards <= 0))
        light += np.where(is_lit, normal @ towards, 0)[..., None] * irradiance
    light[~np.isfinite(point).all(-1)] = 0
    blocks = kind.reshape(rows, fine, columns, fine)
    edge = blocks.max((1, 3)) != blocks.min((1, 3))
    steps = (np.array(step) - 2 for step in np.ndindex(5, 5))
    edge = np.logical_or.reduce([np.roll(edge, step, (0, 1)) for step in steps])
    mean = light.reshape(rows, fine, columns, fine, 3).mean((1, 3))
    return ALBEDO * mean, edge


def hit_ball(origin, ray):
    """Distance along rays of unit length to the ball; NaN beside it."""
    to = np.asarray(origin) - CENTRE
    half = (to * ray).sum(-1)
    inside = half**2 - (to**2).sum(-1) + RADIUS**2
    distance = -half - np.sqrt(np.where(inside > 0, inside, np.nan))
    return np.where(distance > 1e-4, distance, np.nan)


def in_mitsuba(rig):
    """Radiance times pi."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    at = mi.ScalarTransform4f()
    eye = at.look_at(origin=EYE.tolist(), target=TARGET.tolist(), up=[0, 1, 0])
    film = {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}}
    white = {"type": "diffuse", "reflectance": {"type": "rgb", "value": ALBEDO}}
    flat = at.rotate([1, 0, 0], -90).scale(20)
    scene = {
        "type": "scene",
        "integrator": {"type": "direct"},
        "sensor": {"type": "perspective", "fov": FOV, "to_world": eye, "film": film},
        "floor": {"type": "rectangle", "to_world": flat, "bsdf": white},
        "ball": {"type": "sphere", "center": CENTRE.tolist(), "radius": RADIUS, "bsdf": white},
    }
    image = 0  # with one light at a time, no light is picked at random
    for row in range(len(rig.lights)):
        emitters = el.export.mitsuba(rig.lights[row : row + 1])
        image = image + np.array(mi.render(mi.load_dict(scene | emitters), spp=64))[..., :3]
    return np.pi * image


def elsewhere(program, python, rig, scale):
    """Picture of another interpreter: irradiance times albedo."""
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        if program == "mujoco":
            el.export.save_mujoco(rig, folder / "rig.mujoco.xml", scale=scale)
        else:
            rig.save(folder / "rig.py")
        axes = el.export.AXES[program]
        scene = {"size": SIZE, "albedo": ALBEDO, "radius": RADIUS, "fov": FOV, "scale": scale}
        scene |= {"eye": axes.to_target(EYE[None])[0].tolist()}
        scene |= {"frame": axes.to_target(frame()).tolist()}
        (folder / "scene.json").write_text(json.dumps(scene))
        script = Path(__file__).with_name("pictures") / f"{program}.py"
        subprocess.run([python, script, folder], check=True, stdout=subprocess.DEVNULL)
        return np.load(folder / "picture.npy")


def draw(codes, path):
    """Pictures in a row, encoded for a display."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(2.6 * len(codes), 2.2), layout="constrained")
    for ax, (name, image) in zip(figure.subplots(1, len(codes)), codes.items(), strict=True):
        ax.imshow((image / 255) ** (1 / 2.2))
        ax.set_title(name, fontsize=9)
        ax.axis("off")
    el.plot.save(figure, path, dpi=110)


if __name__ == "__main__":
    sys.exit(main())
