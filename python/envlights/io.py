"""Readers of images, and writers of files."""

from envlights._common.errors import DamagedFileError, MissingFileError
from envlights._common.files import check_writable, write_atomically
from envlights.environment.files.image_output import write_exr, write_hdr
from envlights.environment.files.images import Image, read_image
from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.environment.layouts.projections import Layout

__all__ = [
    "DamagedFileError",
    "Image",
    "Layout",
    "MissingFileError",
    "PictureLayout",
    "check_writable",
    "read_image",
    "write_atomically",
    "write_exr",
    "write_hdr",
]


def __dir__() -> list[str]:
    return sorted(__all__)
