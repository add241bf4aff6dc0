"""Files of pictures: reading in steps, and writing.

| step                                    | file                              |
|-----------------------------------------|-----------------------------------|
| choose a part and its channels          | `channels.py`                     |
| place the picture on the sphere         | `placement.py`, `gpano.py`        |
| statements on the projection            | `hints.py`, `focal_length.py`     |
| the steps in order; six files of a cube | `images.py`                       |
| reduce a file row by row for a fit      | `reduced_file.py`                 |
| write pictures                          | `image_output.py`                 |
"""
