"""Answers of the installed build as JSON lines, and a comparison of two such files.

Usage: python benchmarks/answers.py write FILE [--only fit probe detect split transfer] [--every N]
       python benchmarks/answers.py compare BEFORE AFTER [--bits]

`write` fits, detects, splits and predicts on generated maps and, with `ENVLIGHTS_MAPS` set to a
folder of maps, on those as well. Errors of fits are measured against the exact probe of the map at
5120 normals, so they do not depend on how a build measures its own (but for fits over a floor).

`compare` prints, for each kind of answer, the geometric mean and the largest of the error ratios
(after over before), the angle between matching lights and the ratio of their flux. With `--bits` it
names each row that is not the same to the last bit.
"""

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

import probes
from tests.helpers import angle_deg

import envlights as el
from envlights import kernels, synthetic

NORMALS, WEIGHTS = kernels.icosphere(5120)
COUNTS = (1, 2, 4, 8, 16)
#: Options of each kind of fit, and the numbers of lights that it is tried with.
FITS = {
    "points": ({"sizes": False}, COUNTS),
    "sizes": ({}, COUNTS),
    "sh2": ({"ambient": "sh2", "sizes": False}, (1, 2, 4)),
    "sh2 sizes": ({"ambient": "sh2"}, (4,)),
    "none": ({"ambient": "none", "sizes": False}, (4, 8)),
    "floor": ({"floor": True}, (4, 8)),
}
TARGETS = (0.05, 0.01)
#: Errors below this count as equal: a fit renders its map no better.
FLOOR = 1e-4
#: Lights with a smaller fraction of the map's flux are not compared.
LEAST_FLUX = 0.01


def fits(env):
    """Fits of each kind and number of lights."""
    for kind, (options, counts) in FITS.items():
        for count in counts:
            yield (
                f"{kind} {count}",
                rig_row(env, el.fit(env, lights=count, **options), "floor" in options),
            )
    for target in TARGETS:
        yield f"error {target:g}", rig_row(env, el.fit(env, error=target))


def rig_row(env, rig, has_floor=False):
    """Lights, ambient term and errors of a rig; over a floor the error is the build's own."""
    measured = kernels.relative_rms(rig.probe(NORMALS), env.probe(NORMALS), WEIGHTS)
    error = rig.error if has_floor else measured
    return {
        **numbers(rig.lights, "direction", "irradiance", "angular_radius"),
        "ambient": np.asarray(rig.ambient).tolist(),
        "error": error,
        "shadow_error": rig.report.shadow_error,
    }


def probe_fits(env):
    """Fits to the values of a probe at 320 normals."""
    normals, weights = kernels.icosphere(320)
    irradiance = env.probe(normals)
    for count in (1, 4):
        rig = el.fit_probe(normals, irradiance, count, weights=weights)
        error = kernels.relative_rms(rig.probe(normals), irradiance, weights)
        yield (
            f"probe {count}",
            {**numbers(rig.lights, "direction", "irradiance"), "error": error},
        )


def detections(env):
    """Lights of both methods."""
    yield "detect tree", detected_row(el.detect(env))
    yield "detect article", detected_row(el.papers.loghin.detect(env))


def detected_row(lights):
    flux = lights.flux if hasattr(lights, "flux") else lights.irradiance
    return {
        **numbers(lights, "direction", "solid_angle", "flux_fraction"),
        "flux": np.asarray(flux).tolist(),
    }


def splits(env):
    """The remainder of a map, and the closure of remainder and lights."""
    for name, count in (("sun", 1), ("all", None)):
        lights, rest = el.split(env, count)
        total = rest.probe(NORMALS) + el.Rig(np.zeros(3), lights.discs(), error=0.0).probe(NORMALS)
        yield (
            f"split {name}",
            {
                **numbers(lights, "direction", "solid_angle", "flux_fraction"),
                "flux": lights.irradiance.tolist(),
                "error": kernels.relative_rms(total, env.probe(NORMALS), WEIGHTS),
                "rest": rest.radiance.mean(axis=(0, 1)).tolist(),
            },
        )


def transfers():
    """Predictions for lights of a room that the model has not seen."""
    room = synthetic.room(48, width=32)
    for ridge in (1e-3, "loo"):
        model = el.TransferModel.fit(room.direct[:32], room.indirect[:32], rank=16, ridge=ridge)
        predicted = model.predict(room.direct[32:])
        error = np.linalg.norm(predicted - room.indirect[32:]) / np.linalg.norm(room.indirect[32:])
        yield f"transfer {ridge}", {"error": float(error), "mean": float(predicted.mean())}


def numbers(result, *names):
    return {name: np.asarray(getattr(result, name)).tolist() for name in names}


KINDS = {"fit": fits, "probe": probe_fits, "detect": detections, "split": splits}


