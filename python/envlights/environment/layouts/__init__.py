"""Projections of pictures: recognition, cube faces, and pictures to save.

| step                                              | file              |
|---------------------------------------------------|-------------------|
| recognise the projection                          | `recognition.py`  |
| - from the statement of our own files             | `attribute.py`    |
| arrange the faces of a cube                       | `cubes.py`        |
| - names of files, faces in a picture, seams       | `face_names.py`, `faces.py`, `seams.py` |
| save a picture                                    | `picture.py`      |
| layouts that a user can name; orders of cubes     | `projections.py`, `conventions.py` |
| layout of a picture of one size, for the kernels  | `picture_layout.py` |
"""

from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.environment.layouts.projections import Layout
from envlights.environment.layouts.recognition import recognise
from envlights.environment.layouts.records import ArrangedPicture, Origin

__all__ = ["ArrangedPicture", "Layout", "Origin", "PictureLayout", "recognise"]
