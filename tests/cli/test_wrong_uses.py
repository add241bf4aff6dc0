"""Wrong uses of the command line: class of the refusal, exit code, and a sentence with a way out.

To add one, add a row. `FILES` are the files of the folder in which each row runs.
"""

import click
import numpy as np
import pytest
from click.testing import CliRunner

import envlights as el
from envlights.cli import main
from envlights.environment.files.image_output import write_png

#: Files that are no maps, and their bytes.
FILES = {
    "empty.exr": b"",
    "pointer.exr": b"version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n",
    "photo.heic": b"\0\0\0\x18ftypheic\0\0\0\0mif1heic",
    "pixel.heic": b"\0\0\0\x18ftypmif1\0\0\0\0mif1heic",
    "clip.mp4": b"\0\0\0\x18ftypisom\0\0\2\0isomiso2",
    "clip.mov": b"\0\0\0\x14ftypqt  \0\0\2\0qt  ",
    "clip.webm": b"\x1aE\xdf\xa3\1\0\0\0\0\0\0\x1f",
    "clip.avi": b"RIFF\0\0\0\0AVI LIST",
    "page.hdr": b"<!DOCTYPE html><html></html>",
    "maps.hdr": b"PK\3\4\0\0\0\0",
    "map.hdr.gz": b"\x1f\x8b\x08\0\0\0",
    "map.ktx2": b"\xabKTX 20\xbb\r\n\x1a\n",
    "map.dds": b"DDS |\0\0\0",
    "map.webp": b"RIFF\0\0\0\0WEBPVP8 ",
    "map.npy": b"\x93NUMPY\1\0",
    "paper.pdf": b"%PDF-1.7",
    "words.exr": b"this is no picture",
    "cut.hdr": b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n\2\2",
    "cut.png": b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0",
    "cut.json": b'{"format": "envlights rig", ',
    "other.json": b'{"format": "something"}',
    "future.json": b'{"format": "envlights rig", "version": 99}',
    "half.json": b'{"format": "envlights rig", "version": 5, "ambient": [1, 1, 1]}',
    "words.csv": b"a,b\n1,2\n",
}

GENERAL, MISSING, DAMAGED = el.EnvLightsError, el.io.MissingFileError, el.io.DamagedFileError
FILE, USAGE = el.FileError, click.UsageError

