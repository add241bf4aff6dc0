"""Projections of pictures: recognition, faces of cubes, and pictures to be saved.

| step                                              | file              |
|---------------------------------------------------|-------------------|
| read one picture, or six faces by their names     | `sources.py`      |
| recognise the projection                          | `recognition.py`  |
| - from the statement of our own files             | `attribute.py`    |
| names, faces and seams of cubes                   | `cubes.py`        |
| save a picture                                    | `picture.py`      |
| tables: projections, conventions of cubes         | `projections.py`, `conventions.py` |
| description of a projection for the kernels       | `layout.py`       |
"""

from envlights.environment.layouts.layout import Layout
from envlights.environment.layouts.recognition import recognise
from envlights.environment.layouts.records import Arguments, ArrangedPicture, Source

__all__ = ["Arguments", "ArrangedPicture", "Layout", "Source", "recognise"]
