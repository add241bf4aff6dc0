"""Maps of all kinds, and white probes under them, for comparisons of fits."""

from tests.helpers import EQUIRECTANGULAR, NORMALS, paths_of_real_maps

import envlights as el
from envlights import synthetic

#: Maps of each random family.
GENERATED = 4


def maps():
    """Each third is a fair sample: neighbours are of one kind."""
    return {**{path.name: el.EnvMap.open(path) for path in paths()}, **generated_maps()}


def paths():
    """Paths of the maps in the folder `ENVLIGHTS_MAPS`; an empty list without it."""
    # Pattern by pattern, so that neighbours are of one kind.
    return [path for pattern in EQUIRECTANGULAR for path in paths_of_real_maps(pattern)]


def generated_maps():
    """The hall of the demo, and some of each family of random maps."""
    worlds = {"hall": synthetic.hall(256)}
    for seed in synthetic.EVALUATION[:GENERATED]:
        for make in (synthetic.plain, synthetic.hard):
            worlds[f"{make.__name__} {seed}"] = make(seed, 256)
    return {name: el.EnvMap(world.radiance) for name, world in worlds.items()}


def real_and_generated():
    """The probe under each map."""
    return {name: probe(env) for name, env in maps().items()}


def probe(env):
    """Probe scaled to a largest irradiance of 1, so that one kind of start suits all."""
    irradiance = env.probe(NORMALS)
    return irradiance / irradiance.max()