#: Arguments, class, exit code, words of the sentence.
WRONG = [
    ("fit none.exr", MISSING, 1, "there is no such file; give a Radiance .hdr, OpenEXR"),
    ("detect none.exr", MISSING, 1, "there is no such file; give a Radiance .hdr"),
    ("split none.exr", MISSING, 1, "there is no such file; give a Radiance .hdr"),
    ("convert none.exr out.exr", MISSING, 1, "there is no such file; give a Radiance"),
    ("view none.exr", MISSING, 1, "there is no such file; give a Radiance .hdr"),
    ("show none.exr", MISSING, 1, "there is no such file; give a Radiance .hdr"),
    ("compare none.exr hall.exr", MISSING, 1, "there is no such file"),
    ("photograph none.jpg", MISSING, 1, "there is no such file; give a Radiance"),
    ("export none.json usd", MISSING, 1, "there is no such file; check its path"),
    ("export none.csv usd", MISSING, 1, "there is no such file; check its path"),
    ("view hall.exr --rig none.json", MISSING, 1, "there is no such file; check its path"),
    ("transfer apply none.npz hall.exr -o out.exr", MISSING, 1, "there is no such file; check"),
    ("fit folder", FILE, 1, "give one file, or six as a list, a mapping, a folder, or a name"),
    ("photograph folder", FILE, 1, "it is a folder; give a file in it"),
    ("export folder usd", FILE, 1, "Is a directory; check its path"),
    ("fit empty.exr", FILE, 1, "the file is empty; give a Radiance .hdr"),
    ("fit pointer.exr", FILE, 1, "pointer of Git LFS, not the file itself: `git lfs pull`"),
    ("fit photo.heic", FILE, 1, "HEIC image (`heif-convert` of libheif writes it as PNG)"),
    ("fit pixel.heic", FILE, 1, "HEIC image (`heif-convert` of libheif writes it as PNG)"),
    ("fit clip.mp4", FILE, 1, "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame"),
    ("fit clip.mov", FILE, 1, "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame"),
    ("fit clip.webm", FILE, 1, "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame"),
    ("fit clip.avi", FILE, 1, "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame"),
    ("fit page.hdr", FILE, 1, "it looks like a web page; give a Radiance .hdr"),
    ("fit maps.hdr", FILE, 1, "it looks like a ZIP archive; give a Radiance .hdr"),
    ("fit map.hdr.gz", FILE, 1, "it looks like a gzip archive; give a Radiance .hdr"),
    ("fit map.ktx2", FILE, 1, "`ktx extract` of KTX-Software writes its six faces"),
    ("fit map.dds", FILE, 1, "DDS texture, which is read only with --any-format"),
    ("fit map.webp", FILE, 1, "WebP image, which is read only with --any-format"),
    ("fit map.npy", FILE, 1, "NumPy array, which `numpy.load` reads"),
    ("fit paper.pdf", FILE, 1, "PDF document; give a Radiance .hdr"),
    ("fit words.exr", FILE, 1, "its first bytes are of no known image; give a Radiance .hdr"),
    ("fit rig.json", FILE, 1, "perhaps a rig, which `Rig.load` and `envlights export` read"),
    ("fit cut.hdr", DAMAGED, 1, "give a Radiance .hdr"),
    ("fit cut.png", DAMAGED, 1, "give a Radiance .hdr"),
    ("fit cut.exr", DAMAGED, 1, "give"),
    ("export cut.json usd", DAMAGED, 1, "is not a JSON file"),
    ("export half.json usd", DAMAGED, 1, "is not a complete rig: the key 'lights' is missing"),
    ("export other.json usd", FILE, 1, "it does not say 'format': 'envlights "),
    ("export future.json usd", FILE, 1, "is a rig of version 99; this package reads"),
    ("export words.csv usd", DAMAGED, 1, "is not a table of lights: its first line is not"),
    ("fit square.png", GENERAL, 2, "projection"),
    ("fit cross.png --projection cub", GENERAL, 2, "projection must be"),
    ("fit hall.exr --faces opengl", GENERAL, 2, "or --projection if it is no cube map"),
    ("fit hall.exr --colour no", GENERAL, 2, "linear"),
    ("fit hall.exr -n -1", GENERAL, 2, "lights must be a whole number, 0 or more; got -1"),
    ("fit hall.exr -n 3.5", USAGE, 2, "'3.5' is not a valid integer"),
    ("fit hall.exr --error 2", GENERAL, 2, "error must be a finite number, from 0 to 1"),
    ("fit hall.exr --error 1", GENERAL, 2, "error must be below 1"),
    ("fit hall.exr --error 2 -o rig.png", GENERAL, 2, "error must be a finite number, from 0 to 1"),
    (
        "fit hall.exr --error 2 --clip-level 3",
        GENERAL,
        2,
        "error must be a finite number, from 0 to 1",
    ),
    ("fit hall.exr --roughness 0", GENERAL, 2, "roughness must be"),
    ("fit hall.exr --max-radius 100", GENERAL, 2, "max_radius must be"),
    ("fit hall.exr --max-radius 10 --points", GENERAL, 2, "Leave out one of them"),
    ("fit hall.exr --ambient sh3", USAGE, 2, "'sh3' is not one of 'none'"),
    ("fit hall.exr --floor --ambient sh2", GENERAL, 2, "where there is a floor"),
    ("fit hall.exr --target nosuch", GENERAL, 2, "nosuch"),
    ("fit hall.exr -o rig.yaml", GENERAL, 2, "the suffix must be one of .json, .csv"),
    ("fit hall.exr -o none/rig.json", FILE, 1, "the folder"),
    ("fit hall.exr -o folder.json", FILE, 1, "it is a folder; give the name of a file"),
    ("fit hall.exr --fixed 0,1", GENERAL, 2, "--fixed must be three numbers, such as 0.5,0.7,0.5"),
    ("fit hall.exr --fixed 0,0,0", GENERAL, 2, "must be a unit vector"),
    ("fit hall.exr --start nosuch", GENERAL, 2, "start must be 'greedy' or 'detect' or 'even'"),
    ("fit hall.exr --start none.json", MISSING, 1, "there is no such file; check its path"),
    ("fit hall.exr --objective nosuch", USAGE, 2, "'nosuch' is not one of 'mixed'"),
    ("fit hall.exr --at 0,1", GENERAL, 2, "--at must be three numbers"),
    ("error-curve hall.exr -n 4-", GENERAL, 2, "--lights must be whole numbers and ranges"),
    ("error-curve hall.exr -n 8-4", GENERAL, 2, "lights must hold at least one number"),
    ("error-curve hall.exr -n 0-99999", GENERAL, 2, "--lights must be less than 10000"),
    ("error-curve hall.exr -o curve.yaml", GENERAL, 2, "the suffix must be one of .csv, .json"),
    ("error-curve hall.exr --roughness 2", GENERAL, 2, "roughness must be"),
    ("show hall.exr --max-radius 100", GENERAL, 2, "max_radius must be"),
    ("detect hall.exr --set rise", GENERAL, 2, "--set must be NAME=VALUE of an option of the"),
    ("detect hall.exr --set tolerance=1", GENERAL, 2, "method tree: min_flux_fraction, min_worth"),
    ("detect hall.exr --set rise=0", GENERAL, 2, "rise must"),
    ("split hall.exr --set rise=0", GENERAL, 2, "rise must"),
    ("split hall.exr --set rise=4 --limit 3", GENERAL, 2, "leave out --sun and --limit, or --set"),
    ("split hall.exr -n -1", GENERAL, 2, "lights must be"),
    ("photograph hall.exr --set rise=-1", GENERAL, 2, "rise must"),
    ("photograph hall.exr --fov 200", GENERAL, 2, "fov must"),
    ("convert hall.exr out.exr --to-forward 1", GENERAL, 2, "--to-forward must be three numbers"),
    ("convert hall.exr out.exr --width 1", GENERAL, 2, "width"),
    ("convert hall.exr out.exr --to sphere", GENERAL, 2, "sphere"),
    ("detect hall.exr -n -1", GENERAL, 2, "lights must be a whole number, 0 or more; got -1"),
    ("export rig.json nosuch", GENERAL, 2, "it must be the name of a target (json, csv"),
    ("export rig.json json", GENERAL, 2, "it is the rig; give another name"),
    ("export rig.json a.gltf --strict", FILE, 1, "--strict refuses a file: glTF 2.0 shows"),
    ("show hall.exr -o page.pdf", GENERAL, 2, "the suffix must be .html"),
    ("show hall.exr -n -2", USAGE, 2, "-2 is less than 0"),
    ("compare hall.exr folder", GENERAL, 2, "must both be files, or both be folders"),
    ("compare hall.exr hall.exr --protocol nosuch", GENERAL, 2, "protocol must be"),
    ("view rig.json --rotate 90 -o page.html", GENERAL, 2, "is a rig; leave out --fill"),
    ("view rig.json --fill black -o page.html", GENERAL, 2, "is a rig; leave out --fill"),
    ("batch hall.exr -o rows --suffix .jpg", GENERAL, 2, "the suffix must be one of .json"),
    ("batch hall.exr -o rows --table none/rows.csv", FILE, 1, "none does not exist"),
    ("convert hall.exr ./hall.exr", GENERAL, 2, "it is the map; give another name"),
    ("convert hall.exr -o rig.json/maps", FILE, 1, "cannot make the folder rig.json/maps"),
    ("relight hall.exr --add 0,120,10 -o new.exr", GENERAL, 2, "--add: the elevation in degrees"),
    ("split hall.exr --limit 5 -o rest.exr -o x.png", GENERAL, 2, "a split without --limit"),
    ("fit", USAGE, 2, "Missing argument 'MAP'"),
    ("fit hall.exr --nosuch", USAGE, 2, "No such option"),
    ("nosuch", USAGE, 2, "No such command 'nosuch'"),
]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wrong")
    for name, content in FILES.items():
        (folder / name).write_bytes(content)
    for name in ("folder", "folder.json"):
        (folder / name).mkdir()
    env = el.EnvMap(el.synthetic.hall(64).radiance)
    env.save(folder / "hall.exr")
    (folder / "cut.exr").write_bytes((folder / "hall.exr").read_bytes()[:-3000])
    write_png(folder / "square.png", np.full((64, 64, 3), 0.5, np.float32))
    write_png(folder / "cross.png", np.full((48, 64, 3), 0.5, np.float32))
    el.fit(env, 2).save(folder / "rig.json")
    return folder


