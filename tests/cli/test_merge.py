"""`envlights merge`."""

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click.testing import CliRunner

import envlights as el
from envlights._common.srgb import encode_srgb
from envlights.cli import main


@pytest.fixture
def shots(tmp_path):
    truth = np.full((32, 64, 3), 0.1)
    truth[:16] = np.geomspace(0.02, 40, 64)[None, :, None]
    for number, time in enumerate((1 / 50, 1 / 5, 2.0)):
        spec = oiio.ImageSpec(64, 32, 3, "uint8")
        file = oiio.ImageOutput.create(str(tmp_path / f"{number}.png"))
        assert file.open(str(tmp_path / f"{number}.png"), spec)
        file.write_image(np.round(255 * encode_srgb(truth * time)).astype(np.uint8))
        file.close()
    return tmp_path, truth


def run(*arguments):
    return CliRunner().invoke(main, ["merge", *map(str, arguments)])


def test_files_of_a_pattern_are_merged(shots):
    folder, truth = shots
    out = folder / "out.exr"
    result = run(folder / "*.png", "-o", out, "--times", "1/50,1/5,2")
    assert result.exit_code == 0, result.output
    np.testing.assert_allclose(el.EnvMap.open(out).radiance[:16], truth[:16], rtol=0.06)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["*.tif", "-o", "out.exr"], "no file matches"),
        (["*.png", "-o", "out.png"], "the suffix must be one of .exr, .hdr"),
        (["*.png", "-o", "out.exr", "--times", "1/50,a,2"], "fractions such as 1/50"),
        (["*.png", "-o", "out.exr", "--times", "1/0,1,2"], "fractions such as 1/50"),
        (["*.png", "-o", "out.exr", "--times", "1,2"], "a time for each exposure (3); got 2"),
        (["*.png", "-o", "out.exr"], "holds no exposure time in its EXIF; give times"),
    ],
)
def test_refusals_are_sentences(shots, monkeypatch, arguments, message):
    monkeypatch.chdir(shots[0])
    result = run(*arguments)
    assert result.exit_code == 2
    assert message in result.output
