"""Readers of images, and writers of files.

| step                                          | file                                             |
|-----------------------------------------------|--------------------------------------------------|
| take a path, bytes, a file object, an address | `source.py`                                      |
| tell the kind of a file by its first bytes    | `signature.py`                                   |
| read Radiance and PNG in Rust                 | `native.py`                                      |
| read all other kinds by OpenImageIO           | `openimageio.py`                                 |
| - size and XMP of JPEG, tags of TIFF          | `jpeg_segments.py`, `tiff_tags.py`               |
| choose a part and its channels                | `channels.py`                                    |
| find the layout that our own files state      | `description.py`                                 |
| place the picture on the sphere               | `placement.py`, `gpano.py`, `xmp.py`             |
| find what alpha hides                         | `alpha.py`                                       |
| choose among a file's statements on colour    | `colour.py`, `colour_spaces.py`, `icc.py`        |
| convert codes                                 | `linear.py`, `transfer_curves.py`                |
| convert primaries to Rec.709                  | `primaries.py`                                   |
| the steps in order                            | `images.py`                                      |
| reduce a file row by row for a fit            | `reduced_file.py`                                |
| exposure and focal length of EXIF             | `exif_exposure.py`, `focal_length.py`            |
| merge exposures into one image                | `exposures/`                                     |
| read raw files of cameras                     | `raw.py`                                         |
| write images                                  | `image_output.py`                                |
| write any file safely                         | `files.py`                                       |
| read the package's own JSON                   | `own_json.py`                                    |
| read tables of lights                         | `csv_table.py`                                   |
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
