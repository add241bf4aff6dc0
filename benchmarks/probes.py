"""White probes under maps of all kinds: what the fits are compared on."""

import os
from pathlib import Path

import envlights as el
from envlights import kernels, synthetic

NORMALS, SOLID_ANGLES = kernels.icosphere(320)

EQUIRECTANGULAR = ("hdr/*.hdr", "exr/*.exr", "openexr_envmaps/*LatLong.exr", "ldr/*.png")
GENERATED = 4


def real():
    """Those in the folder that `ENVLIGHTS_MAPS` names; none without it."""
    folder = Path(os.environ["ENVLIGHTS_MAPS"]) if "ENVLIGHTS_MAPS" in os.environ else None
    found = (
        [path for pattern in EQUIRECTANGULAR for path in sorted(folder.glob(pattern))]
        if folder
        else []
    )
    return {path.name: probe(el.EnvMap.open(path)) for path in found}


def generated():
    """The hall of the demo, and some of each family of random maps."""
    seeds = synthetic.JUDGING[:GENERATED]
    worlds = {
        f"{make.__name__} {n}": make(n, 256)
        for make in (synthetic.plain, synthetic.hard)
        for n in seeds
    }
    worlds["hall"] = synthetic.hall(256)
    return {name: probe(el.EnvMap(world.radiance)) for name, world in worlds.items()}


def probe(env):
    """Its greatest irradiance 1, so that one kind of start suits all."""
    irradiance = env.probe(NORMALS)
    return irradiance / irradiance.max()
