"""One fact, one answer: what a map knows is known in every function that reads it."""

from html import unescape

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights._common.notes import warnings
from envlights.cli import main
from tests.layouts.test_panorama_check import codes, eyes, panorama
from tests.layouts.worlds import smooth, upright_directions
from tests.sun.skies import expose, sunny, towards

SUN = towards(130, 35)
CLIPPED = expose(sunny(SUN)[0], 0.01)[0]
GREY = np.full((32, 64), 0.5) + 0.2 * np.eye(32, 64)
SKY = np.asarray(panorama(64), np.float32)


HIDDEN = np.tile(np.arange(128) >= 120, (64, 1))


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
    "16 bits in floats": (np.float32(257) * CLIPPED, "codes"),
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


FACES = ("front", "right", "back", "left", "up", "down")
#: Facts of pictures with six faces, and of files: what is written, and its options.
FACTS |= {
    "faces": (np.array(smooth(upright_directions(32))), "layout"),
    "named faces": (dict(zip(FACES, smooth(upright_directions(32)), strict=True)), "layout"),
    "masked": (np.ma.array(SKY, mask=np.broadcast_to(HIDDEN[..., None], SKY.shape)), "unseen"),
}
LAYERS = ["R", "G", "B", "side.R", "side.G", "side.B"]
FILES = {
    "file of codes": (CLIPPED, "a.png", {}, "decoded"),
    "16 bits": (CLIPPED.astype(np.uint16) * 257, "a.tif", {}, "decoded"),
    "one layer": (np.dstack([SKY, SKY]), "a.exr", {"channelnames": LAYERS}, "layer"),
    "codes in floats": (CLIPPED.astype(np.float32), "a.exr", {}, "codes"),
    "depth": (np.dstack([SKY, SKY[..., :1]]), "a.exr", {"channelnames": [*"RGBZ"]}, "channels"),
    "grey file": (SKY[..., :1], "a.exr", {"channelnames": ["Y"]}, "grey"),
    "file with nan": (sky_with(np.nan), "a.exr", {}, "nan"),
    "units": (SKY, "a.exr", {"whiteLuminance": 100.0}, "calibrated"),
    "data window": (SKY[8:56], "a.exr", {"y": 8, "full_height": 64}, "data-window"),
}


#: Codes that take the place of another: the fill of a part that is not seen states that part.
REPLACED = {"unseen": ("filled",)}


def ways(world):
    """Notes of each function on an input."""
    env = el.EnvMap.open(world) if isinstance(world, str) else el.EnvMap(world)
    yield "EnvMap", env.notes
    yield "detect", el.detect(world).report.notes
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
    env = el.EnvMap(world)
    for note in warnings(env.notes):
        assert note in el.find_sun(world).notes
        compared = el.compare(world, env).notes
        assert f"truth: {note}" in compared
        assert f"guess: {note}" in compared
    assert not any(note.code == "other" for note in env.notes)


@pytest.mark.parametrize("fact", FILES)
def test_every_function_and_command_knows_what_the_file_knows(fact, tmp_path):
    picture, name, options, code = FILES[fact]
    path = str(tmp_path / name)
    spec = oiio.ImageSpec(*picture.shape[1::-1], picture.shape[2], str(picture.dtype))
    for key, value in options.items():
        known = hasattr(spec, key)
        setattr(spec, key, value) if known else spec.attribute(key, value)
    file = oiio.ImageOutput.create(path)
    assert file.open(path, spec)
    file.write_image(np.ascontiguousarray(picture))
    file.close()
    assert not [
        way for way, notes in ways(path) if code not in {el.Note(note).code for note in notes}
    ]
    text = next(note for note in el.EnvMap.open(path).notes if note.code == code)
    page = tmp_path / "page.html"
    for command in (["show", path, "-o", str(page)], ["fit", path, "-n", "1"], ["detect", path]):
        said = CliRunner().invoke(main, command).output
        if page.exists():
            said += unescape(page.read_text())
            page.unlink()
        assert " ".join(text.split()) in " ".join(said.split())


@pytest.mark.parametrize(
    "form", ["codes", "EnvMap", "floats", "whole floats", "over 255", "bright"]
)
def test_a_clipped_sun_is_one_sun_in_each_form(form):
    env = el.EnvMap(CLIPPED)
    forms = {
        "codes": CLIPPED,
        "EnvMap": env,
        "floats": np.asarray(env.radiance),
        "whole floats": CLIPPED.astype(float),
        "over 255": CLIPPED / 255,
        "bright": 2.5 * np.asarray(env.radiance),
    }
    world = forms[form]
    own = env if form == "EnvMap" else el.EnvMap(world)
    assert own.clipped_fraction == env.clipped_fraction
    assert el.find_sun(world).answer == "sun"
    assert len(el.with_sun(world).lights) == 1
    assert "was raised by a factor" in own.repaired().notes[-1]
    found, expected = el.detect(world), el.detect(env)
    np.testing.assert_array_equal(found.direction, expected.direction)
    np.testing.assert_array_equal(found.is_clipped, expected.is_clipped)
    assert expected.report.clip_level == 1
    assert found.report.clip_level == (2.5 if form == "bright" else 1)
