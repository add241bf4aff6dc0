"""Every command takes a file for the same map, or refuses it with the same sentence."""

import re

import numpy as np
import OpenImageIO as oiio  # noqa: N813, its own name for itself
import pytest
from click import Context
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.cli.refusal_words import with_options
from envlights.environment.decoders.description import LAYOUT
from envlights.environment.files.image_output import write_exr, write_hdr, write_png, write_tiff
from envlights.environment.layouts.faces import arranged_faces
from envlights.environment.reduced_file import reduce_file
from tests.layouts.files import dds, jpeg_with
from tests.layouts.worlds import smooth, upright_directions

WRITERS = {"exr": write_exr, "hdr": write_hdr, "png": write_png, "tif": write_tiff}
CUBE = (smooth(upright_directions(16)) / 16).clip(0, 1)
ENV = el.EnvMap(CUBE, layout=el.io.Layout.cube(faces="py360convert"), width=128)
RNG = np.random.default_rng(0)


def discs(level):
    """Dual fisheye, with corners of a level and a bright lamp in one disc."""
    at = (np.arange(64) + 0.5) / 32 - 1
    disc = np.where(np.hypot(at, at[:, None]) < 1, 0.4, level)[..., None] * np.ones(3)
    disc = disc + 0.01 * RNG.random(disc.shape)
    picture = np.hstack([disc, disc]).astype(np.float32)
    picture[30:34, 30:34] = 1
    return picture


def noise(height, width):
    return RNG.uniform(0.1, 0.9, (height, width, 3)).astype(np.float32)


def picture_of(arrangement):
    return np.ascontiguousarray(arranged_faces(CUBE, "opengl", arrangement))


def gpano(width, height, left, top, of=128):
    return {
        "GPano__ProjectionType": "equirectangular",
        "GPano__FullPanoWidthPixels": of,
        "GPano__FullPanoHeightPixels": of // 2,
        "GPano__CroppedAreaImageWidthPixels": width,
        "GPano__CroppedAreaImageHeightPixels": height,
        "GPano__CroppedAreaLeftPixels": left,
        "GPano__CroppedAreaTopPixels": top,
    }


PICTURES = {
    "panorama": ENV.radiance,
    "black corners": np.where(np.arange(64)[:, None, None] < 4, 0, ENV.radiance),
    "discs": discs(0.0),
    "noisy corners": discs(0.002),
    "strip": picture_of("strip"),
    "stack": CUBE.reshape(96, 16, 3),
    "cross": picture_of("horizontal-cross"),
    "vertical cross": picture_of("vertical-cross"),
    "square": noise(32, 32),
    "4 to 3": noise(24, 32),
    "3 to 2": noise(20, 30),
    "4 to 1": noise(16, 64),
    "off by one": noise(120, 241),
    "two pixels": noise(1, 2),
}
METADATA = {
    "crop": gpano(64, 32, 32, 16),
    "crop of the seam": gpano(128, 64, 64, 8, 256),
    "cylinder": {**gpano(90, 48, 0, -24, 180), "GPano__ProjectionType": "cylindrical"},
    "whole": gpano(128, 64, 0, 0),
    "stereo": {"GSpherical__StereoMode": "top-bottom"},
    "other": {"GPano__ProjectionType": "tetrahedral"},
}
REQUESTS = {
    "octahedral": {},
    "fisheye": {"fov": 170},
    "cylinder": {"fov": 230},  # 32x16: twice as wide as high
    "planar": {"fov": 60},
    "equirectangular": {},
}


def files():
    """Builder of each file, which takes a folder."""
    each = {}
    for name, picture in PICTURES.items():
        for suffix, write in WRITERS.items():
            each[f"{name}.{suffix}"] = (write, picture.astype(np.float32))
        each[f"{name}.jpg"] = (jpeg_with, picture)
    built = {
        name: lambda folder, name=name, write=write, picture=picture: write_to(
            folder / name, write, picture
        )
        for name, (write, picture) in each.items()
    }
    for name, said in METADATA.items():
        size = (64, 128) if name in ("whole", "stereo", "other") else (32, 64)
        built[f"{name}, GPano"] = lambda folder, said=said, size=size: jpeg_with(
            folder / "a.jpg", noise(*size), **said
        )
    for projection, options in REQUESTS.items():
        for suffix in WRITERS:
            built[f"{projection}, own.{suffix}"] = (
                lambda folder, projection=projection, options=options, suffix=suffix: ENV.to(
                    el.io.Layout(projection, **options), width=32
                ).save(folder / f"a.{suffix}")[0]
            )
    return {**built, **OTHERS}


