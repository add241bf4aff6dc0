"""The published methods, step by step on their kernels.

| paper                                                        | file                            |
|--------------------------------------------------------------|---------------------------------|
| Loghin (2021): detection in a map                            | `loghin.py`, `loghin_steps.py`  |
| the same in a photograph                                     | `photograph.py` and the files `photograph_*.py` |
| Madsen, Sørensen and Vittrup (2003): the fit                 | `madsen.py`                     |
"""

from envlights.papers import loghin, madsen
from envlights.papers.madsen import PaperFit
from envlights.papers.photograph_lights import PhotographLight, PhotographLights

__all__ = [
    "PaperFit",
    "PhotographLight",
    "PhotographLights",
    "loghin",
    "madsen",
]
