"""Bytes of a file to its header and samples, in the type of the file.

| step                                            | file                                       |
|-------------------------------------------------|--------------------------------------------|
| take a path, bytes or an address; name its kind | `source.py`                                |
| read Radiance and PNG in Rust                   | `native.py`                                |
| read all other kinds by OpenImageIO             | `openimageio.py`                           |
| - size and XMP of JPEG, tags of TIFF            | `jpeg_segments.py`, `tiff_tags.py`         |
| - exposure in EXIF                              | `exif_exposure.py`                         |
| - properties of XMP                             | `xmp.py`                                   |
| read raw files of cameras                       | `raw.py`                                   |
| statement of our own files                      | `description.py`                           |
| content of a file                               | `raw_image.py`                             |
"""
