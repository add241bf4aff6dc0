"""Conversion of the samples of a file to linear Rec.709.

| step                                         | file                            |
|----------------------------------------------|---------------------------------|
| choose among the statements of a file        | `choice.py`                     |
| colour spaces with a name                    | `colour_spaces.py`              |
| ICC profiles                                 | `icc.py`                        |
| transfer curves, and primaries               | `transfer_curves.py`, `primaries.py` |
| apply them                                   | `linear.py`                     |
| coverage by alpha                            | `alpha.py`                      |
"""
