"""One fact, one answer: what a map knows is known in every function that reads it."""

import numpy as np
import pytest

import envlights as el
from tests.layouts.test_panorama_check import codes, eyes, panorama
from tests.sun.skies import expose, sunny, towards

SUN = towards(130, 35)
CLIPPED = expose(sunny(SUN)[0], 0.01)[0]
GREY = np.full((32, 64), 0.5) + 0.2 * np.eye(32, 64)
SKY = np.asarray(panorama(64), np.float32)


def sky_with(value, at=(20, 30, 1)):
    sky = SKY.copy()
    sky[at] = value
    return sky


#: Input and the code of the note that states the fact.
FACTS = {
    "clipped": (CLIPPED, "decoded"),
    "clip level below 255": ((0.9 * CLIPPED).astype(np.uint8), "clip-level"),
    "codes in floats": (CLIPPED.astype(np.float32), "codes"),
    "codes over 255": (CLIPPED / 255, "codes"),
    "two eyes": (codes(eyes("squeezed")), "layout-doubt"),
    "two eyes above": (codes(eyes("above")), "layout-doubt"),
    "part": (codes(panorama()[48:144, 40:232]), "layout-doubt"),
    "grey": (GREY, "grey"),
    "nan": (sky_with(np.nan), "nan"),
    "infinite": (sky_with(np.inf), "infinite"),
    "negative": (sky_with(-1.0), "negative"),
    "nearly 2:1": (np.full((100, 201, 3), 0.5) * np.arange(1, 202)[:, None] % 7, "shape"),
    "unseen": (np.dstack([SKY, np.tile(np.arange(128) < 123, (64, 1))]), "unseen"),
}


#: Codes that take the place of another: the fill of a part that is not seen states that part.
REPLACED = {"unseen": ("filled",)}


def ways(world):
    """Notes of each function on an input."""
    env = el.EnvMap(world)
    yield "EnvMap", env.notes
    yield "fit of the input", el.fit(world, 1).notes
    yield "fit of the map", el.fit(env, 1).notes
    yield "split", el.split(world, 1).remainder.notes
    yield "split into cards", el.split(world, 1, shapes=True).remainder.notes
    yield "limit", el.limit(world, float(env.radiance.max())).remainder.notes
    yield "repaired", env.repaired().notes
    yield "resized", env.resized(32).notes
    yield "with_sun", el.with_sun(world).remainder.notes
    yield "error_curve", el.error_curve(world, [0, 1]).rigs[1].notes


@pytest.mark.parametrize("fact", FACTS)
def test_every_function_knows_what_the_map_knows(fact):
    world, code = FACTS[fact]
    silent = [
        way
        for way, notes in ways(world)
        if not {code, *REPLACED.get(code, ())} & {el.Note(note).code for note in notes}
    ]
    assert not silent


@pytest.mark.parametrize("form", ["codes", "EnvMap", "floats", "whole floats", "over 255"])
def test_a_clipped_sun_is_one_sun_in_each_form(form):
    env = el.EnvMap(CLIPPED)
    forms = {
        "codes": CLIPPED,
        "EnvMap": env,
        "floats": np.asarray(env.radiance),
        "whole floats": CLIPPED.astype(float),
        "over 255": CLIPPED / 255,
    }
    world = forms[form]
    own = env if form == "EnvMap" else el.EnvMap(world)
    # Without a known level, only the level itself is clipped, not codes from 254 on.
    assert own.clipped_fraction == pytest.approx(env.clipped_fraction, rel=0.15)
    assert el.find_sun(world).answer == "sun"
    assert len(el.with_sun(world).lights) == 1
    assert "was raised by a factor" in own.repaired().notes[-1]
