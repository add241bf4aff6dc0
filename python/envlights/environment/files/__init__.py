"""Picture files: reading step by step, and writing.

| step                                    | file                              |
|-----------------------------------------|-----------------------------------|
| choose a part and its channels          | `channels.py`                     |
| place the picture on the sphere         | `placement.py`, `gpano.py`        |
| statements on the projection            | `hints.py`, `focal_length.py`     |
| the steps in order                      | `images.py`                       |
| write pictures                          | `image_output.py`                 |
"""
