"""White probes under maps of all kinds: what the fits are compared on."""

import os
from pathlib import Path

import envlights as el
from envlights import kernels, synthetic

NORMALS, SOLID_ANGLES = kernels.icosphere(320)

EQUIRECTANGULAR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")
#: Maps of each random family.
GENERATED = 4


def real_and_generated():
    """Each third is a fair sample: neighbours are of one kind."""
    return {**real(), **generated()}


def real():
    """Those in the folder that `ENVLIGHTS_MAPS` names; none without it."""
    folder = os.environ.get("ENVLIGHTS_MAPS")
    if folder is None:
        return {}
    found = [path for pattern in EQUIRECTANGULAR for path in sorted(Path(folder).glob(pattern))]
    return {path.name: probe(el.EnvMap.open(path)) for path in found}


def generated():
    """The hall of the demo, and some of each family of random maps."""
    worlds = {"hall": synthetic.hall(256)}
    for seed in synthetic.JUDGING[:GENERATED]:
        for make in (synthetic.plain, synthetic.hard):
            worlds[f"{make.__name__} {seed}"] = make(seed, 256)
    return {name: probe(el.EnvMap(world.radiance)) for name, world in worlds.items()}


def probe(env):
    """Its greatest irradiance 1, so that one kind of start suits all."""
    irradiance = env.probe(NORMALS)
    return irradiance / irradiance.max()
