"""`envlights split --shapes`."""

import json

import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main


def run(*arguments):
    return CliRunner().invoke(main, list(map(str, arguments)))


@pytest.fixture(scope="module")
def window(tmp_path_factory):
    """A map with one facing window of 30 by 20 degrees, a dozen pixels high."""
    path = tmp_path_factory.mktemp("maps") / "room.exr"
    sky = el.kernels.pixel_directions(128, 256)
    with np.errstate(all="ignore"):
        x, y = sky[..., 0] / sky[..., 2], sky[..., 1] / sky[..., 2]
    inside = (sky[..., 2] > 0) & (abs(x) < np.tan(np.radians(15))) & (abs(y) < np.tan(0.175))
    radiance = np.full((128, 256, 3), 0.1, np.float32)
    radiance[inside] = [20, 22, 25]
    el.EnvMap(radiance).save(path)
    return path


def test_split_writes_scenes_of_cards(window, tmp_path):
    outputs = [tmp_path / name for name in ("rest.exr", "scene.usda", "cards.png")]
    options = [part for each in outputs for part in ("-o", each)]
    result = run("split", window, "--shapes", "--distance", 4, *options)
    assert result.exit_code == 0, result.output
    cards, rest = el.split(el.EnvMap.open(window), shapes=True)
    assert cards.shape == ("rectangle",)
    assert result.stdout.startswith(str(cards).splitlines()[0])
    np.testing.assert_array_equal(el.EnvMap.open(outputs[0]).radiance, rest.radiance)
    assert f"wrote {tmp_path / 'scene.card_0.usd.exr'}" in result.stderr
    assert (tmp_path / "scene.usda").read_text().count("def RectLight") == 1
    assert outputs[2].stat().st_size > 10_000


def test_the_cards_are_printed_as_json(window):
    result = run("split", window, "--shapes", "--json")
    assert json.loads(result.stdout)["shape"] == ["rectangle"]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--distance", "3"], "add --shapes"),
        (["--shapes", "--limit", "9"], "leave out --limit, or --shapes"),
        (["--shapes", "--distance", "3", "--radius", "1"], "give only one of them"),
        (["--shapes", "--radius", "0"], "radius must be above 0"),
    ],
)
def test_options_that_do_not_fit_are_refused(window, options, message):
    result = run("split", window, *options)
    assert result.exit_code == 2
    assert message in result.stderr
