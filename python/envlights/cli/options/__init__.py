"""Options that subcommands share.

| options                                          | file                  |
|--------------------------------------------------|-----------------------|
| how a map is read                                | `map_input.py`        |
| fits                                             | `fit_input.py`        |
| detection                                        | `detection_input.py`  |
| suns of clipped maps                             | `sun_input.py`        |
| numbers in a text, such as X,Y,Z                 | `numbers.py`          |
| ``--set`` for arguments without an option        | `settings.py`         |
| output files                                     | `outputs.py`          |
| ``--quiet``                                      | `quiet.py`            |
| ``-`` as the standard input or output            | `standard_streams.py` |
"""
