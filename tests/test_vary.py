"""Variations of rigs: each range, the same bits everywhere, and what is said to be changed."""

import hashlib
import os
import subprocess
import sys

import numpy as np
import pytest

import envlights as el
from envlights.kernels.ambient import turned_about_pole, turned_ambient
from envlights.kernels.image import LUMINANCE
from envlights.rigs.planck import planck_gains
from envlights.rigs.portable import circle, power_of_two
from tests.export.rigs import DISCS, rigs
from tests.helpers import NORMALS

TOLERANCES = (0.0, 0.05, 0.2, 1.0, np.pi)
#: All that leaves a rig as it is.
STILL = {"azimuth": 0, "exposure": 0, "temperature": 6504, "jitter": 0}


def rig_of(ambient="constant", tolerances=TOLERANCES):
    """Rig with tolerances, as of a fit."""
    rig = rigs(DISCS)[ambient]
    report = el.rigs.FitReport(direction_tolerances=tolerances)
    return el.Rig(rig.ambient, rig.lights, 0.01, report, floor=rig.floor)


def turn_by(degrees):
    """Rotation about +y that raises azimuths, whose zero is -z and whose quarter is +x."""
    angle = np.radians(degrees)
    return np.array(
        [[np.cos(angle), 0, -np.sin(angle)], [0, 1, 0], [np.sin(angle), 0, np.cos(angle)]]
    )


def shares(values, low, high, parts=10):
    """Fractions of the values in equal parts of a range."""
    return np.histogram(values, parts, (low, high))[0] / len(values)


@pytest.mark.parametrize("ambient", rigs(DISCS))
def test_a_rig_without_changes_is_itself(ambient):
    rig = rig_of(ambient)
    (same,) = el.vary(rig, 1, **STILL)
    np.testing.assert_allclose(same.rig.probe(NORMALS), rig.probe(NORMALS), rtol=1e-12)
    assert same.changes() == {
        "number": 0, "sources": [0], "mix": 0.0, "azimuth": 0.0, "exposure": 0.0,
        "temperature": pytest.approx(6504), "dropped": [], "jitter": [0.0] * 5,
    }  # fmt: skip


@pytest.mark.parametrize("ambient", rigs(DISCS))
def test_a_turned_rig_is_that_of_the_rotation(ambient):
    for each in el.vary(rig_of(ambient), 5, **{**STILL, "azimuth": (-90, 400)}):
        wanted = rig_of(ambient).rotated(turn_by(each.azimuth))
        np.testing.assert_allclose(each.rig.probe(NORMALS), wanted.probe(NORMALS), rtol=1e-9)
        turned = (each.rig.lights.azimuth - rig_of().lights.azimuth) % (2 * np.pi)
        np.testing.assert_allclose(turned[:3], np.radians(each.azimuth) % (2 * np.pi))


@pytest.mark.parametrize(
    ("name", "low", "high"), [("azimuth", 30, 90), ("exposure", -2, 3), ("temperature", 3000, 9000)]
)
def test_each_range_is_filled_evenly(name, low, high):
    values = [getattr(v, name) for v in el.vary(rig_of(), 2000, **{**STILL, name: (low, high)})]
    if name == "temperature":  # uniform in mireds
        values, low, high = 1e6 / np.array(values), 1e6 / high, 1e6 / low
    # Standard error of a tenth of 2000: 0.0067.
    assert shares(values, low, high).sum() == 1
    np.testing.assert_allclose(shares(values, low, high), 0.1, atol=4 * 0.0067)


def test_exposure_is_a_power_of_two():
    for each in el.vary(rig_of(), 5, **{**STILL, "exposure": (-4, 4)}):
        ratio = each.rig.probe(NORMALS) / rig_of().probe(NORMALS)
        np.testing.assert_allclose(ratio, 2.0**each.exposure, rtol=1e-12)