def write_to(path, write, picture):
    write(path, picture)
    return path


def rotated_file(folder):
    spec = oiio.ImageSpec(64, 128, 3, "uint8")
    spec.attribute("Orientation", 6)
    file = oiio.ImageOutput.create(str(folder / "a.jpg"))
    assert file.open(str(folder / "a.jpg"), spec)
    assert file.write_image(np.rot90(ENV.radiance).copy())
    file.close()
    return folder / "a.jpg"


def six(folder):
    ENV.to("cube", width=16).save(folder)
    return folder


def border(folder):
    write_exr(folder / "a.exr", ENV.radiance, environment="latlong")
    return folder / "a.exr"


def damage(folder):
    write_exr(folder / "a.exr", ENV.radiance, comments=(LAYOUT + "{",))
    return folder / "a.exr"


OTHERS = {
    "orientation": rotated_file,
    "border-sampled": border,
    "six in a folder": six,
    "pattern": lambda folder: six(folder) / "{face}.exr",
    "damaged statement": damage,
    "one face": lambda folder: write_to(folder / "posx.hdr", write_hdr, CUBE[0]),
    "dds": lambda folder: dds(folder / "a.dds", CUBE),
    "missing": lambda folder: folder / "a.exr",
    "empty": lambda folder: write_to(folder / "a.exr", lambda path, _: path.write_bytes(b""), None),
}
FILES = files()


def outcome(work):
    """Result of a call, or its sentence."""
    try:
        return work()
    except el.EnvLightsError as refusal:
        return str(refusal)


@pytest.mark.parametrize("name", FILES)
def test_every_command_takes_a_file_for_the_same_map(tmp_path, name):
    path = FILES[name](tmp_path)
    env = outcome(lambda: el.EnvMap.open(path))
    whole = outcome(lambda: el.fit(env, 2, fill="black")) if isinstance(env, el.EnvMap) else env
    found = outcome(lambda: el.detect(env)) if isinstance(env, el.EnvMap) else env
    rig = outcome(lambda: el.fit(path, 2, fill="black"))
    assert outcome(lambda: el.detect(path)) == found
    if isinstance(whole, str):
        assert rig == whole
    else:
        assert rig.notes == whole.notes
        np.testing.assert_array_equal(rig.ambient, whole.ambient)
        assert rig.lights == whole.lights
    said = CliRunner().invoke(main, ["fit", str(path), "-n", "2", "--fill", "black"])
    of_file = r"it looks like|there is no such file|the file is empty"
    refused = 1 if re.search(of_file, str(whole)) else 2
    assert said.exit_code == (refused if isinstance(whole, str) else 0), said.output
    if isinstance(whole, str):
        words = with_options(whole, [main.get_command(Context(main), "fit")])
        assert words in re.sub(r"\s+", " ", said.output)


def test_six_files_are_taken_as_a_list_or_a_mapping(tmp_path):
    files = ENV.to("cube", width=16).save(tmp_path)
    for source in (list(files), tuple(files), {file.stem: file for file in files}):
        env = el.EnvMap.open(source)
        assert el.detect(source) == el.detect(env)
        assert el.fit(source, 2).lights == el.fit(env, 2).lights
    with pytest.raises(el.EnvLightsError, match="holds 5 pictures"):
        el.fit(list(files[:5]))


def test_usual_panoramas_are_never_whole_in_memory(tmp_path):
    for suffix, write in WRITERS.items():
        write(tmp_path / f"a.{suffix}", ENV.radiance)
        assert reduce_file(tmp_path / f"a.{suffix}", 256, 5e-3, False, 2) is not None
