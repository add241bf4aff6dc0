"""Laws of light on random maps: turned, mirrored, scaled, channels exchanged, and added up."""

from functools import cache, partial

import numpy as np

import envlights as el
from tests.helpers import NORMALS, relative_errors
from tests.stress.case import U32, Case, cases_of, light_of, lights_apart

_CHANNELS = [2, 0, 1]
#: Columns of a map of 256 that are a quarter of a turn.
_QUARTER = 64


@cache
def _random(seed=0):
    """A map of noise with three lights, no two pixels alike."""
    rng = np.random.default_rng(seed)
    return (_lamps(seed) * rng.uniform(1, 1.1, (128, 256, 1))).astype(np.float32)


def _lamps(seed):
    """A map of noise with three lights, each of one radiance."""
    radiance = np.random.default_rng(seed).gamma(0.5, 1, (128, 256, 3))
    for row, column, size in ((30, 40, 4), (60, 150, 3), (90, 220, 6)):
        radiance[row : row + size, column : column + size] = 4000 / size, 3000 / size, 2000 / size
    return radiance.astype(np.float32)


def _turn(vectors):
    """Rotate vectors as a quarter roll of the map does."""
    return vectors @ np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])


def _mirror(vectors):
    return vectors * [-1, 1, 1]


def _same(vectors):
    return vectors


def _permute(irradiance):
    return irradiance[..., _CHANNELS]


#: What happens to the map; to directions; to RGB irradiance.
LAWS = {
    "a quarter turn": (lambda map: np.roll(map, _QUARTER, axis=1), _turn, _same),
    "a mirror": (lambda map: map[:, ::-1], _mirror, _same),
    "2^20 times": (lambda map: map * np.float32(2**20), _same, lambda e: 2.0**20 * e),
    "channels exchanged": (lambda map: map[..., _CHANNELS], _same, _permute),
}


def _probe(changed, directions, irradiance):
    normals = NORMALS[::2]
    wanted = irradiance(el.EnvMap(_random()).probe(normals))
    found = el.EnvMap(np.ascontiguousarray(changed(_random()))).probe(directions(normals))
    return float(np.abs(found / wanted - 1).max())


def _lights(find, changed, directions, irradiance):
    one, other = find(_random()), find(np.ascontiguousarray(changed(_random())))
    return lights_apart(other, directions(one.direction), irradiance(light_of(one)))


def _mirror_error(radiance):
    """The fit to a map in which pixels of one row are alike, and to its mirror image."""
    one, other = _fit_three(radiance), _fit_three(np.ascontiguousarray(radiance[:, ::-1]))
    return lights_apart(other, _mirror(one.direction), one.irradiance)


def _tube():
    """A map of noise with one lamp, wider than the points that a fit keeps."""
    radiance = _random().copy()
    radiance[50, 100:140] = 4000, 3000, 2000
    return radiance


def _fit_three(radiance):
    return el.fit(radiance, 3, sizes=False).lights


def _added_probe():
    one, other = _random(0), _random(1)
    parts = el.EnvMap(one).probe(NORMALS) + el.EnvMap(other).probe(NORMALS)
    return float(np.abs(el.EnvMap(one + other).probe(NORMALS) / parts - 1).max())


def _suns(*places):
    radiance = np.zeros((128, 256, 3), np.float32)
    for row, column, value in places:
        radiance[row, column] = value, value / 2, value / 3
    return radiance


def _added_lights(find):
    """Lights of the sum of two maps: those of both."""
    one, other = _suns((20, 30, 9e3), (70, 200, 5e3)), _suns((100, 90, 7e3))
    parts = [find(each) for each in (one, other)]
    wanted = np.concatenate([each.direction for each in parts])
    flux = np.concatenate([light_of(each) for each in parts])
    return lights_apart(find(one + other), wanted, flux)


def _fitted_suns(radiance):
    return el.fit(radiance, int((radiance[..., 0] > 0).sum()), ambient="none", sizes=False).lights


@cache
def _room():
    return el.synthetic.room(40, width=16)


def _model(direct, indirect):
    return el.TransferModel.fit(direct[:32], indirect[:32], rank=16)


def _transfer(direct_changed, indirect_changed):
    """A model of changed pairs predicts what the model of the pairs does, changed."""
    direct, indirect = _room().direct, _room().indirect
    wanted = indirect_changed(_model(direct, indirect).predict(direct[32:]))
    changed = np.ascontiguousarray(direct_changed(direct))
    model = _model(changed, np.ascontiguousarray(indirect_changed(indirect)))
    return float(relative_errors(model.predict(changed[32:]), wanted).max())


def _added_transfer():
    direct = _room().direct[32:].astype(float)
    model = _model(_room().direct, _room().indirect)
    parts = model.predict(direct) + model.predict(direct[::-1])
    return float(relative_errors(model.predict(direct + direct[::-1]), parts).max())


_TRANSFER = {
    "texels mirrored": (lambda each: each[:, :, ::-1],) * 2,
    "2^20 times": (lambda each: each * np.float32(2**20),) * 2,
    "channels exchanged": (_permute,) * 2,
    "images turned": (_same, lambda each: np.rot90(each, axes=(1, 2))),
}

_SUMS = "bound 2 in blocks of float32"

#: Detection weighs channels by luminance.
_OF_DETECTION = {name: law for name, law in LAWS.items() if name != "channels exchanged"}

CASES = [
    *cases_of("law", "probe, ", 8 * U32, _SUMS, _probe, LAWS),
    *cases_of(
        "law",
        "detection, ",
        8 * U32,
        "weights and samples in float32",
        partial(_lights, el.detect),
        _OF_DETECTION,
    ),
    *cases_of(
        "law", "fit, ", 1e-7, "descent to 1e-9 of a step", partial(_lights, _fit_three), LAWS
    ),
    *cases_of(
        "law",
        "fit, a mirror, pixels alike, ",
        1e-7,
        "pixels alike are kept as points or left together",
        lambda make: _mirror_error(make()),
        {"three lamps": (partial(_lamps, 0),), "a tube": (_tube,)},
    ),
    *cases_of("law", "transfer, ", 1e-5, "a basis in float32", _transfer, _TRANSFER),
    Case("law", "probe, two maps added", 8 * U32, _SUMS, _added_probe),
    Case(
        "law",
        "detection, suns of two maps",
        8 * U32,
        "a pixel is a light",
        partial(_added_lights, el.detect),
    ),
    Case(
        "law",
        "fit, suns of two maps",
        1e-8,
        "descent to 1e-9 of a step",
        partial(_added_lights, _fitted_suns),
    ),
    Case("law", "transfer, two lightings added", 1e-5, "frames in float32", _added_transfer),
]