def write(path, only, every):
    maps = dict(list(probes.maps().items())[::every])
    with Path(path).open("w", encoding="utf-8") as file:
        for kind in only:
            sources = {"room": None} if kind == "transfer" else maps
            for name, env in sources.items():
                rows = transfers() if kind == "transfer" else KINDS[kind](env)
                for case, row in rows:
                    print(json.dumps({"map": name, "case": case, **row}), file=file, flush=True)


def compare(before, after, bits):
    old, new = read(before), read(after)
    groups = defaultdict(dict)
    for key in old.keys() & new.keys():
        groups[key[1].rpartition(" ")[0]][key] = old[key], new[key]
    missing = sorted(old.keys() ^ new.keys())
    print(f"{len(old)} and {len(new)} rows, {len(missing)} in one file only: {missing[:3]}")
    print(f"{'':<16}{'rows':>5}{'same':>6}  error ratio: mean   largest   lights lost  angle  flux")
    for group, rows in sorted(groups.items()):
        print(summary(group, rows))
        if bits:
            for key in sorted(key for key, (one, other) in rows.items() if one != other):
                print(f"    differs: {' | '.join(key)}")


def summary(group, rows):
    same = sum(one == other for one, other in rows.values())
    ratios = {
        key: max(other["error"], FLOOR) / max(one["error"], FLOOR)
        for key, (one, other) in rows.items()
        if "error" in one
    }
    line = f"{group:<16}{len(rows):>5}{same:>6}"
    if ratios:
        mean = np.exp(np.mean(np.log(list(ratios.values()))))
        worst = sorted(ratios, key=ratios.get)[:-4:-1]
        line += f"{mean:>19.4f}{ratios[worst[0]]:>10.3f}"
        line += "  (" + "; ".join(f"{' '.join(key)} {ratios[key]:.3f}" for key in worst) + ")"
    if "shadow_error" in next(iter(rows.values()))[0]:
        shadows = [
            max(other["shadow_error"], FLOOR) / max(one["shadow_error"], FLOOR)
            for one, other in rows.values()
        ]
        line += f"\n{'':<20}shadow error {np.exp(np.mean(np.log(shadows))):.4f} {max(shadows):.3f}"
    if "flux" in next(iter(rows.values()))[0]:
        line += "\n" + lights_summary(rows)
    return line


def lights_summary(rows):
    """Describe lights without a counterpart, and how far the others moved."""
    lost, angles, ratios, suns = [], [], [], []
    for key, (one, other) in rows.items():
        pairs = list(pairs_of_lights(one, other))
        lost += [(key[0], round(share, 4)) for share, match in pairs if match is None]
        angles += [match[0] for _, match in pairs if match]
        ratios += [match[1] for _, match in pairs if match]
        suns += [match[0] for _, match in pairs[:1] if match]
    if not angles:
        return f"{'':<20}no lights"
    spread = max(max(ratios), 1 / min(ratios))
    return (
        f"{'':<20}{len(lost)} of {len(angles) + len(lost)} lights lost {lost[:4]}; brightest moved"
        f" {max(suns):.4f} degrees at most, all {max(angles):.3f}; flux within {spread:.4f}"
    )


def pairs_of_lights(one, other):
    """Yield the flux fraction of each light, with the angle and flux ratio of its counterpart."""
    towards = np.reshape(other["direction"], (-1, 3))
    columns = (one["direction"], one["flux"], one["flux_fraction"], one["solid_angle"])
    for direction, flux, share, solid_angle in zip(*columns, strict=True):
        if share < LEAST_FLUX:
            continue
        angles = angle_deg(towards, direction)
        reach = max(2.0, np.rad2deg(np.sqrt(solid_angle / np.pi)))
        nearest = int(np.argmin(angles)) if len(angles) else None
        if nearest is None or angles[nearest] > reach:
            yield share, None
        else:
            ratio = np.sum(other["flux"][nearest]) / max(np.sum(flux), 1e-300)
            yield share, (angles[nearest], ratio)


def read(path):
    with Path(path).open(encoding="utf-8") as file:
        rows = [json.loads(line) for line in file]
    return {(row["map"], row["case"]): row for row in rows}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(required=True)
    writer = commands.add_parser("write", help="answers of the installed build")
    writer.add_argument("file")
    everything = [*KINDS, "transfer"]
    writer.add_argument("--only", nargs="+", choices=everything, default=everything)
    writer.add_argument("--every", type=int, default=1, help="every N-th map alone")
    writer.set_defaults(run=lambda options: write(options.file, options.only, options.every))
    comparer = commands.add_parser("compare", help="two files of answers")
    comparer.add_argument("before")
    comparer.add_argument("after")
    comparer.add_argument("--bits", action="store_true", help="name each row that differs")
    comparer.set_defaults(run=lambda o: compare(o.before, o.after, o.bits))
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