@pytest.mark.parametrize(
    ("arguments", "kind", "code", "words"), WRONG, ids=[row[0] for row in WRONG]
)
def test_a_wrong_use_is_refused_with_a_way_out(folder, monkeypatch, arguments, kind, code, words):
    monkeypatch.chdir(folder)
    before = sorted(folder.rglob("*"))
    result = CliRunner().invoke(main, arguments.split())
    assert (result.exit_code, result.stdout) == (code, ""), result.output
    assert words in result.stderr
    assert len(result.stderr.splitlines()) == (1 if kind is not USAGE else 4), result.stderr
    assert sorted(folder.rglob("*")) == before
    assert _class_of(arguments.split()) is kind


#: Uses that are wrong for the map in its file alone.
OF_THE_FILE = (
    "./hall.exr",
    "--add",
    "square.png",
    "cross.png",
    "--faces",
    "--colour",
    "--width",
    "--to",
    "rig.json",
)


@pytest.mark.parametrize(
    "arguments",
    [
        arguments
        for arguments, kind, code, _ in WRONG
        if code == 2
        and kind is GENERAL
        and not any(word in arguments.split() for word in OF_THE_FILE)
        and "folder" not in arguments
    ],
)
def test_wrong_options_are_refused_before_a_file_is_read(folder, monkeypatch, arguments):
    monkeypatch.chdir(folder)
    without_map = arguments.replace("hall.exr", "none.exr")
    done = CliRunner().invoke(main, without_map.split())
    assert done.exit_code == 2, done.output
    assert "no such file" not in done.stderr


def _class_of(arguments):
    """Class of the refusal, which the group turns into an exit code."""
    command = main.get_command(click.Context(main), arguments[0])
    if command is None:
        return USAGE
    try:
        command.main(arguments[1:], standalone_mode=False)
    except el.EnvLightsError as refusal:
        return type(refusal)
    except click.UsageError:
        return USAGE
    return None


def test_a_missing_file_is_a_file_not_found_error():
    for call in (el.EnvMap.open, el.Rig.load, el.Lights.load, el.TransferModel.load):
        with pytest.raises(FileNotFoundError, match="no such file") as refusal:
            call("none.json")
        assert isinstance(refusal.value, el.EnvLightsError)
