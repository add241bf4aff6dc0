"""Decoders from the bytes of a file to its header and samples, in the sample type of the file.

| step                                            | file                                       |
|-------------------------------------------------|--------------------------------------------|
| take a path, bytes or an address; name its kind | `source.py`                                |
| read Radiance, OpenEXR, PNG, JPEG, TIFF in Rust | `native.py`                                |
| read other kinds by OpenImageIO, on request     | `openimageio.py`                           |
| - exposure in EXIF                              | `exif_exposure.py`                         |
| - properties of XMP                             | `xmp.py`                                   |
| read raw files of cameras                       | `raw.py`                                   |
| statement of our own files                      | `description.py`                           |
| content of a file                               | `raw_image.py`                             |
"""
