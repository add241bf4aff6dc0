"""Saved maps, read again."""

import time

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest

import envlights as el
from tests.conftest import fills_a_disk
from tests.helpers import disk_that_is_full_after

RADIANCE = np.random.default_rng(0).gamma(0.3, 10, (16, 32, 3)).astype(np.float32)


def spec_of(path):
    return oiio.ImageInput.open(str(path)).spec()


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
@pytest.mark.parametrize("compression", ["zip", "piz", "rle", "none"])
@pytest.mark.parametrize("half", [False, True])
def test_an_exr_file_comes_back_with_its_registration(tmp_path, registration, compression, half):
    env = el.EnvMap(RADIANCE, layout=el.io.Layout(registration=registration))
    env.save(tmp_path / "map.exr", half=half, compression=compression)
    again = el.EnvMap.open(tmp_path / "map.exr")
    assert again.registration == registration
    assert again.notes == ()
    wanted = RADIANCE.astype(np.float16) if half else RADIANCE
    np.testing.assert_array_equal(again.radiance, wanted)


@pytest.mark.parametrize("registration", ["cell-centred", "border-sampled"])
def test_what_an_exr_file_does_not_show_is_not_black_when_it_comes_back(tmp_path, registration):
    seen = np.ones(RADIANCE.shape[:2], np.float32)
    seen[-1] = 0
    layout = el.io.Layout(registration=registration)
    env = el.EnvMap(RADIANCE * seen[..., None], coverage=seen, layout=layout)
    env.save(tmp_path / "map.exr")
    again = el.EnvMap.open(tmp_path / "map.exr")
    np.testing.assert_array_equal(again.radiance, env.radiance)
    np.testing.assert_array_equal(again.coverage, seen)


@pytest.mark.parametrize(
    ("layout", "name", "options"),
    [
        ("octahedral", "map.exr", {}),
        ("cube", "map.exr", {}),
        ("cube", "map.exr", {"arrangement": "strip"}),
        ("cube", "map.exr", {"arrangement": "vertical-cross"}),
        ("cube", "{face}.exr", {}),
    ],
)
def test_nor_is_that_of_another_layout(tmp_path, layout, name, options):
    """Without the rows at the rim, whose pixels are partly seen."""
    seen = np.repeat([1.0, 0.0], 64)[:, None] * np.ones(256)
    env = el.EnvMap(np.full((128, 256, 3), 2.0), coverage=seen)
    files = env.to(layout).save(tmp_path / name, **options)
    again = el.EnvMap.open(files[0] if len(files) == 1 else list(map(str, files)))
    assert again.height == 128
    np.testing.assert_array_equal(again.coverage[:60], 1)
    np.testing.assert_array_equal(again.coverage[68:], 0)
    np.testing.assert_allclose(again.radiance[:60], 2, rtol=1e-6)


@pytest.mark.parametrize("half", [False, True])
def test_the_header_says_what_the_file_holds(tmp_path, half):
    el.EnvMap(RADIANCE, layout=el.io.Layout(registration="border-sampled")).save(
        tmp_path / "map.EXR", half=half
    )
    spec = spec_of(tmp_path / "map.EXR")
    assert str(spec.format) == ("half" if half else "float")
    assert spec["textureformat"] == "LatLong Environment"
    np.testing.assert_allclose(
        spec["chromaticities"], (0.64, 0.33, 0.30, 0.60, 0.15, 0.06, 0.3127, 0.3290), atol=1e-6
    )
    header = (tmp_path / "map.EXR").read_bytes()[:2000]
    assert b"envmap\0envmap\0\x01\0\0\0\0" in header  # ENVMAP_LATLONG, by the OpenEXR library
    assert spec["compression"] == "zip"


def test_a_hdr_file_keeps_eight_bits_of_the_largest_channel(tmp_path):
    el.EnvMap(RADIANCE).save(tmp_path / "map.hdr")
    again = el.EnvMap.open(tmp_path / "map.hdr")
    step = 2.0 ** (np.floor(np.log2(RADIANCE.max(axis=2, keepdims=True))) - 7)
    assert (np.abs(again.radiance - RADIANCE) <= step).all()
    assert (tmp_path / "map.hdr").read_bytes().startswith(b"#?RADIANCE\n")


def test_a_border_sampled_map_becomes_cells_where_the_file_cannot_say_so(tmp_path):
    env = el.EnvMap(
        el.synthetic.hall(64).radiance, layout=el.io.Layout(registration="border-sampled")
    )
    env.save(tmp_path / "map.hdr")
    again = el.EnvMap.open(tmp_path / "map.hdr")
    up = [[0.0, 1.0, 0.0]]
    np.testing.assert_allclose(again.probe(up), env.probe(up), rtol=0.02)


def test_what_cannot_be_written_is_refused(tmp_path):
    env = el.EnvMap(RADIANCE * np.float32(1e5))
    with pytest.raises(el.EnvLightsError, match=r"the suffix must be one of \.exr, \.hdr"):
        env.save(tmp_path / "map.png")
    with pytest.raises(el.EnvLightsError, match="above their 65504"):
        env.save(tmp_path / "map.exr", half=True)
    with pytest.raises(el.EnvLightsError, match="compression must be 'zip' or"):
        env.save(tmp_path / "map.exr", compression="jpeg")
    with pytest.raises(el.EnvLightsError, match=r"half and compression are of \.exr files"):
        env.save(tmp_path / "map.hdr", half=True)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("suffix", [".exr", ".hdr"])
