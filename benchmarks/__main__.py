"""Run time against error, ours and others', in one run: data, pictures and a page.

Usage: python -m benchmarks [lights] [probe] [detection] [scale]
           [--quick] [--out FOLDER] [--threads N]

With `ENVLIGHTS_MAPS` set to a folder of maps, on those as well. Without names, all parts are
measured. `--out docs` writes `docs/benchmarks.md` with its data and pictures.
"""

import argparse
import datetime
import os
import platform
import sys
from pathlib import Path

_ROOT = Path(__file__).parents[1]
_PARTS = ("lights", "probe", "detection", "scale")


def main():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__.splitlines()[0]
    )
    parser.add_argument("parts", nargs="*", metavar="part", help=f"of {', '.join(_PARTS)}")
    parser.add_argument("--quick", action="store_true", help="few maps and rounds: a minute or two")
    parser.add_argument(
        "--out", type=Path, default=Path("benchmark_results"), help="folder to write"
    )
    parser.add_argument("--threads", type=int, default=1, help="of our kernels and of BLAS")
    options = parser.parse_args()
    if unknown := set(options.parts) - set(_PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}; there are {', '.join(_PARTS)}")
    # Before NumPy is imported, which reads them once.
    threads = ("RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    os.environ |= dict.fromkeys(threads, str(options.threads))
    sys.path[:0] = [str(_ROOT), str(Path(__file__).parent)]
    measure(options.parts or _PARTS, options.quick, options.out, options.threads)


def measure(names, quick, out, threads):
    """Measure the parts, then write data, pictures and the page."""
    from curves import detection, few_lights, page, pictures, probe, results, scale

    import envlights as el

    known = {"lights": few_lights, "probe": probe, "detection": detection, "scale": scale}
    parts = {name: known[name] for name in names}
    worlds = maps(quick)
    machine = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "threads": threads,
        "maps": len(worlds),
        "date": datetime.date.today().isoformat(),
    }
    folder = out / "benchmarks"
    folder.mkdir(parents=True, exist_ok=True)
    points = []
    for name, part in parts.items():
        for point in part.points(worlds, 3 if quick else 9):
            points.append(point)
            print(f"{name}: {point.case}, {point.method} ({point.setting:g})", file=sys.stderr)
        found = [point for point in points if point.part == name]
        el.plot.save(pictures.picture(part, found), folder / f"{name}.png")
    results.write(folder / "results.jsonl", machine, points)
    text = page.page(machine, parts, points)
    (out / "benchmarks.md").write_text(text, encoding="utf-8")
    print(text)


def maps(quick):
    """Maps in memory at 1024x512 or as they are; of a quick run four."""
    import numpy as np
    import probes

    import envlights as el

    real = [path for path in probes.paths() if path.suffix != ".png"]
    found = {path.stem: el.EnvMap.open(path) for path in (real[2::5] if quick else real)}
    found = {name: env for name, env in found.items() if env.height % 128 == 0}
    generated = {"hall": el.synthetic.hall(512), "hard": el.synthetic.hard(el.synthetic.JUDGING[0])}
    for name, world in generated.items():
        found[name] = el.EnvMap(np.ascontiguousarray(world.radiance, np.float32))
    return found


def processor():
    """The name of the processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if sys.platform == "linux" else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
