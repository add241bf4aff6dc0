"""Projections of pictures: recognition, faces of cubes, and pictures to be saved.

| step                                              | file              |
|---------------------------------------------------|-------------------|
| recognise the projection                          | `recognition.py`  |
| - from the statement of our own files             | `attribute.py`    |
| names, faces and seams of cubes                   | `cubes.py`        |
| save a picture                                    | `picture.py`      |
| tables: projections, conventions of cubes         | `projections.py`, `conventions.py` |
| description of a projection for the kernels       | `picture_layout.py` |
"""

from envlights.environment.layouts.picture_layout import PictureLayout
from envlights.environment.layouts.recognition import recognise
from envlights.environment.layouts.records import Arguments, ArrangedPicture, Origin

__all__ = ["Arguments", "ArrangedPicture", "Origin", "PictureLayout", "recognise"]
