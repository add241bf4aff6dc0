"""Readers of images, and writers of files.

| step                                              | file              |
|---------------------------------------------------|-------------------|
| read images; a file's colour space                | `images.py`       |
| write images                                      | `image_output.py` |
| merge exposures into one image                    | `exposures/`      |
| read raw files of cameras                         | `raw.py`          |
| check PNG files before they are read              | `png.py`          |
| OpenImageIO, loaded when it is first needed       | `openimageio.py`  |
| write any file safely                             | `files.py`        |
| read the package's own JSON                       | `own_json.py`     |
| read tables of lights                             | `csv_table.py`    |
"""

from envlights.io.files import check_writable, write_atomically
from envlights.io.image_output import write_exr, write_hdr
from envlights.io.images import Image, read_image

__all__ = [
    "Image",
    "check_writable",
    "read_image",
    "write_atomically",
    "write_exr",
    "write_hdr",
]


def __dir__() -> list[str]:
    return sorted(__all__)
