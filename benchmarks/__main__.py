"""Run time against error, ours and others', in one run: data, pictures and a page.

Usage: python -m benchmarks [lights] [refitted] [probe] [detection] [transfer] [pairs] [scale]
           [stress] [skipping] [--quick] [--out FOLDER] [--threads N] [--processes N]
       python -m benchmarks --against FOLDER [--out FOLDER]

With `ENVLIGHTS_MAPS` set to a folder of maps, on those as well; `ENVLIGHTS_TRANSFER_DB` names a
folder of pairs. Without names, all parts are measured. `--out docs/lab` writes the page, which is
docs/lab/benchmarks.md, with its data and pictures; what other parts left there stays. `--against`
measures nothing: it compares what two runs wrote, puts that on the page, and fails if they do not
agree.
"""

import argparse
import datetime
import importlib
import os
import platform
import sys
import traceback
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

_ROOT = Path(__file__).parents[1]
#: By name, in the order of the page.
_PARTS = {
    "lights": "curves.few_lights",
    "refitted": "curves.refitted_lights",
    "probe": "curves.probe",
    "detection": "curves.detection",
    "transfer": "curves.transfer",
    "pairs": "tables.pairs",
    "scale": "curves.scale",
    "stress": "tables.stress",
    "skipping": "tables.skipping",
}
#: Written by `--against`, and not measured.
_COMPARED = {"second_run": "tables.second_run"}
#: Number of processes, of rounds in each, and seconds of rounds for each case. Two processes differ
#: by more than two rounds, hence many processes with few rounds each.
_FULL, _QUICK = (9, 3, 1.0), (1, 3, 1.0)


def main():
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks", description=__doc__.splitlines()[0]
    )
    parser.add_argument("parts", nargs="*", metavar="part", help=f"of {', '.join(_PARTS)}")
    parser.add_argument(
        "--quick", action="store_true", help="one map, few settings and rounds: a minute or two"
    )
    parser.add_argument(
        "--out", type=Path, default=Path("benchmark_results"), help="folder to write"
    )
    parser.add_argument("--threads", type=int, default=1, help="threads of our kernels and of BLAS")
    parser.add_argument("--processes", type=int, help="new processes (9; 1 with --quick)")
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
    failed = measure(parts, options.quick, options.out, options.threads, options.processes)
    if failed:
        sys.exit(f"not measured: {', '.join(failed)}")


def measure(names, quick, out, threads, processes=None):
    """Measure all parts, then all again in further processes; return those that failed.

    The results are written after each part of each process.
    """
    usual, *cost = _QUICK if quick else _FULL
    machine = {
        "processor": processor(),
        "cores": os.cpu_count(),
        "threads": threads,
        "quick": quick,
        # The load of all programs; Windows does not report it.
        "load": round(os.getloadavg()[0]) if hasattr(os, "getloadavg") else None,
        "date": datetime.date.today().isoformat(),
    }
    folder = out / "benchmarks"
    folder.mkdir(parents=True, exist_ok=True)
    found, failed = {name: [] for name in names}, []
    for number in range(processes or usual):
        for name in names:
            if name in failed or (number and is_table(name)):
                continue
            try:
                found[name].append(in_a_process(name, cost, quick, number == 0))
                write_part(name, machine, found[name], folder)
            except Exception:
                # The other parts take minutes: keep them if one fails.
                traceback.print_exc()
                failed.append(name)
    write_page(out)
    return failed


def is_table(name):
    """True for a part with rows instead of curves."""
    from curves import page

    return page.is_table(importlib.import_module(_PARTS[name]))


def in_a_process(name, *arguments):
    """Points or rows of a part, measured in a new process."""
    from curves import one_pass

    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        return pool.submit(one_pass.measure, _PARTS[name], *arguments).result()


def write_part(name, machine, passes, folder):
    """Write the data of a part."""
    from curves import results

    rows = passes[0] if is_table(name) else results.merge(passes)
    results.write(folder / f"{name}.jsonl", machine | {"processes": len(passes)}, rows)


def compare(names, out, against):
    """Compare two runs part by part and write the result; return 1 unless they agree."""
    from curves import page, results
    from tables import second_run

    rows, wrong, machine = [], [], {}
    for name in names:
        part = importlib.import_module(_PARTS[name])
        paths = [folder / "benchmarks" / f"{name}.jsonl" for folder in (out, against)]
        if page.is_table(part) or not all(path.exists() for path in paths):
            continue
        (machine, first), (other, second) = map(results.read, paths)
        if min(machine["processes"], other["processes"]) < 2:
            sys.exit(f"{name}: a run of one process has no intervals; measure it without --quick")
        changes = second_run.changes(part, first, second)
        rows.append(second_run.row(part.TITLE, *changes))
        wrong += [line for each in changes for line in second_run.sentences(each)]
    if not rows:
        sys.exit(f"{out} and {against} have no part in common")
    results.write(out / "benchmarks" / "second_run.jsonl", machine, rows)
    write_page(out)
    print("\n".join(wrong), file=sys.stderr)
    return int(bool(wrong))


def write_page(out):
    """Write the page of all parts whose data are there, with the pictures of those with curves."""
    from curves import page, pictures

    import envlights as el

    parts = parts_of(out)
    for name, part, _, rows in parts:
        if not page.is_table(part):
            picture = out / "benchmarks" / f"{name}.png"
            el.plot.save(pictures.picture(part, rows), picture)
    text = page.page(parts)
    (out / "benchmarks.md").write_text(text, encoding="utf-8")
    print(text)


def parts_of(out):
    """Name, module, machine and rows of each part whose data are there."""
    from curves import results

    parts = []
    for name, module in (_PARTS | _COMPARED).items():
        path = out / "benchmarks" / f"{name}.jsonl"
        if path.exists():
            parts.append((name, importlib.import_module(module), *results.read(path)))
    return parts


def processor():
    """The name of the processor."""
    lines = Path("/proc/cpuinfo").read_text().splitlines() if sys.platform == "linux" else []
    names = [line.split(":", 1)[1].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


if __name__ == "__main__":
    main()