def test_a_file_does_not_depend_on_the_hour_of_writing(tmp_path, suffix):
    env = el.EnvMap(el.synthetic.hall(8).radiance)
    env.save(tmp_path / f"one{suffix}")
    time.sleep(1.1)  # the clock of file headers counts seconds
    env.save(tmp_path / f"two{suffix}")
    one, two = ((tmp_path / f"{name}{suffix}").read_bytes() for name in ("one", "two"))
    assert one == two


#: Names of files, and registrations of maps.
KINDS = [
    ("map.exr", "cell-centred"),
    ("map.exr", "border-sampled"),
    ("map.hdr", "cell-centred"),
]
LARGE = np.random.default_rng(1).gamma(0.3, 10, (400, 800, 3)).astype(np.float32)


@fills_a_disk
@pytest.mark.parametrize("share", [0.0, 0.1, 0.4, 0.7, 0.999])
@pytest.mark.parametrize(("name", "registration"), KINDS)
def test_a_disk_that_is_full_at_any_piece_of_rows_leaves_the_old_file(
    tmp_path, name, registration, share
):
    old, new = (
        el.EnvMap(each, layout=el.io.Layout(registration=registration))
        for each in (LARGE[:32, :64], LARGE)
    )
    new.save(tmp_path / name)
    size = (tmp_path / name).stat().st_size
    old.save(tmp_path / name)
    before = (tmp_path / name).read_bytes()
    with (
        disk_that_is_full_after(int(share * size)),
        pytest.raises(el.EnvLightsError, match=f"cannot write .*{name}"),
    ):
        new.save(tmp_path / name)
    assert [each.name for each in tmp_path.iterdir()] == [name]
    assert (tmp_path / name).read_bytes() == before


def radiance_header(path):
    return path.read_bytes().split(b"\n\n")[0].decode().splitlines()


@pytest.mark.parametrize(
    ("name", "encoder"), [("map.hdr", "radiance_rows"), ("map.exr", "exr_file")]
)
def test_ctrl_c_while_rows_are_encoded_leaves_the_old_file(tmp_path, monkeypatch, name, encoder):
    el.EnvMap(LARGE[::-1]).save(tmp_path / name)
    before = (tmp_path / name).read_bytes()

    def interrupt(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr(f"envlights._native.{encoder}", interrupt)
    with pytest.raises(KeyboardInterrupt):
        el.EnvMap(LARGE).save(tmp_path / name)
    assert (tmp_path / name).read_bytes() == before
    assert [each.name for each in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("width", [4, 8, 64, 512])
@pytest.mark.parametrize("spread", [0.0, 0.5, 3.0])
def test_radiance_mantissas_are_rounded_to_nearest(tmp_path, width, spread):
    radiance = np.random.default_rng(width).lognormal(0, spread, (width // 2, width, 3))
    radiance = radiance.astype(np.float32)
    el.EnvMap(radiance).save(tmp_path / "map.hdr")
    back = el.EnvMap.open(tmp_path / "map.hdr").radiance
    most = radiance.max(axis=2, keepdims=True)
    assert (np.abs(back - radiance) / most).max() <= 1 / 255.5 + 1e-6
    if width > 8 and spread:
        assert abs(back.sum(dtype=float) / radiance.sum(dtype=float) - 1) < 1e-3


@pytest.mark.parametrize("sample", [1.8e38, 2e38, 3e38, 3.4e38])
def test_a_sample_beyond_radiance_is_refused(tmp_path, sample):
    radiance = np.full((4, 8, 3), 0.1, np.float32)
    radiance[1, 2, 0] = sample
    with pytest.raises(el.EnvLightsError, match=r"above the 1.7e\+38 of Radiance files.* \.exr"):
        el.EnvMap(radiance).save(tmp_path / "map.hdr")
    assert not list(tmp_path.iterdir())


def test_the_largest_sample_of_radiance_is_written(tmp_path):
    radiance = np.full((4, 8, 3), 1.69e38, np.float32)
    el.io.write_hdr(tmp_path / "map.hdr", radiance)
    np.testing.assert_allclose(el.io.read_image(tmp_path / "map.hdr").pixels, 1.69e38, rtol=0.004)


def test_notes_become_comments_of_one_line_each(tmp_path):
    notes = ["ICC profile: linear", "two\nlines\x1b[31m", "FORMAT=x"]
    env = el.EnvMap(np.ones((8, 16, 3), np.float32), notes=notes)
    env.save(tmp_path / "map.hdr")
    header = radiance_header(tmp_path / "map.hdr")
    assert header[0] == "#?RADIANCE"
    assert header[1:4] == ["# ICC profile: linear", "# two lines [31m", "# FORMAT=x"]
    assert "EXPOSURE=1" in header
    assert "PRIMARIES=0.64 0.33 0.3 0.6 0.15 0.06 0.3127 0.329" in header
    env.save(tmp_path / "map.exr")
    spec = oiio.ImageInput.open(str(tmp_path / "map.exr")).spec()
    assert spec["ImageDescription"].splitlines() == [line[2:] for line in header[1:4]]


@pytest.mark.parametrize("width", [4, 64, 300])
def test_opencv_reads_what_is_written(tmp_path, width):
    cv2 = pytest.importorskip("cv2")
    radiance = np.random.default_rng(1).lognormal(0, 1, (width // 2, width, 3)).astype(np.float32)
    radiance[: width // 8] = 0.5
    el.io.write_hdr(tmp_path / "map.hdr", radiance)
    wanted = el.io.read_image(tmp_path / "map.hdr").pixels
    read = cv2.imread(str(tmp_path / "map.hdr"), cv2.IMREAD_UNCHANGED)[..., ::-1]
    np.testing.assert_allclose(read, wanted, rtol=1e-6)
