"""Run time of the fit: beside scipy's and jaxopt's from one start, and as its input grows."""

import numpy as np
import probes
from stopwatch import compare
from tests.helpers import NORMALS, SOLID_ANGLES
from tests.reference import peers

import envlights as el
from envlights import kernels

LIGHTS = (1, 2, 4, 8, 16, 32)
NORMAL_COUNTS = (80, 320, 1280, 5120, 20480)
HEIGHTS = (64, 256, 512, 1024, 2048)


def tables():
    hall = el.EnvMap(el.synthetic.hall(512).radiance)
    irradiance = probes.probe(hall)
    for lights in (4, 8):
        beside_peers(irradiance, lights)
    growth(hall, irradiance)
    large_map()
    next_frame()


def beside_peers(irradiance, lights):
    """Even starts with the best radiances for them; each peer stops where it does by default."""
    problem = peers.Problem(NORMALS, SOLID_ANGLES, irradiance, lights)
    directions = peers.even(lights)
    start = problem.unknowns(peers.ours(problem, fixed=directions))
    with peers.jax_in_float64():
        jaxopt = peers.compiled_jaxopt(problem, start, tolerance=1e-8)
        jaxopt()  # compiles
        by_scipy = {"has_bounds": True, "tolerance": 1e-8}
        work = {
            "fit_probe, the whole search": lambda: peers.ours(problem),
            "fit_probe from the start": lambda: peers.ours_from(problem, directions),
            "scipy, bounded, analytic Jacobian": lambda: peers.by_scipy(problem, start, **by_scipy),
            "jaxopt, compiled": jaxopt,
        }
        compare(f"{lights} lights, 320 normals, one start", work)


def growth(hall, irradiance):
    given = {"weights": SOLID_ANGLES}
    compare(
        "fit_probe, 320 normals, by the number of lights",
        {f"{m} lights": lambda m=m: el.fit_probe(NORMALS, irradiance, m, **given) for m in LIGHTS},
        base="4 lights",
    )
    work = {}
    for count in NORMAL_COUNTS:
        normals, weights = kernels.icosphere(count)
        probe = normals, hall.probe(normals)
        work[f"{count} normals"] = lambda p=probe, w=weights: el.fit_probe(*p, 4, weights=w)
    compare("fit_probe, 4 lights, by the number of normals", work, base="320 normals")
    maps = {f"{2 * h}x{h}": el.synthetic.hall(h).radiance for h in HEIGHTS}
    compare(
        "fit(array, lights=4), by the size of the map",
        {size: lambda r=radiance: el.fit(r, 4) for size, radiance in maps.items()},
        base="1024x512",
    )


def large_map():
    """Compare the fit with one pass over the map."""
    rng = np.random.default_rng(0)
    radiance = rng.gamma(0.5, size=(2048, 4096, 3)).astype(np.float32)
    radiance[700, 1000] = 5e4
    hall = el.synthetic.hall(2048).radiance
    for name, array in {"noise and a sun": radiance, "the hall": hall}.items():
        work = {
            "array.max()": array.max,
            "el.fit(array, lights=4)": lambda a=array: el.fit(a, 4),
        }
        compare(f"4096x2048 float32, {name}", work)


def next_frame():
    """Two suns and a room, of which one sun moves by a degree."""

    def frame(angle):
        suns = [(0.6 * np.cos(angle), 0.8, 0.6 * np.sin(angle)), (-0.5, 0.6, 0.6)]
        discs = [el.synthetic.Disc(sun, 3, (90, 80, 70)) for sun in suns]
        room = el.synthetic.hall(256).radiance
        return el.EnvMap(room + el.synthetic.scene(256, background=[0] * 3, shapes=discs).radiance)

    before = el.fit(frame(0.0), 4)
    after = frame(np.deg2rad(1) / 0.6).probe(NORMALS)
    given = {"weights": SOLID_ANGLES}
    work = {
        "afresh": lambda: el.fit_probe(NORMALS, after, 4, **given),
        "start=rig": lambda: el.fit_probe(NORMALS, after, 4, start=before, **given),
    }
    compare("a frame later, 4 lights, 320 normals", work)
    errors = ", ".join(f"{name} {100 * fit().error:.4f} %" for name, fit in work.items())
    print(f"  errors: {errors}")
