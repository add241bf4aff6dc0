"""Errors of blending shadows of a ball and a box over a floor, under real maps.

    ENVLIGHTS_MAPS=folder python benchmarks/overlays.py

Each rig has four lights, fitted over a floor. The floor is white; the largest channel of its
picture is code 255. Errors are in 8-bit sRGB codes, in shadow: the mean, and the largest. "one
light" has the ambient term and the brightest light alone. "other floor" blends the colour and
alpha of the white floor over a red floor.
"""

from time import perf_counter

import numpy as np
from tests.helpers import EQUIRECTANGULAR, paths_of_real_maps

import envlights as el

#: Solids of the scene of `plot.scene`.
_SOLIDS = (
    el.scene.Ball((-0.65, 0.5, 0.1), 0.5),
    el.scene.Box((0.65, 0.4, -0.1), (0.4, 0.4, 0.4), 0.5),
)
_COLUMNS = 256
_RED = (1.0, 0.3, 0.2)
_WHITE = (1.0, 1.0, 1.0)
#: Points of the floor along each side, and lights, for the time.
_SIDE, _TIMES = 300, 5


def main():
    print(
        f"{'map':>28} {'one light':>12} {'alpha':>12} {'other floor':>12} {'black':>12}"
        f" {'product':>12} {'codes':>12}"
    )
    maps = {"hall": el.EnvMap(el.synthetic.hall(256).radiance)}
    maps |= {path.stem: path for path in paths_of_real_maps(*EQUIRECTANGULAR)}
    for name, env in maps.items():
        print(_row(name, el.fit(env, lights=4, floor=True, fill="black")), flush=True)
    _time()


def _row(name, rig):
    one = el.Rig(rig.ambient, rig.lights[:1], error=0.0, floor=True)
    single, overlay = (
        el.scene.shadow_overlay(each, _SOLIDS, columns=_COLUMNS, floor_albedo=_WHITE)
        for each in (one, rig)
    )
    errors = overlay.code_errors()
    red = np.array(_RED) * overlay.radiance
    columns = [
        single.code_errors()["product"],
        errors["alpha"],
        overlay.code_errors(red)["alpha"],
        *(errors[blending] for blending in ("black", "product", "codes")),
    ]
    return f"{name:>28} " + " ".join(f"{mean:>6.2f} {most:>5.1f}" for mean, most in columns)


def _time():
    """Processor time of the kernel for a picture of the floor under four discs."""
    side = np.linspace(-4, 4, _SIDE)
    x, z = np.meshgrid(side, side)
    points = np.stack([x, 0 * x, z], axis=-1).reshape(-1, 3)
    stage = el.occluders.Stage.floor(_SOLIDS, points)
    directions = np.array([[3, 6, 2], [-8, 4, 1], [1, 9, -5], [6, 3, -8.0]])
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    lights = el.Lights(
        directions,
        np.ones((4, 3)),
        [0.0047, 0.3, 0.8, 0.15],
    )
    seconds = []
    for _ in range(_TIMES):
        start = perf_counter()
        el.kernels.hidden_fractions(stage, lights.direction, lights.angular_radius, floor=True)
        seconds.append(perf_counter() - start)
    print(f"{len(points)} points, 4 discs, a ball and a box: {min(seconds):.2f} s")


if __name__ == "__main__":
    main()
