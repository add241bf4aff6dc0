"""The environment map, and the conversion of pictures to it.

| step                                                   | place                          |
|--------------------------------------------------------|--------------------------------|
| the six steps of opening, in order                     | `open.py`                      |
| decode the bytes of a file                             | `decoders/`                    |
| read one picture, or six faces by their names          | `picture_files.py`             |
| choose the channels, place the picture, write pictures | `files/`                       |
| convert samples to linear Rec.709                      | `colour/`                      |
| recognise the layout                                   | `layouts/`                     |
| clean the samples                                      | `clean.py`                     |
| find codes of a picture that are kept as floats        | `files/whole_numbers.py`       |
| resample to an equirectangular map                     | `resample.py`                  |
| merge exposures                                        | `exposures/`                   |
| reduce the rows of a file for a fit                    | `reduced_file.py`              |
| the map with its methods                               | `envmap.py`                    |
| maps of arguments, and the options on reading them     | `reading.py`                   |
"""
