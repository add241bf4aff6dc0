"""One pass over a part, in a process of its own."""

import importlib
import sys

import numpy as np
import probes
from curves import page, results

import envlights as el


def measure(module, cost, quick, is_judged):
    """Points or rows of a part; `cost` is that of a case in one process."""
    part, rows = importlib.import_module(module), []
    effort = results.Effort(*cost, quick, is_judged)
    for row in (part.rows if page.is_table(part) else part.points)(maps(quick), effort):
        rows.append(row)
        told = list(row.values() if isinstance(row, dict) else row)[:4]
        print(", ".join(map(str, told)), file=sys.stderr)
    return rows


def maps(quick):
    """Two generated maps, and every third of the real ones; of a quick run one map."""
    real = [path for path in probes.paths() if path.suffix != ".png"]
    found = {path.stem: el.EnvMap.open(path) for path in (real[7:8] if quick else real[::3])}
    # The peers halve the map until it is small.
    found = {name: env for name, env in found.items() if env.height % 128 == 0}
    generated = {} if quick and found else {"hall": el.synthetic.hall(512)}
    if not quick:
        generated["hard"] = el.synthetic.hard(el.synthetic.EVALUATION[0])
    for name, world in generated.items():
        found[name] = el.EnvMap(np.ascontiguousarray(world.radiance, np.float32))
    return found
