"""Run time against error, ours and others', in one run: data, pictures and a page.

Usage: python -m benchmarks [lights] [probe] [detection] [transfer] [scale] [stress] [skipping]
           [--quick] [--out FOLDER] [--threads N]
       python -m benchmarks --against FOLDER [--out FOLDER]

With `ENVLIGHTS_MAPS` set to a folder of maps, on those as well; `ENVLIGHTS_TRANSFER_DB` names a
folder of pairs. Without names, all parts are measured. `--out docs` writes `docs/benchmarks.md`
with its data and pictures; what other parts left there stays on the page. `--against` measures
nothing: it compares what two runs wrote, puts that on the page, and fails if they do not agree.
"""

import argparse
import datetime
import importlib
import os
import platform
import sys
import traceback
from pathlib import Path

_ROOT = Path(__file__).parents[1]
#: By name, in the order of the page.
_PARTS = {
    "lights": "curves.few_lights",
    "probe": "curves.probe",
    "detection": "curves.detection",
    "transfer": "curves.transfer",
    "scale": "curves.scale",
    "stress": "tables.stress",
    "skipping": "tables.skipping",
}
#: Written by `--against`, and not measured.
_COMPARED = {"second_run": "tables.second_run"}
#: Rounds, and seconds of rounds for each case.
_FULL, _QUICK = (9, 8.0), (3, 1.0)


def main():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__.splitlines()[0]
    )
    parser.add_argument("parts", nargs="*", metavar="part", help=f"of {', '.join(_PARTS)}")
    parser.add_argument(
        "--quick", action="store_true", help="one map and few rounds: two to three minutes"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("benchmark_results"), help="folder to write"
    )
    parser.add_argument("--threads", type=int, default=1, help="of our kernels and of BLAS")
    parser.add_argument("--against", type=Path, help="folder of another run, to compare with")
    options = parser.parse_args()
    if unknown := set(options.parts) - set(_PARTS):
        parser.error(f"unknown part {', '.join(sorted(unknown))}; there are {', '.join(_PARTS)}")
    # Before NumPy is imported, which reads them once.
    threads = ("RAYON_NUM_THREADS", "OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")
    os.environ |= dict.fromkeys(threads, str(options.threads))
    sys.path[:0] = [str(_ROOT), str(Path(__file__).parent)]
    parts = options.parts or _PARTS
    if options.against:
        sys.exit(compare(parts, options.out, options.against))
    failed = measure(parts, options.quick, options.out, options.threads)
    if failed:
        sys.exit(f"not measured: {', '.join(failed)}")


def measure(names, quick, out, threads):
    """Measure the parts one by one, each with its data and picture; return those that failed."""
    worlds = maps(quick)
    machine = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "threads": threads,
        "maps": len(worlds),
        "quick": quick,
        "date": datetime.date.today().isoformat(),
    }
    folder = out / "benchmarks"
    folder.mkdir(parents=True, exist_ok=True)
    failed = []
    for name in names:
        try:
            measure_part(name, worlds, machine, folder)
        except Exception:
            # The other parts take minutes: one that fails must not take them along.
            traceback.print_exc()
            failed.append(name)
    write_page(out)
    return failed


def measure_part(name, worlds, machine, folder):
    """Measure one part; write its data, and its picture if it has curves."""
    from curves import page, pictures, results

    import envlights as el

    part, rows = importlib.import_module(_PARTS[name]), []
    effort = results.Effort(*(_QUICK if machine["quick"] else _FULL))
    measured = part.rows if page.is_table(part) else part.points
    for row in measured(worlds, effort):
        rows.append(row)
        told = list(row.values() if isinstance(row, dict) else row)[1:4]
        print(f"{name}: {', '.join(map(str, told))}", file=sys.stderr)
    if not page.is_table(part):
        el.plot.save(pictures.picture(part, rows), folder / f"{name}.png")
    results.write(folder / f"{name}.jsonl", machine, rows)


def compare(names, out, against):
    """Compare two runs part by part, and write what was found; return 1 unless they agree."""
    from curves import page, results
    from tables import second_run

    rows, wrong, machine = [], [], {}
    for name in names:
        part = importlib.import_module(_PARTS[name])
        paths = [folder / "benchmarks" / f"{name}.jsonl" for folder in (out, against)]
        if page.is_table(part) or not all(path.exists() for path in paths):
            continue
        (machine, first), (_, second) = map(results.read, paths)
        changes = second_run.changes(part, first, second)
        rows.append(second_run.row(part.TITLE, *changes))
        wrong += [line for each in changes for line in second_run.said(each)]
    if not rows:
        sys.exit(f"{out} and {against} have no part in common")
    results.write(out / "benchmarks" / "second_run.jsonl", machine, rows)
    write_page(out)
    print("\n".join(wrong), file=sys.stderr)
    return int(bool(wrong))


def write_page(out):
    """Write the page of all parts whose data are there."""
    from curves import page, results

    found = []
    for name, module in (_PARTS | _COMPARED).items():
        path = out / "benchmarks" / f"{name}.jsonl"
        if path.exists():
            found.append((name, importlib.import_module(module), *results.read(path)))
    text = page.page(found)
    (out / "benchmarks.md").write_text(text, encoding="utf-8")
    print(text)


def maps(quick):
    """Two generated maps, and every third of the real ones; of a quick run one map."""
    import numpy as np
    import probes

    import envlights as el

    real = [path for path in probes.paths() if path.suffix != ".png"]
    found = {path.stem: el.EnvMap.open(path) for path in (real[7:8] if quick else real[::3])}
    # The peers halve the map until it is small.
    found = {name: env for name, env in found.items() if env.height % 128 == 0}
    generated = {} if quick and found else {"hall": el.synthetic.hall(512)}
    if not quick:
        generated["hard"] = el.synthetic.hard(el.synthetic.JUDGING[0])
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
