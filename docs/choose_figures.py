"""Draw the pictures of choose.md and axes.md: `python docs/choose_figures.py`."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

import envlights as el
from envlights.scene.camera import Camera
from envlights.scene.closed_form import closed_form
from envlights.scene.mitsuba.path_traced import SolidsOnFloor

HERE = Path(__file__).parent
CAMERA = Camera((-2.4, 1.9, -3.2), (0, 0.4, 0), 34, 300, 225)


def still_life() -> SolidsOnFloor:
    """A ball and a box, all of reflectance 0.7."""
    solids = (
        el.scene.Ball((-0.65, 0.5, 0.1), 0.5),
        el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), 0.5),
    )
    return SolidsOnFloor(solids, np.full((2, 3), 0.7), np.full(3, 0.7))


def draw_errors(env: el.EnvMap) -> None:
    """Draw one scene with image errors near 10, 3 and 1 %, and the reference."""
    reference = el.fit(env, 32, floor=True)
    truth = closed_form(reference, still_life(), CAMERA)
    print(f"reference: 32 lights, error of shadows {reference.report.shadow_error:.2%}")
    found = []
    for sizes in (True, False):
        for lights in (1, 2, 3, 4, 6, 8, 12, 16):
            rig = el.fit(env, lights, sizes=sizes, floor=True)
            image = closed_form(rig, still_life(), CAMERA)
            error = np.linalg.norm(image - truth) / np.linalg.norm(truth)
            found.append((error, lights, sizes, rig, image))
    images = []
    for goal in (0.1, 0.03, 0.01):
        error, lights, sizes, rig, image = min(found, key=lambda each: abs(np.log(each[0] / goal)))
        kind = "discs" if sizes else "points"
        print(f"image {error:.1%}: {lights} {kind}; {rig.error:.2%}, {rig.report.shadow_error:.1%}")
        images.append(image)
    rows = (images[:2], [images[2], truth])
    picture = np.concatenate([np.concatenate(row, axis=1) for row in rows])
    white = np.quantile(truth, 0.99)
    plt.imsave(HERE / "choose_errors.png", np.clip(picture / white, 0, 1) ** (1 / 2.2))


def draw_frame(env: el.EnvMap) -> None:
    """Draw azimuth and elevation on a map, and azimuth from above."""
    figure = plt.figure(figsize=(6.5, 7), layout="constrained")
    on_map, plan = figure.subplots(2, 1, height_ratios=(5, 4))
    label_map(on_map, env)
    label_plan(plan)
    figure.savefig(HERE / "axes_frame.png", dpi=100)


def label_map(panel: Axes, env: el.EnvMap) -> None:
    """Draw a map with the angles of its columns and rows, and the axes that it shows."""
    panel.imshow(np.clip(env.radiance, 0, 1) ** (1 / 2.2), extent=(0, 360, -90, 90))
    panel.set(xticks=range(0, 361, 45), yticks=range(-90, 91, 30))
    panel.set(xlabel="azimuth, degrees", ylabel="elevation, degrees")
    names = {"−z": 8, "+x": 90, "+z\ncentre": 180, "−x": 270, " −z": 352}
    style = {"color": "white", "ha": "center", "va": "center", "weight": "bold"}
    for name, azimuth in names.items():
        panel.plot(azimuth if azimuth % 90 == 0 else round(azimuth / 360) * 360, 0, "w+", ms=12)
        panel.text(azimuth, -14, name, **style)
    panel.text(180, 82, "+y, zenith: the whole top row", **style)
    panel.text(180, -82, "−y, nadir: the whole bottom row", **style)


def label_plan(panel: Axes) -> None:
    """Draw the axes and the azimuth as seen from above."""
    panel.set(xlim=(-1.5, 1.5), ylim=(-1.5, 1.5), aspect="equal")
    panel.set_axis_off()
    panel.set_title("seen from above, +y towards you")
    panel.add_patch(plt.Circle((0, 0), 1, fill=False, color="#888888"))
    for azimuth, name in ((0, "−z"), (90, "+x"), (180, "+z, centre of the map"), (270, "−x")):
        x, y = -np.sin(np.deg2rad(azimuth)), -np.cos(np.deg2rad(azimuth))
        panel.annotate("", (x, y), (0, 0), arrowprops={"arrowstyle": "-|>", "lw": 1.5})
        panel.text(1.25 * x, 1.2 * y, f"{name}\n{azimuth}°", ha="center", va="center")
    turn = np.deg2rad(np.linspace(5, 80))
    panel.plot(-0.6 * np.sin(turn), -0.6 * np.cos(turn), color="#c0392b", lw=2)
    end, before = turn[-1], turn[-6]
    tip, tail = ((-0.6 * np.sin(at), -0.6 * np.cos(at)) for at in (end, before))
    panel.annotate("", tip, tail, arrowprops={"arrowstyle": "-|>", "color": "#c0392b", "lw": 2})
    panel.text(-0.68, -0.72, "azimuth", color="#c0392b", ha="center")


def main() -> None:
    """Draw both pictures."""
    draw_errors(el.EnvMap(el.synthetic.hall(256).radiance))
    draw_frame(el.EnvMap(el.synthetic.hall(512).radiance))


if __name__ == "__main__":
    main()
