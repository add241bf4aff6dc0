"""Kind of a file by its first bytes, before any library sees it."""

from __future__ import annotations

from envlights._common.errors import FileError
from envlights.environment.decoders.source import WANTED, Source

#: Bytes that decide.
_LENGTH = 32

#: First bytes of the kinds that are read.
_READ = (
    ("radiance", b"#?"),
    ("openexr", b"\x76\x2f\x31\x01"),
    ("png", b"\x89PNG\r\n\x1a\n"),
    ("jpeg", b"\xff\xd8\xff"),
    ("tiff", b"II*\0"),
    ("tiff", b"MM\0*"),
    ("tiff", b"II+\0"),  # BigTIFF
    ("tiff", b"MM\0+"),
)

#: Way out for photographs of telephones.
_HEIC = "HEIC image (`heif-convert` of libheif writes it as PNG)"

#: Way out for videos, and place and bytes of their formats.
_VIDEO = "video; `ffmpeg -i VIDEO -frames:v 1 frame.png` writes a frame of it"
_OF_VIDEO = (
    *((4, b"ftyp" + brand) for brand in (b"isom", b"iso2", b"mp4", b"avc1", b"qt  ", b"M4V")),
    (0, b"\x1aE\xdf\xa3"),  # Matroska and WebM
    (8, b"AVI "),
)

#: Name, place and bytes of other images, which are read on request. DDS is among them, though cubes
#: are often stored so: its reader had memory faults (CVE-2022-41838, CVE-2022-41999).
_ON_REQUEST = (
    ("GIF image", 0, b"GIF8"),
    ("WebP image", 8, b"WEBP"),
    ("Photoshop file", 0, b"8BPS"),
    (_HEIC, 4, b"ftyphe"),
    (_HEIC, 4, b"ftypmif1"),
    (_HEIC, 4, b"ftypmsf1"),
    ("AVIF image", 4, b"ftypavif"),
    ("Canon raw file", 4, b"ftypcrx"),
    ("DDS texture", 0, b"DDS "),
    ("BMP image", 0, b"BM"),
    ("JPEG XL image", 0, b"\xff\x0a"),
    ("JPEG XL image", 4, b"JXL "),
    ("JPEG 2000 image", 4, b"jP  "),
    ("JPEG 2000 image", 0, b"\xff\x4f\xff\x51"),
    ("PFM image", 0, b"PF"),
    ("PFM image", 0, b"Pf"),
    *((f"PNM image (P{digit})", 0, b"P%d" % digit) for digit in range(1, 8)),
    ("DPX image", 0, b"SDPX"),
    ("DPX image", 0, b"XPDS"),
    ("Cineon image", 0, b"\x80\x2a\x5f\xd7"),
    ("FITS image", 0, b"SIMPLE"),
    ("QOI image", 0, b"qoif"),
    ("Windows icon", 0, b"\0\0\1\0"),
    ("SGI image", 0, b"\x01\xda"),
    ("IFF image", 0, b"FOR4"),
)

#: Way out for textures that no library of ours reads.
_KTX = (
    "KTX texture, which no reader here decodes; `ktx extract` of KTX-Software writes its six faces"
    " as PNG or OpenEXR: give those"
)

#: Name, place and bytes of files that are no images.
_NO_IMAGE = (
    (_KTX, 1, b"KTX "),
    ("web page", 0, b"<!DOCTYPE html"),
    ("web page", 0, b"<!doctype html"),
    ("web page", 0, b"<html"),
    ("text of XML or SVG", 0, b"<?xml"),
    ("drawing (SVG)", 0, b"<svg"),
    (
        "pointer of Git LFS, not the file itself: `git lfs pull` fetches it",
        0,
        b"version https://git-lfs",
    ),
    ("ZIP archive", 0, b"PK\x03\x04"),
    ("gzip archive", 0, b"\x1f\x8b"),
    ("PDF document", 0, b"%PDF"),
    ("NumPy array, which `numpy.load` reads", 0, b"\x93NUMPY"),
    ("Blender file", 0, b"BLENDER"),
    ("JSON text, perhaps a rig, which `Rig.load` and `envlights export` read", 0, b"{"),
    *((_VIDEO, place, mark) for place, mark in _OF_VIDEO),
)


def kind_of(source: Source, *, any_format: bool) -> str:
    """Kind of a file; empty for one that is left to OpenImageIO with `any_format`.

    Raises
    ------
    EnvLightsError
        If the first bytes are of another kind and `any_format` is False.
    """
    head = source.head(_LENGTH)
    for kind, start in _READ:
        if head.startswith(start):
            return kind
    if any_format and not head.startswith(b"KTX ", 1):
        # DDS has its own reader, so no other reader tries the file.
        return "dds" if head.startswith(b"DDS ") else ""
    name = _name(head, _ON_REQUEST)
    if name:
        raise FileError(
            f"cannot read {source.name}: it looks like a {name}, which is read only with"
            f" any_format=True; {WANTED}"
        )
    name = _name(head, _NO_IMAGE)
    if name:
        raise FileError(f"cannot read {source.name}: it looks like a {name}; {WANTED}")
    raise FileError(
        f"cannot read {source.name}: its first bytes are of no known image; {WANTED}, or"
        " any_format=True"
    )


def _name(head: bytes, kinds: tuple[tuple[str, int, bytes], ...]) -> str:
    for name, place, mark in kinds:
        if head[place : place + len(mark)] == mark:
            return name
    return ""