def planck_rec709(kelvins):
    """Linear Rec.709 of Planck's law under the colour matching functions of Wyman et al. (2013)."""
    nm = np.arange(380.0, 781.0)
    radiance = nm**-5.0 / np.expm1(1.438777e7 / (nm * kelvins))

    def lobe(mean, below, above):
        return np.exp(-0.5 * ((nm - mean) * np.where(nm < mean, below, above)) ** 2)

    x = 0.362 * lobe(442.0, 0.0624, 0.0374) + 1.056 * lobe(599.8, 0.0264, 0.0323)
    x -= 0.065 * lobe(501.1, 0.0490, 0.0382)
    y = 0.821 * lobe(568.8, 0.0213, 0.0247) + 0.286 * lobe(530.9, 0.0613, 0.0322)
    z = 1.217 * lobe(437.0, 0.0845, 0.0278) + 0.681 * lobe(459.0, 0.0385, 0.0725)
    to_rgb = [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    return np.array(to_rgb) @ [radiance @ x, radiance @ y, radiance @ z]


@pytest.mark.parametrize("kelvins", [2000, 2856, 4000, 5000, 6504, 8000, 15000])
def test_white_light_has_the_colour_of_a_black_body(kelvins):
    wanted = planck_rec709(kelvins) / planck_rec709(6504)
    wanted /= LUMINANCE @ wanted
    found = planck_gains(kelvins)
    # The fit of the colour matching functions is right to about a percent of their maxima.
    np.testing.assert_allclose(found, wanted, rtol=0.02, atol=0.005)
    assert LUMINANCE @ found == pytest.approx(1)
    (each,) = el.vary(rig_of(), 1, **{**STILL, "temperature": kelvins})
    ratio = each.rig.lights[:3].irradiance / DISCS[:3].irradiance
    np.testing.assert_allclose(sorted(ratio[0]), sorted(found), rtol=1e-9)


@pytest.mark.parametrize(("one", "two"), [("constant", "constant"), ("harmonics", "constant")])
def test_a_mix_lights_as_the_mean_of_both(one, two):
    both = rig_of(one), el.Rig(rig_of(two).ambient, DISCS[:2].rotated(turn_by(70)), 0.02)
    seen = set()
    for each in el.vary(both, 20, **{**STILL, "mix": (0.1, 0.9)}):
        seen.add(each.sources)
        first, second = (both[k].probe(NORMALS) for k in each.sources)
        wanted = (1 - each.mix) * first + each.mix * second
        np.testing.assert_allclose(each.rig.probe(NORMALS), wanted, rtol=1e-9)
        assert 0.1 <= each.mix <= 0.9
        assert each.rig.error == 0.02
    assert seen == {(0, 1), (1, 0)}


def test_lights_are_dropped_as_often_as_asked():
    each = list(el.vary(rig_of(), 1000, **{**STILL, "drop": 0.3}))
    dropped = np.bincount([row for v in each for row in v.dropped], minlength=5) / 1000
    np.testing.assert_allclose(dropped, 0.3, atol=4 * 0.0145)  # the standard error
    for one in each[:20]:
        kept = [row for row in range(5) if row not in one.dropped]
        np.testing.assert_allclose(one.rig.lights.direction, DISCS[kept].direction, atol=1e-12)


def test_a_light_moves_within_its_tolerance_and_evenly_there():
    each = list(el.vary(rig_of(), 1000, **{**STILL, "jitter": 0.5}))
    found = np.array([v.rig.lights.direction for v in each])
    angles = np.linalg.norm(found - DISCS.direction, axis=2)
    np.testing.assert_allclose(angles, [v.jitter for v in each], atol=1e-12)
    widest = 2 * np.sin(0.5 * np.minimum(TOLERANCES, np.radians(20)) / 2)
    assert (angles <= widest + 1e-12).all()
    # Uniform on a cap: the square of the chord is uniform, and all sides have the same number.
    squares = (angles[:, 2] / widest[2]) ** 2
    np.testing.assert_allclose(shares(squares, 0, 1), 0.1, atol=4 * 0.0095)
    shift = (found[:, 2] - DISCS.direction[2]).mean(axis=0)
    tangential = shift - (shift @ DISCS.direction[2]) * DISCS.direction[2]
    assert np.linalg.norm(tangential) < 4 * widest[2] / np.sqrt(2000)


def test_a_rig_without_a_fit_keeps_its_directions():
    rig = rigs(DISCS)["constant"]
    (each,) = el.vary(rig, 1, **{**STILL, "jitter": 1})
    np.testing.assert_allclose(each.rig.lights.direction, DISCS.direction, atol=1e-15)


def test_a_variation_depends_on_its_number_and_its_own_ranges_alone():
    rig, ranges = rig_of(), {"mix": 0, "drop": 0.3}
    many, few = list(el.vary(rig, 5, seed=3, **ranges)), el.vary(rig, seed=3, **ranges)
    assert [next(few).rig for _ in range(5)] == [v.rig for v in many]
    darker = list(el.vary(rig, 5, seed=3, **ranges, exposure=-9))
    for name in ("azimuth", "temperature", "dropped", "jitter"):
        assert [getattr(v, name) for v in darker] == [getattr(v, name) for v in many]
    assert next(el.vary(rig, 1, seed=4)).azimuth != many[0].azimuth


def digest():
    """Hash of the bits of 50 variations of two rigs."""
    both = rig_of("harmonics"), rig_of("constant", TOLERANCES[::-1])
    total = hashlib.sha256()
    for each in el.vary(both, 50, seed=11, mix=(0, 1), drop=0.2):
        rig = each.rig
        lights = rig.lights
        for array in (rig.ambient, lights.direction, lights.irradiance, lights.angular_radius):
            total.update(np.ascontiguousarray(array, "<f8").tobytes())
        total.update(repr(each.changes()).encode())
    return total.hexdigest()


#: Hash on every machine.
DIGEST = "85527223caba34c8ad92f0fc93bd4b91aba10ade43618963a0fee156daf9dd4b"


def test_the_same_seed_gives_the_same_bits_on_every_machine():
    assert digest() == DIGEST


def test_processors_without_vector_instructions_give_the_same_bits():
    """NumPy takes other loops for sines, sums and products there."""
    names = "AVX2 FMA3 AVX512F AVX512_SKX AVX512_ICL AVX512_SPR X86_V3 X86_V4"
    code = "import tests.test_vary as t; print(t.digest())"
    settings = {"NPY_DISABLE_CPU_FEATURES": names, "OPENBLAS_CORETYPE": "Nehalem"}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", code], env={**os.environ, **settings},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.stdout.strip() == DIGEST, done.stderr[-500:]


def test_portable_functions_are_those_of_mathematics():
    turns = np.linspace(-3, 3, 4801)
    cosine, sine = circle(turns)
    np.testing.assert_allclose(cosine, np.cos(2 * np.pi * turns), atol=5e-15)
    np.testing.assert_allclose(sine, np.sin(2 * np.pi * turns), atol=5e-15)
    assert [float(each) for each in circle(0.25)] == pytest.approx([0, 1], abs=1e-16)
    for exponent in np.linspace(-20, 20, 401):
        assert power_of_two(exponent) == pytest.approx(2.0**exponent, rel=1e-15)
    harmonics = rigs(DISCS)["harmonics"].ambient
    cosine, sine = (float(each) for each in circle(0.2))
    wanted = turned_ambient(harmonics, turn_by(72))
    np.testing.assert_allclose(turned_about_pole(harmonics, cosine, sine), wanted, atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"exposure": (1, 0)}, "exposure must have its lowest value first"),
        ({"temperature": 1000}, "temperature must be a finite number, from 2000 to 15000"),
        ({"mix": 0.5}, "mix needs two rigs or more"),
        ({"drop": 2}, "drop must be a finite number, from 0 to 1"),
        ({"azimuth": (1, 2, 3)}, "azimuth must be a number, or the lowest and the highest"),
        ({"count": -1}, "count must be"),
        ({"seed": 1.5}, "seed must be a whole number"),
    ],
)
def test_what_is_no_range_is_refused(arguments, words):
    with pytest.raises(el.EnvLightsError, match=words):
        el.vary(rig_of(), **arguments)


def test_what_is_no_rig_is_refused():
    for none in ([], DISCS, "rig.json", [rig_of(), DISCS], 3):
        with pytest.raises(el.EnvLightsError, match="rigs must be a Rig or several"):
            el.vary(none, 1)
    nits = el.Rig([0, 0, 0], el.Lights([[0, 1, 0]], [[1, 1, 1]], units="cd/m2"), 0.0)
    with pytest.raises(el.EnvLightsError, match="rigs must have the same units"):
        el.vary([rig_of(), nits], 1)
    with pytest.raises(el.EnvLightsError, match="all with a floor or all without one"):
        el.vary([rig_of(), rig_of("floor")], 1, mix=0.5)
