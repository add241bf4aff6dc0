"""Comparison of light sets: real maps after rotations, and the time of a transport plan.

Usage: ENVLIGHTS_MAPS=maps python benchmarks/light_sets.py

First table, for each map: length of the irradiance vector over the flux; error of `vector_angle`
after a rotation by 20 degrees about a tilted axis; number of detected lights, their mean movement
if the set is rotated by 11.25 degrees about the pole, the `angle` and the `rotation` of
`compare_lights`, all in degrees. Second table: milliseconds of processor time of
`kernels.transport_plan`, the least of five rounds, for sets of several sizes, and of SciPy's linear
program (HiGHS) for some.
"""

import numpy as np
from scipy.spatial.transform import Rotation
from stopwatch import all_seconds, processor_seconds
from tests.comparison.test_vector_angle import AXIS, about_the_pole, irradiance_vector
from tests.helpers import angle_deg, paths_of_real_maps
from tests.kernels.test_transport import SETS, least_mean_angle

import envlights as el
from envlights.kernels.image import LUMINANCE

MAPS = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/Stage*LatLong.exr", "ldr/*.png")


def main():
    print("map | vector | error | lights | movement | angle | rotation")
    for path in paths_of_real_maps(*MAPS):
        print(path.name, *row_of(el.EnvMap.open(path)), sep=" | ", flush=True)
    print("\nset | lights | plan | linear program")
    for kind in SETS:
        for count in (16, 64, 256, 512):
            print(kind.__name__, count, *times(kind, count), sep=" | ", flush=True)


def row_of(env):
    """Cells of a map."""
    axes = np.vstack([np.eye(3), -np.eye(3)])
    sides = env.probe(axes, fill="black") @ LUMINANCE
    whole = (env.radiance @ LUMINANCE * solid_angles(env)).sum()
    turn = Rotation.from_rotvec(np.deg2rad(20) * AXIS).as_matrix()
    vector = irradiance_vector(env)
    expected = angle_deg(vector, turn @ vector)
    error = el.comparison.vector_angle(env, env.rotated(turn)) - expected
    lights, roll = el.detect(env), about_the_pole(11.25)
    moved = lights.rotated(roll)
    movement = angle_deg(lights.direction, moved.direction) @ lights.luminance
    difference = el.comparison.compare_lights(lights, moved)
    return (
        f"{np.linalg.norm(sides[:3] - sides[3:]) / whole:.3f}",
        f"{error:+.4f}",
        len(lights),
        f"{movement / lights.luminance.sum():.3f}",
        f"{difference.angle:.3f}",
        f"{difference.rotation:.3f}",
    )


def solid_angles(env):
    return el.kernels.pixel_solid_angles(
        env.height, env.width, border_sampled=env.is_border_sampled
    )


def times(kind, count):
    """Milliseconds of the plan, and of the linear program of up to 64 lights."""
    rng = np.random.default_rng(count)
    sets = *kind(rng, count), *kind(rng, count)
    work = {"plan": lambda: el.kernels.transport_plan(*sets)}
    if count <= 64:
        work["program"] = lambda: least_mean_angle(*sets)
    found = all_seconds(work, rounds=5, clock=processor_seconds, shortest=0.02)
    return [f"{1e3 * min(found[name]):.2f}" for name in work]


if __name__ == "__main__":
    main()
