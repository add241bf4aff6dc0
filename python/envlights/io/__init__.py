"""Images in, files out."""

from envlights.io.files import check_writable, write_atomically
from envlights.io.images import Image, decode_srgb, read_image, write_exr

__all__ = [
    "Image",
    "check_writable",
    "decode_srgb",
    "read_image",
    "write_atomically",
    "write_exr",
]
